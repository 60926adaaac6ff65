//! The reduced model on a GPU against the far field of the Rust model. Mesa's lavapipe is enough.

use crate::common::device;
use crate::far_field::peaks;
use crate::near_field::fibers;
use bytemuck::cast_slice;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use vellus::glam::Vec3;
use vellus::{Bcsdf, Fiber, ScatterExit, Species, Window};
use vellus_gpu::{Device, DeviceError, reduced_library};
use vellus_testing::Uniform;

/// wo, wi, and `VellusFur`.
type Query = [[f32; 4]; 6];

fn query(fiber: &Fiber, wo: Vec3, wi: Vec3) -> Query {
    let f = fiber.in_air();
    let rgb = |[r, g, b]: [f32; 3]| [r, g, b, 0.0];
    let [wo, wi] = [wo, wi].map(|w| rgb(w.to_array()));
    let shape = [[f.eta, f.kappa, f.alpha, f.beta_m], [f.beta_n, f.layers, f.sigma_ms, f.g]];
    [wo, wi, shape[0], shape[1], rgb(f.sigma_ca), rgb(f.sigma_ma)]
}

/// f cos and the energy.
type Answer = [[f32; 4]; 2];

fn ask(device: &Device, queries: &[Query]) -> Result<Vec<Answer>, DeviceError> {
    let source = reduced_library()
        + "
        struct Query { wo: vec3<f32>, wi: vec3<f32>, fur: VellusFur }
        @group(0) @binding(0) var<storage, read> queries: array<Query>;
        @group(0) @binding(1) var<storage, read_write> answers: array<array<vec4<f32>, 2>>;
        @compute @workgroup_size(64) fn run(@builtin(global_invocation_id) id: vec3<u32>) {
            if id.x < arrayLength(&queries) {
                var hit: VellusReduced;
                vellus_reduced_hit(&hit, queries[id.x].fur, queries[id.x].wo);
                answers[id.x][0] = vec4<f32>(vellus_reduced_eval(&hit, queries[id.x].wi), 0.0);
                answers[id.x][1] = vec4<f32>(vellus_reduced_energy(&hit), 0.0);
            }
        }";
    let groups = queries.len().div_ceil(64) as u32;
    device.compute(&source, "run", &[cast_slice(queries)], queries.len(), groups)
}

/// The largest difference of a channel.
fn difference(ours: [f32; 4], expected: [f32; 3]) -> f32 {
    ours.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

fn statistics(what: &str, mut errors: Vec<f32>) -> [f32; 3] {
    errors.sort_by(f32::total_cmp);
    let at = |share: f64| errors[((errors.len() - 1) as f64 * share) as usize];
    let mean = errors.iter().sum::<f32>() / errors.len() as f32;
    println!("{what}: mean {mean:.4}, 95 % {:.4}, 99 % {:.4}, worst {:.4}", at(0.95), at(0.99), at(1.0));
    [mean, at(0.99), at(1.0)]
}

/// Differences of f cos relative to the largest value of a hit, and of the energy. Half of the directions are where the
/// fibre scatters most light.
fn compare(device: &Device, fibers: &[Fiber], what: &str) -> Result<[[f32; 3]; 2], Box<dyn std::error::Error>> {
    let models = fibers.iter().map(Bcsdf::new).collect::<Result<Vec<_>, _>>()?;
    let mut random = Uniform(1);
    let (mut queries, mut expected) = (Vec::new(), Vec::new());
    for k in 0..8_000 {
        let index = k % models.len();
        let wo = vellus::direction(random.within(-1.5, 1.5), random.within(-3.1, 3.1));
        let hit = models[index].at(wo, Window::far());
        let wi = random.outgoing(&hit, k / models.len());
        queries.push(query(&fibers[index], wo, wi));
        expected.push((hit.eval(wi).total(), peaks(&hit, wi, &mut random)[0], hit.energy().total()));
    }
    let answers = ask(device, &queries)?;
    let pairs = || answers.iter().zip(&expected);
    let values = pairs().map(|([value, _], (total, peak, _))| difference(*value, *total) / peak);
    let energies = pairs().map(|([_, energy], (.., total))| difference(*energy, *total));
    Ok([
        statistics(&format!("{what}: f cos"), values.collect()),
        statistics(&format!("{what}: energy"), energies.collect()),
    ])
}

#[test]
fn differences_from_the_far_field() -> Result<(), Box<dyn std::error::Error>> {
    let Some(device) = device() else { return Ok(()) };
    let presets = Species::ALL.map(Fiber::preset);
    let random: Vec<Fiber> =
        fibers(400).into_iter().skip(2 * presets.len() + 1).filter(|f| f.exit == ScatterExit::Reflecting).collect();
    let [value, energy] = compare(&device, &presets, "presets")?;
    assert!(value[0] < 0.02 && value[1] < 0.12 && energy[0] < 0.012 && energy[2] < 0.05, "{value:?} {energy:?}");
    let [value, energy] = compare(&device, &random, "random fibres")?;
    assert!(value[0] < 0.025 && value[1] < 0.3 && energy[0] < 0.03 && energy[1] < 0.2, "{value:?} {energy:?}");
    Ok(())
}

/// The integral of f cos over all directions is the energy, and that of a white fibre is 1.
#[test]
fn white_fur_stays_white() -> Result<(), Box<dyn std::error::Error>> {
    const NODES: [usize; 2] = [96, 128];
    let Some(device) = device() else { return Ok(()) };
    let furs = Species::ALL.map(|species| Fiber::preset(species).without_absorption());
    let (mut queries, mut cosines) = (Vec::new(), Vec::new());
    for fiber in &furs {
        for theta_o in [0.0, 0.4, 0.8, 1.2] {
            for k in 0..NODES[0] * NODES[1] {
                let theta = ((k / NODES[1]) as f64 + 0.5) / NODES[0] as f64 * PI - FRAC_PI_2;
                let wi = vellus::direction(theta, (k % NODES[1]) as f64 / NODES[1] as f64 * TAU);
                queries.push(query(fiber, vellus::direction(theta_o, 1.0), wi));
                cosines.push(theta.cos());
            }
        }
    }
    let answers = ask(&device, &queries)?;
    let cell = PI * TAU / (NODES[0] * NODES[1]) as f64;
    let mut worst = [0.0f64; 2];
    for (answers, cosines) in answers.chunks(NODES[0] * NODES[1]).zip(cosines.chunks(NODES[0] * NODES[1])) {
        let integral: f64 = answers.iter().zip(cosines).map(|([value, _], cos)| f64::from(value[1]) * cos * cell).sum();
        let [_, energy] = answers[0];
        worst[0] = worst[0].max((integral - 1.0).abs());
        worst[1] = worst[1].max((integral - f64::from(energy[1])).abs());
    }
    println!("white: the integral differs from 1 by {:.4}, and from the energy by {:.4}", worst[0], worst[1]);
    assert!(worst.iter().all(|x| *x < 0.01), "{worst:?}");
    Ok(())
}
