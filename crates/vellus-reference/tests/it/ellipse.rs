//! Fibres whose section is an ellipse (D23), compared with the photon tracer.

use std::f64::consts::{PI, TAU};
use vellus::{Bcsdf, Fiber, Species, Window, direction};
use vellus_reference::simulate::azimuth::{BINS, all_azimuths};
use vellus_reference::simulate::energies::Offsets;
use vellus_testing::effort;

/// Points of the model in a bin.
const WITHIN: usize = 16;

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
fn errors(a: &[f64; BINS], b: &[f64; BINS]) -> [f64; 2] {
    let sum = |x: &[f64; BINS]| x.iter().sum::<f64>();
    let l1 = a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>();
    [(sum(a) / sum(b) - 1.0).abs(), l1 / sum(b)]
}

/// A fibre with a nearly smooth cuticle, as the tracer has it: the lobes are narrower than the bins.
fn smooth(fiber: Fiber) -> Fiber {
    Fiber { alpha: 0.0, beta_m: 1f32.to_radians(), beta_n: 1f32.to_radians(), ..fiber }
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
            for (theta_o, phi_o) in [0.0, PI / 3.0].into_iter().flat_map(|t| [0.0, PI / 4.0, PI / 2.0].map(|p| (t, p)))
            {
                let [round, flat] = [1.0, 2.0 / 3.0].map(|aspect_ratio| smooth(Fiber { aspect_ratio, ..fiber }));
                let traced = all_azimuths(&flat, [theta_o, phi_o], Offsets::Whole, photons, 1).unwrap();
                let traced = traced.map(|bin| bin[0]);
                before.push(errors(&ours(&round, [theta_o, phi_o]), &traced));
                after.push(errors(&ours(&flat, [theta_o, phi_o]), &traced));
            }
        }
        let mean = |all: &[[f64; 2]]| [0, 1].map(|k| all.iter().map(|e| e[k]).sum::<f64>() / all.len() as f64);
        let worst = |all: &[[f64; 2]]| [0, 1].map(|k| all.iter().map(|e| e[k]).fold(0.0, f64::max));
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
