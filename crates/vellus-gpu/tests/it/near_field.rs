//! The shader library on a GPU against the Rust model. Mesa's lavapipe is enough.

use crate::common::device;
use bytemuck::cast_slice;
use vellus::glam::Vec3;
use vellus::{Bcsdf, Fiber, Hit, ScatterExit, Species, Window};
use vellus_gpu::{Answer, Device, DeviceError, Field, Queries, Query, shader_fiber, shader_tables_half};
use vellus_testing::Uniform;
use vellus_testing::sphere::ChiSquared;
use vellus_testing::vectors::{Vector, Vectors};

/// Fibres over the whole range of parameters, with both exits, and all presets.
pub fn fibers(count: usize) -> Vec<Fiber> {
    let mut random = Uniform(7);
    let mut fibers: Vec<Fiber> =
        Species::ALL.into_iter().flat_map(|s| [Fiber::preset(s), Fiber::published(s)]).collect();
    fibers.push(Fiber::hair());
    while fibers.len() < count {
        let exit = ScatterExit::ALL[fibers.len() % 2];
        fibers.push(Fiber { exit, medulla_air: 0.0, ..random.fiber() });
    }
    fibers
}

/// The largest difference relative to `scale`.
fn difference(ours: &[f32], expected: &[f32], scale: f32) -> f32 {
    ours.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) / scale
}

/// The largest value of f·cos θᵢ, and the largest density, over directions where the fibre scatters most light.
fn peaks(hit: &Hit<'_>, wi: Vec3, random: &mut Uniform) -> [f32; 2] {
    let mut peaks = [0.0f32; 2];
    let directions = (0..24).filter_map(|_| hit.sample(random.numbers()).map(|sample| sample.wi));
    for wi in directions.chain([wi]) {
        let (lobes, pdf) = hit.eval_pdf(wi);
        peaks[0] = lobes.0.as_flattened().iter().fold(peaks[0], |a, b| a.max(*b));
        peaks[1] = peaks[1].max(pdf);
    }
    peaks
}

#[test]
fn golden_vectors() -> Result<(), Box<dyn std::error::Error>> {
    let Some(device) = device() else { return Ok(()) };
    let vectors = Vectors::read();
    let models = vectors.fibers.iter().map(Bcsdf::new).collect::<Result<Vec<_>, _>>()?;
    let near: Vec<&Vector> = vectors.queries.iter().filter(|q| q.window[0] == q.window[1]).collect();
    let ask = |q: &&Vector| Query {
        wo: q.wo.to_array(),
        h: q.window[0],
        wi: q.wi.to_array(),
        fiber: q.fiber as u32,
        u: [0.5; 4],
    };
    let answers = Queries::new(&device, &models)?.run(&near.iter().map(ask).collect::<Vec<_>>())?;
    let worst = near.iter().zip(&answers).map(|(q, answer)| q.error(answer.value)).fold(0.0, f32::max);
    println!("{} queries, largest error {worst:.2} tolerances", near.len());
    assert!(near.len() == 1000 && worst <= 1.0, "{worst}");
    Ok(())
}

/// 100,000 queries of fibres.
fn queries(models: &[Bcsdf<'_>]) -> Vec<Query> {
    let mut random = Uniform(1);
    (0..100_000)
        .map(|k| {
            let fiber = k % models.len();
            let wo = vellus::direction(random.within(-1.55, 1.55), random.within(-3.1, 3.1));
            let h = random.within(-1.0, 1.0) as f32;
            let wi = random.outgoing(&models[fiber].at(wo, Window::near(h)), k / models.len());
            Query { wo: wo.to_array(), h, wi: wi.to_array(), fiber: fiber as u32, u: random.numbers() }
        })
        .collect()
}

/// The largest differences of a value, a lobe and a density from those of the model of each query, relative to the
/// largest of the hit, and of an energy. Then the distances of sampled directions.
pub fn differences<'b>(
    queries: &[Query],
    answers: &[Answer],
    model: impl Fn(usize) -> &'b Bcsdf<'static>,
) -> ([f32; 4], Vec<f32>) {
    let mut random = Uniform(2);
    let (mut worst, mut distances) = ([0.0f32; 4], Vec::new());
    for (k, (query, answer)) in queries.iter().zip(answers).enumerate() {
        let (wo, wi) = (Vec3::from(query.wo), Vec3::from(query.wi));
        let hit = model(k).at(wo, Window::near(query.h));
        let (lobes, pdf) = hit.eval_pdf(wi);
        let [peak, densest] = peaks(&hit, wi, &mut random);
        let flat = |rows: &[[f32; 4]; 6]| rows.iter().flat_map(|row| [row[0], row[1], row[2]]).collect::<Vec<f32>>();
        let errors = [
            difference(&answer.value, &lobes.total(), peak),
            difference(&flat(&answer.lobes), lobes.0.as_flattened(), peak),
            difference(&[answer.pdf], &[pdf], densest),
            difference(&flat(&answer.energy), hit.energy().0.as_flattened(), 1.0),
        ];
        worst.iter_mut().zip(errors).for_each(|(worst, error)| *worst = worst.max(error));
        assert!(answer.weight.iter().all(|w| (0.0..=1.0 + 1e-5).contains(w)), "{query:?} {answer:?}");
        let [a, b, c, d] = query.u;
        let Some(sample) = hit.sample([a, b, c, d, 0.5]) else { continue };
        let distance = (sample.wi - Vec3::from(answer.wi)).length();
        distances.push(if sample.lobe as usize as f32 == answer.lobe { distance } else { 2.0 });
    }
    let [value, lobes, density, energy] = worst;
    println!("of the peak: value {value:.1e}, lobes {lobes:.1e}, density {density:.1e}; energy {energy:.1e}");
    distances.sort_by(f32::total_cmp);
    println!("sampled directions: {} beyond 1e-3, {} beyond 1e-2", beyond(&distances, 1e-3), beyond(&distances, 1e-2));
    (worst, distances)
}

/// The number of sampled directions that are further off.
fn beyond(distances: &[f32], most: f32) -> usize {
    distances.len() - distances.partition_point(|distance| *distance <= most)
}

#[test]
fn values_equal_those_of_the_model() -> Result<(), Box<dyn std::error::Error>> {
    let Some(device) = device() else { return Ok(()) };
    let models = fibers(400).iter().map(Bcsdf::new).collect::<Result<Vec<_>, _>>()?;
    let queries = queries(&models);
    let answers = Queries::new(&device, &models)?.run(&queries)?;
    let (worst, distances) = differences(&queries, &answers, |k| &models[queries[k].fiber as usize]);
    assert!(worst.iter().all(|error| *error < 2e-4), "{worst:?}");
    // A number of the sampler that differs by a rounding may choose another component. There are at most 80 limits.
    assert!(beyond(&distances, 1e-3) < 100);
    Ok(())
}

/// Answers with tables in half precision.
fn run_half(device: &Device, models: &[Bcsdf<'_>], queries: &[Query]) -> Result<Vec<Answer>, DeviceError> {
    let read = "vec4<f32>(unpack2x16float(vellus_tables[row].x), unpack2x16float(vellus_tables[row].y))";
    let shader = Field::Near
        .shader()
        .replace("vellus_tables: array<vec4<f32>>", "vellus_tables: array<vec2<u32>>")
        .replace("return vellus_tables[row]", &format!("return {read}"));
    let (tables, records) = (shader_tables_half(), models.iter().flat_map(shader_fiber).collect::<Vec<_>>());
    let inputs = [cast_slice(&tables), cast_slice(&records), cast_slice(queries)];
    device.compute(&shader, Field::Near.entry(), &inputs, queries.len(), queries.len().div_ceil(64) as u32)
}

/// Half floats have 11 bits, so that a number of the tables is off by at most 2.4e-4 of itself, or 3e-8. Values are
/// sums of positive terms. Where light is rare, a small error of its cumulative density moves a sampled direction far.
#[test]
fn tables_in_half_precision() -> Result<(), Box<dyn std::error::Error>> {
    let Some(device) = device() else { return Ok(()) };
    let models = fibers(400).iter().map(Bcsdf::new).collect::<Result<Vec<_>, _>>()?;
    let queries = queries(&models);
    let answers = run_half(&device, &models, &queries)?;
    let (worst, distances) = differences(&queries, &answers, |k| &models[queries[k].fiber as usize]);
    assert!(worst.iter().all(|error| *error < 5e-4), "{worst:?}");
    assert!(beyond(&distances, 1e-2) < 1000);
    Ok(())
}

#[test]
fn sampled_directions_follow_their_density() -> Result<(), Box<dyn std::error::Error>> {
    let Some(device) = device() else { return Ok(()) };
    let fibers = fibers(64);
    let models = fibers.iter().map(Bcsdf::new).collect::<Result<Vec<_>, _>>()?;
    let test = ChiSquared { cells: [24, 24], samples: 20_000, nodes: [576, 576], tests: 16 };
    let mut random = Uniform(3);
    // Lobes that are wider than the midpoints of a cell.
    let wide = |fiber: &Fiber| fiber.beta_m > 0.12 && fiber.beta_n > 0.12 && fiber.g < 0.8;
    let mut queries = Vec::new();
    for fiber in (0..models.len()).filter(|&k| wide(&fibers[k])).take(test.tests / 2) {
        let wo = vellus::direction(random.within(-1.2, 1.2), random.within(-3.1, 3.1)).to_array();
        let h = random.within(-0.95, 0.95) as f32;
        let ask = |_| Query { wo, h, wi: [1.0, 0.0, 0.0], fiber: fiber as u32, u: random.numbers() };
        queries.extend((0..test.samples).map(ask));
    }
    let answers = [Queries::new(&device, &models)?.run(&queries)?, run_half(&device, &models, &queries)?];
    for answers in &answers {
        for (queries, answers) in queries.chunks(test.samples).zip(answers.chunks(test.samples)) {
            let Query { wo, h, fiber, .. } = queries[0];
            let hit = models[fiber as usize].at(Vec3::from(wo), Window::near(h));
            let mut answers = answers.iter();
            let next = || answers.next().map_or(Vec3::X, |answer| Vec3::from(answer.wi));
            test.check(next, |wi| hit.pdf(wi)).map_err(|e| format!("fibre {fiber}: {e}"))?;
        }
    }
    Ok(())
}

#[test]
fn a_white_fibre_loses_nothing() -> Result<(), Box<dyn std::error::Error>> {
    let Some(device) = device() else { return Ok(()) };
    let models = [ScatterExit::Open, ScatterExit::Reflecting]
        .map(|exit| Fiber { kappa: 0.8, sigma_ms: 2.0, g: 0.4, exit, ..Fiber::hair() }.without_absorption());
    let models = models.iter().map(Bcsdf::new).collect::<Result<Vec<_>, _>>()?;
    let mut random = Uniform(5);
    let queries: Vec<Query> = (0..20_000)
        .map(|k| {
            let wo = vellus::direction(random.within(-1.4, 1.4), random.within(-3.1, 3.1)).to_array();
            let h = random.within(-1.0, 1.0) as f32;
            Query { wo, h, wi: [1.0, 0.0, 0.0], fiber: k % 2, u: random.numbers() }
        })
        .collect();
    let answers = Queries::new(&device, &models)?.run(&queries)?;
    // The estimate of the energy by samples: no single weight may differ by more than half a per cent.
    for (query, answer) in queries.iter().zip(&answers) {
        let hit = models[query.fiber as usize].at(Vec3::from(query.wo), Window::near(query.h));
        let expected: f32 = hit.energy().total()[0];
        assert!(answer.wi_pdf == 0.0 || (answer.weight[0] - expected).abs() < 5e-3, "{query:?} {answer:?} {expected}");
    }
    Ok(())
}
