//! Fibres whose section is an ellipse (D23), compared with the photon tracer.

use std::f64::consts::{PI, TAU};
use vellus::{Bcsdf, Fiber, Species, Window, direction};
use vellus_reference::simulate::azimuth::{BINS, all_azimuths};
use vellus_reference::simulate::energies::Offsets;
use vellus_testing::effort;

/// Points of the model in a bin.
const WITHIN: usize = 16;

/// The model's light in each bin, in the first channel.
fn ours(fiber: &Fiber, [theta_o, phi_o]: [f64; 2], windows: &[Window]) -> [f64; BINS] {
    let bcsdf = Bcsdf::new(fiber).unwrap();
    let step = TAU / (BINS * WITHIN) as f64;
    let mut bins = [0.0; BINS];
    for window in windows {
        let hit = bcsdf.at(direction(theta_o, phi_o), *window);
        for (k, bin) in (0..BINS * WITHIN).map(|k| (k, k / WITHIN)) {
            let light = hit.azimuthal(((k as f64 + 0.5) * step) as f32).total()[0];
            bins[bin] += step * f64::from(light) / windows.len() as f64;
        }
    }
    bins
}

/// The error of the total, and Σ |a − b| over the bins, both relative to the light of `b`.
fn errors(a: &[f64; BINS], b: &[f64; BINS]) -> [f64; 2] {
    let sum = |x: &[f64; BINS]| x.iter().sum::<f64>();
    let l1 = a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>();
    [sum(a) / sum(b) - 1.0, l1 / sum(b)]
}

/// A fibre with a nearly smooth cuticle, as the tracer has it: the lobes are narrower than the bins.
fn smooth(fiber: Fiber) -> Fiber {
    Fiber { alpha: 0.0, beta_m: 1f32.to_radians(), beta_n: 1f32.to_radians(), ..fiber }
}

fn compare(offsets: Offsets, windows: &[Window], photons: u64) {
    let hair = Fiber::hair().with_absorption([0.2; 3]);
    let fibers = [("hair", hair)].into_iter().chain(Species::ALL.map(|s| (s.name(), Fiber::preset(s))));
    for (name, fiber) in fibers {
        let mut line = format!("{name:10}");
        for theta_o in [0.0, PI / 3.0] {
            for phi_o in [0.0, PI / 4.0, PI / 2.0] {
                let flat = smooth(Fiber { aspect_ratio: 2.0 / 3.0, ..fiber });
                let round = smooth(fiber);
                let traced = |fiber: &Fiber, seed| {
                    all_azimuths(fiber, [theta_o, phi_o], offsets, photons, seed).unwrap().map(|bin| bin[0])
                };
                let (a, b) = (traced(&flat, 1), traced(&round, 2));
                let [before, after] = [&round, &flat].map(|f| errors(&ours(f, [theta_o, phi_o], windows), &a));
                let usual = errors(&ours(&round, [theta_o, phi_o], windows), &b);
                line += &format!(
                    " | {:5.1} {:4.0} → {:5.1} {:4.1} ({:4.1})",
                    1e2 * before[0],
                    1e2 * before[1],
                    1e2 * after[0],
                    1e2 * after[1],
                    1e2 * usual[1]
                );
            }
        }
        println!("{line}");
    }
}

#[test]
fn flat_fibres_match_the_tracer() {
    let photons = effort(20_000, 400_000);
    let whole: Vec<_> = (0..200).map(|i| Window::near(2.0 * (i as f32 + 0.5) / 200.0 - 1.0)).collect();
    compare(Offsets::Whole, &whole, photons);
    for h in [-0.6, 0.0, 0.6] {
        println!("h {h}");
        compare(Offsets::At(h), &[Window::near(h as f32)], photons);
    }
}
