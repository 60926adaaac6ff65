//! Medullas with air (D24), compared with the photon tracer.

use std::f64::consts::{FRAC_PI_3, PI, TAU};
use vellus::{Bcsdf, Fiber, Species, Window, direction};
use vellus_reference::simulate::azimuth::{BINS, all_azimuths};
use vellus_reference::simulate::energies::{Offsets, energies};
use vellus_reference::simulate::profile::{Cells, profile};
use vellus_testing::{Uniform, effort};

/// Points of the model in a bin.
const WITHIN: usize = 16;

fn ours(fiber: &Fiber, theta_o: f64) -> Vec<f64> {
    let bcsdf = Bcsdf::new(fiber).unwrap();
    let hit = bcsdf.at(direction(theta_o, 0.0), Window::far());
    let step = TAU / (BINS * WITHIN) as f64;
    let mut bins = vec![0.0; BINS];
    for k in 0..BINS * WITHIN {
        let light = hit.azimuthal(((k as f64 + 0.5) * step) as f32).total()[0];
        bins[k / WITHIN] += step * f64::from(light);
    }
    bins
}
fn cells(fiber: &Fiber, theta_o: f64) -> Vec<f64> {
    let bcsdf = Bcsdf::new(fiber).unwrap();
    let hit = bcsdf.at(direction(theta_o, 0.0), Window::far());
    let (n, m) = (60, 12);
    let mut out = vec![0.0; 12 * 24];
    for i in 0..12 * n {
        for j in 0..24 * m {
            let (t, p) = ((i as f64 + 0.5) / (12 * n) as f64 * PI - PI / 2.0, (j as f64 + 0.5) / (24 * m) as f64 * TAU - PI);
            let f = hit.eval(direction(t, p)).total()[0];
            out[i / n * 24 + j / m] += f64::from(f) * t.cos() * PI / (12 * n) as f64 * TAU / (24 * m) as f64;
        }
    }
    out
}
fn traced_cells(fiber: &Fiber, theta_o: f64, photons: u64) -> Vec<f64> {
    let mid = |n: usize, a: f64, b: f64| (0..n).map(|i| a + (b - a) * (i as f64 + 0.5) / n as f64).collect::<Vec<_>>();
    let cells = Cells { theta: mid(12, -PI / 2.0, PI / 2.0), phi: mid(24, -PI, PI), size: [PI / 12.0; 2] };
    let v = profile(fiber, theta_o, &cells, photons, 1, &()).unwrap();
    v.iter().enumerate().map(|(i, x)| { let t = cells.theta[i / 24]; x[0] * PI / 12.0 * ((t + PI / 24.0).sin() - (t - PI / 24.0).sin()) }).collect()
}

fn errors(a: &[f64], b: &[f64]) -> [f64; 2] {
    let sum = |x: &[f64]| x.iter().sum::<f64>();
    let l1 = a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>();
    [100.0 * (sum(a) / sum(b) - 1.0), 100.0 * l1 / sum(b)]
}

fn smooth(fiber: Fiber) -> Fiber {
    Fiber { alpha: 0.0, beta_m: 1f32.to_radians(), beta_n: 1f32.to_radians(), ..fiber }
}

#[test]
fn explore_cells() {
    let photons = effort(200_000, 1_000_000);
    let hair = Fiber { kappa: 0.36, sigma_ms: 2.5, sigma_ma: [0.05; 3], g: 0.3, ..Fiber::hair().with_absorption([0.4; 3]) };
    let mut fibers: Vec<_> = Species::ALL.iter().map(|s| (s.name(), Fiber::preset(*s))).collect();
    fibers.push(("hair", hair));
    for (name, fiber) in fibers {
        for theta_o in [0.0, FRAC_PI_3] {
            for eta_m in [1.0f32, 1.2, 9.0] {
                if eta_m > fiber.eta && eta_m < 9.0 { continue; }
                let medulla_air = ((fiber.eta - eta_m) / (fiber.eta - 1.0)).max(0.0);
                let [before, after] = [0.0, medulla_air].map(|medulla_air| smooth(Fiber { medulla_air, ..fiber }));
                let traced = traced_cells(&after, theta_o, photons);
                let [b, a] = [before, after].map(|fiber| errors(&cells(&fiber, theta_o), &traced));
                let mut line = format!("{name} {:.0} {eta_m}: cells {b:.1?} -> {a:.1?}; near", theta_o.to_degrees());
                for h in [0.0, 0.3, 0.6, 0.9] {
                    let t = energies(&after, theta_o, Offsets::At(h), photons / 4, 3, &()).unwrap().total[0][0];
                    let [b, a] = [before, after].map(|f| 100.0 * (f64::from(Bcsdf::new(&f).unwrap().at(direction(theta_o, 0.0), Window::near(h as f32)).energy().total()[0]) / t - 1.0));
                    line += &format!(" {b:.1}->{a:.1}");
                }
                println!("{line}");
            }
        }
    }
}

#[test]
fn explore_random() {
    let mut random = Uniform(24);
    let (mut all, mut was) = (vec![], vec![]);
    for k in 0..100 {
        let medulla_air = if k % 3 == 0 { 1.0 } else { random.next() as f32 };
        let fiber = random.fiber();
        let fiber = smooth(Fiber { medulla_air, sigma_ms: fiber.sigma_ms.min(8.0), ..fiber });
        let theta = random.within(0.0, 1.31);
        let traced = all_azimuths(&fiber, [theta, 0.0], Offsets::Whole, 40_000, k).unwrap().map(|bin| bin[0]);
        let e = errors(&ours(&fiber, theta), &traced);
        let b = errors(&ours(&Fiber { medulla_air: 0.0, ..fiber }, theta), &traced);
        if e[0].abs() > 3.0 || e[1] > 15.0 { println!("{e:.1?} before {b:.1?} {theta:.2} air {} eta {} kappa {} g {} ms {} ma {:?} ca {:?} l {}", fiber.medulla_air, fiber.eta, fiber.kappa, fiber.g, fiber.sigma_ms, fiber.sigma_ma, fiber.sigma_ca, fiber.layers); }
        all.push(e); was.push(b);
    }
    for (name, v) in [("before", was), ("after", all)] {
        let col = |k: usize| { let mut x: Vec<f64> = v.iter().map(|e| e[k].abs()).collect(); x.sort_by(f64::total_cmp); (x.iter().sum::<f64>() / 100.0, x[94], x[99]) };
        println!("{name}: total {:.2?} L1 {:.2?}", col(0), col(1));
    }
}
