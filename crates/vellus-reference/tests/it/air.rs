//! Medullas with air (D24), compared with the photon tracer.

use std::f64::consts::{FRAC_PI_3, TAU};
use vellus::{Bcsdf, Fiber, Species, Window, direction};
use vellus_reference::simulate::azimuth::{BINS, all_azimuths};
use vellus_reference::simulate::energies::Offsets;
use vellus_testing::effort;

/// Points of the model in a bin.
const WITHIN: usize = 16;

fn ours(fiber: &Fiber, theta_o: f64) -> [f64; BINS] {
    let bcsdf = Bcsdf::new(fiber).unwrap();
    let hit = bcsdf.at(direction(theta_o, 0.0), Window::far());
    let step = TAU / (BINS * WITHIN) as f64;
    let mut bins = [0.0; BINS];
    for k in 0..BINS * WITHIN {
        let light = hit.azimuthal(((k as f64 + 0.5) * step) as f32).total()[0];
        bins[k / WITHIN] += step * f64::from(light);
    }
    bins
}

fn errors(a: &[f64; BINS], b: &[f64; BINS]) -> [f64; 2] {
    let sum = |x: &[f64; BINS]| x.iter().sum::<f64>();
    let l1 = a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>();
    [sum(a) / sum(b) - 1.0, l1 / sum(b)]
}

fn smooth(fiber: Fiber) -> Fiber {
    Fiber { alpha: 0.0, beta_m: 1f32.to_radians(), beta_n: 1f32.to_radians(), ..fiber }
}

#[test]
fn medullas_with_air_match_the_tracer() {
    let photons = effort(100_000, 1_000_000);
    let hair = Fiber { kappa: 0.36, sigma_ms: 2.5, sigma_ma: [0.05; 3], g: 0.3, ..Fiber::hair().with_absorption([0.4; 3]) };
    let mut fibers: Vec<_> = Species::ALL.iter().map(|s| (s.name(), Fiber::preset(*s))).collect();
    fibers.push(("hair", hair));
    for (name, fiber) in fibers {
        for theta_o in [0.0, FRAC_PI_3] {
            for eta_m in [1.0f32, 1.1, 1.2, 1.4] {
                if eta_m > fiber.eta { continue; }
                let medulla_air = (fiber.eta - eta_m) / (fiber.eta - 1.0);
                let [before, after] = [0.0, medulla_air].map(|medulla_air| smooth(Fiber { medulla_air, ..fiber }));
                let traced = all_azimuths(&after, [theta_o, 0.0], Offsets::Whole, photons, 1).unwrap().map(|bin| bin[0]);
                let [b, a] = [before, after].map(|fiber| errors(&ours(&fiber, theta_o), &traced).map(|x| 100.0 * x));
                let e = Bcsdf::new(&after).unwrap().at(direction(theta_o, 0.0), Window::far()).energy();
                let e = e.0.map(|l| l[0]);
                println!("{name} {:.0} {eta_m}: total and L1 {b:.1?} -> {a:.1?} {e:.3?}", theta_o.to_degrees());
            }
        }
    }
}
