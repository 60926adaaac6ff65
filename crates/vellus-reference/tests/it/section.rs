//! Fibres whose section is an ellipse (D23), and those with air in the medulla (D24), compared with the photon tracer.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use vellus::{Bcsdf, Fiber, Species, Window, direction};
use vellus_reference::simulate::azimuth::{BINS, all_azimuths};
use vellus_reference::simulate::energies::{Offsets, energies};
use vellus_reference::simulate::profile::{Cells, profile};
use vellus_testing::{Uniform, effort};

/// Points of the model in a bin.
const WITHIN: usize = 16;

/// Inclinations of the light.
const THETA: [f64; 2] = [0.0, PI / 3.0];

/// Errors of the total and L1, mean and worst: `docs/book/src/fibers.md`.
const HAIR: [[f64; 2]; 2] = [[0.008, 0.062], [0.017, 0.301]];
const FUR: [[f64; 2]; 2] = [[0.01, 0.083], [0.059, 0.142]];

/// The model's light in each bin, in the first channel.
fn ours(fiber: &Fiber, [theta_o, phi_o]: [f64; 2]) -> [f64; BINS] {
    let bcsdf = Bcsdf::new(fiber).unwrap();
    let hit = bcsdf.at(direction(theta_o, phi_o), Window::far());
    let step = TAU / (BINS * WITHIN) as f64;
    let mut bins = [0.0; BINS];
    for k in 0..BINS * WITHIN {
        let light = hit.azimuthal(((k as f64 + 0.5) * step) as f32).total()[0];
        bins[k / WITHIN] += step * f64::from(light);
    }
    bins
}

/// The error of the total, and Σ |a − b| over the bins, both relative to the light of `b`.
fn errors(a: &[f64], b: &[f64]) -> [f64; 2] {
    let sum = |x: &[f64]| x.iter().sum::<f64>();
    let l1 = a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>();
    [(sum(a) / sum(b) - 1.0).abs(), l1 / sum(b)]
}

/// A fibre with a nearly smooth cuticle, as the tracer has it: the lobes are narrower than the bins.
fn smooth(fiber: Fiber) -> Fiber {
    Fiber { alpha: 0.0, beta_m: 1f32.to_radians(), beta_n: 1f32.to_radians(), ..fiber }
}

fn mean(all: &[[f64; 2]]) -> [f64; 2] {
    [0, 1].map(|k| all.iter().map(|e| e[k]).sum::<f64>() / all.len() as f64)
}

fn worst(all: &[[f64; 2]]) -> [f64; 2] {
    [0, 1].map(|k| all.iter().map(|e| e[k]).fold(0.0, f64::max))
}

/// Of sections of 1.5 : 1, at 0° and 60°, from three sides: the light in bins of 15° beside that of the tracer.
/// "Before" is the model of a round fibre. The noise of the tracer adds about 1.5 % to the distances with 30,000
/// photons.
#[test]
fn flat_fibres_match_the_tracer() {
    let photons = effort(30_000, 1_000_000);
    let hair = Fiber::hair().with_absorption([0.2; 3]);
    let furs = Species::ALL.into_iter().filter(|species| *species != Species::Human).map(Fiber::preset);
    let hairs = vec![hair, Fiber::preset(Species::Human)];
    for (name, fibers, known) in [("hair", hairs, HAIR), ("fur", furs.collect(), FUR)] {
        let (mut before, mut after) = (Vec::new(), Vec::new());
        for fiber in fibers {
            for (theta_o, phi_o) in THETA.into_iter().flat_map(|t| [0.0, PI / 4.0, PI / 2.0].map(|p| (t, p))) {
                let [round, flat] = [1.0, 2.0 / 3.0].map(|aspect_ratio| smooth(Fiber { aspect_ratio, ..fiber }));
                let traced = all_azimuths(&flat, [theta_o, phi_o], Offsets::Whole, photons, 1).unwrap();
                let traced = traced.map(|bin| bin[0]);
                before.push(errors(&ours(&round, [theta_o, phi_o]), &traced));
                after.push(errors(&ours(&flat, [theta_o, phi_o]), &traced));
            }
        }
        let found = [mean(&before), worst(&before), mean(&after), worst(&after)];
        println!("{name}: total and L1, mean and worst, before and after: {found:.3?}");
        // Means and worst values of the book, four standard errors of a total, and the noise of the distances.
        let noise = [4.0 / (photons as f64).sqrt(), 3.0 / (photons as f64).sqrt()];
        for k in 0..2 {
            assert!(
                found[2][k] <= known[0][k] + noise[k] && found[3][k] <= known[1][k] + noise[k],
                "{name}: {found:?}"
            );
        }
        assert!(mean(&before)[1] > 1.5 * mean(&after)[1], "{name}: {found:?}");
    }
}

/// The share of air for a medulla of this index, which is at most η.
fn air(fiber: &Fiber, eta_m: f32) -> f32 {
    (fiber.eta - eta_m) / (fiber.eta - 1.0)
}

/// The presets, and a hair with a medulla.
fn fibers() -> Vec<Fiber> {
    let hair = Fiber::hair().with_absorption([0.4; 3]);
    let hair = Fiber { kappa: 0.36, sigma_ms: 2.5, sigma_ma: [0.05; 3], g: 0.3, ..hair };
    Species::ALL.into_iter().map(Fiber::preset).chain([hair]).collect()
}

/// Errors of the total and L1 over the azimuth, for indices of the medulla: mean without air, then mean and worst.
const AIR: [(f32, [[f64; 2]; 3]); 3] = [
    (1.0, [[0.124, 0.164], [0.001, 0.039], [0.004, 0.1]]),
    (1.2, [[0.096, 0.13], [0.003, 0.018], [0.008, 0.033]]),
    (1.4, [[0.055, 0.074], [0.005, 0.019], [0.016, 0.034]]),
];

/// Errors of 100 random fibres, mean and worst, for round ones with air and for flat ones without. Where η is above 2,
/// much light is totally reflected many times, and later passes through an ellipse are unlike the first.
const RANDOM: [(&str, bool, [[f64; 2]; 2]); 2] =
    [("air", false, [[0.002, 0.029], [0.021, 0.127]]), ("flat", true, [[0.014, 0.056], [0.156, 0.341]])];

/// Presets and hair at 0° and 60°, in 15° of azimuth.
#[test]
fn medullas_with_air_match_the_tracer() {
    let photons = effort(20_000, 1_000_000);
    for (eta_m, known) in AIR {
        let (mut before, mut after) = (Vec::new(), Vec::new());
        for fiber in fibers().into_iter().filter(|fiber| fiber.eta > eta_m) {
            for theta_o in THETA {
                let [without, with] =
                    [0.0, air(&fiber, eta_m)].map(|medulla_air| smooth(Fiber { medulla_air, ..fiber }));
                let traced = all_azimuths(&with, [theta_o, 0.0], Offsets::Whole, photons, 1).unwrap().map(|bin| bin[0]);
                before.push(errors(&ours(&without, [theta_o, 0.0]), &traced));
                after.push(errors(&ours(&with, [theta_o, 0.0]), &traced));
            }
        }
        let found = [mean(&before), mean(&after), worst(&after)];
        println!("{eta_m}: total and L1, mean without air, mean and worst: {found:.4?}");
        let noise = [4.0 / (photons as f64).sqrt(), 3.0 / (photons as f64).sqrt()];
        for (found, known) in found.iter().zip(known).skip(1) {
            assert!((0..2).all(|k| found[k] <= known[k] + noise[k]), "{eta_m}: {found:?}");
        }
        assert!(found[0][0] > 5.0 * found[1][0] && found[0][1] > 1.5 * found[1][1], "{eta_m}: {found:?}");
    }
}

/// Random fibres with random air, a third of them with nothing else in the medulla, and random flat fibres.
#[test]
fn random_sections_match_the_tracer() {
    let photons = effort(10_000, 200_000);
    for (name, is_flat, known) in RANDOM {
        let mut random = Uniform(24);
        let mut found = Vec::new();
        for k in 0..effort(20, 100) {
            let medulla_air = if k % 3 == 0 { 1.0 } else { random.next() as f32 };
            let fiber = random.fiber();
            // Photons take long in dense medullas.
            let fiber = smooth(Fiber { medulla_air, sigma_ms: fiber.sigma_ms.min(8.0), ..fiber });
            let [theta_o, phi_o] = [random.within(0.0, 1.31), random.within(0.0, PI)];
            let aspect_ratio = random.within(0.4, 1.0) as f32;
            let fiber = if is_flat { Fiber { aspect_ratio, medulla_air: 0.0, ..fiber } } else { fiber };
            let traced = all_azimuths(&fiber, [theta_o, phi_o], Offsets::Whole, photons, k).unwrap().map(|bin| bin[0]);
            found.push(errors(&ours(&fiber, [theta_o, phi_o]), &traced));
        }
        let (mean, worst) = (mean(&found), worst(&found));
        println!("{name}: total and L1: mean {mean:.4?}, worst {worst:.4?}");
        let noise = [4.0 / (photons as f64).sqrt(), 3.0 / (photons as f64).sqrt()];
        let fits = |k: usize| mean[k] <= known[0][k] + noise[k] && worst[k] <= known[1][k] + noise[k];
        assert!(fits(0) && fits(1), "{name}: {mean:?} {worst:?}");
    }
}

/// Near fields of a medulla of air at four offsets, and far fields in cells of 15° × 15°.
#[test]
fn near_fields_and_cells_with_air_match_the_tracer() {
    let photons = effort(100_000, 1_000_000);
    let (mut near, mut cells) = (Vec::new(), Vec::new());
    for fiber in fibers().into_iter().skip(effort(7, 0)) {
        let fiber = smooth(Fiber { medulla_air: 1.0, ..fiber });
        let bcsdf = Bcsdf::new(&fiber).unwrap();
        for theta_o in THETA {
            for h in [0.0, 0.3, 0.6, 0.9] {
                let traced = energies(&fiber, theta_o, Offsets::At(h), photons / 4, 3, &()).unwrap().total[0][0];
                let ours = bcsdf.at(direction(theta_o, 0.0), Window::near(h as f32)).energy().total()[0];
                near.push([(f64::from(ours) / traced - 1.0).abs(), 0.0]);
            }
            cells.push(errors(&light_in_cells(&bcsdf, theta_o), &traced_cells(&fiber, theta_o, photons)));
        }
    }
    println!("near {:.4?} {:.4?}; cells {:.3?} {:.3?}", mean(&near)[0], worst(&near)[0], mean(&cells), worst(&cells));
    let noise = 4.0 / (0.25 * photons as f64).sqrt();
    assert!(mean(&near)[0] <= 0.0011 + noise && worst(&near)[0] <= 0.0076 + noise);
    assert!(mean(&cells)[1] <= 0.058 + noise && worst(&cells)[1] <= 0.128 + noise);
}

/// Cells over θ and over φ.
const CELLS: [usize; 2] = [12, BINS];

fn traced_cells(fiber: &Fiber, theta_o: f64, photons: u64) -> Vec<f64> {
    let middles = |n: usize, low: f64, high: f64| (0..n).map(move |i| low + (high - low) * (i as f64 + 0.5) / n as f64);
    let theta: Vec<f64> = middles(CELLS[0], -FRAC_PI_2, FRAC_PI_2).collect();
    let size = PI / CELLS[0] as f64;
    let cells = Cells { theta: theta.clone(), phi: middles(CELLS[1], -PI, PI).collect(), size: [size; 2] };
    let values = profile(fiber, theta_o, &cells, photons, 1, &()).unwrap();
    let solid_angle = |theta: f64| size * ((theta + 0.5 * size).sin() - (theta - 0.5 * size).sin());
    values.iter().enumerate().map(|(i, light)| light[0] * solid_angle(theta[i / CELLS[1]])).collect()
}

/// The model's light in the same cells, in the first channel. The lobes have standard deviations of 1° and more.
fn light_in_cells(bcsdf: &Bcsdf, theta_o: f64) -> Vec<f64> {
    const POINTS: [usize; 2] = [30, 12];
    let hit = bcsdf.at(direction(theta_o, 0.0), Window::far());
    let steps = [PI / (CELLS[0] * POINTS[0]) as f64, TAU / (CELLS[1] * POINTS[1]) as f64];
    let mut light = vec![0.0; CELLS[0] * CELLS[1]];
    for (i, j) in (0..CELLS[0] * POINTS[0]).flat_map(|i| (0..CELLS[1] * POINTS[1]).map(move |j| (i, j))) {
        let (theta, phi) = ((i as f64 + 0.5) * steps[0] - FRAC_PI_2, (j as f64 + 0.5) * steps[1] - PI);
        let f = f64::from(hit.eval(direction(theta, phi)).total()[0]);
        light[i / POINTS[0] * CELLS[1] + j / POINTS[1]] += f * theta.cos() * steps[0] * steps[1];
    }
    light
}
