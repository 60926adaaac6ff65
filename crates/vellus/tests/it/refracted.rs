//! The shape of scattered light that the cuticle refracts (D18): `ScatterExit::Reflecting`.

use std::f64::consts::FRAC_PI_2;
use vellus::{Bcsdf, Fiber, Lobe, ScatterExit, Species, Window};
use vellus_reference::exact::Exact;
use vellus_testing::sphere::{ChiSquared, integral, nodes};
use vellus_testing::{Uniform, angles, direction, full_fiber, table_data};

const SCATTERED: [usize; 2] = [Lobe::Tts as usize, Lobe::Trts as usize];

/// Fibres at the limits of the parameters on which the shape depends.
fn limits() -> Vec<Fiber> {
    let fiber = full_fiber().with_exit(ScatterExit::Reflecting);
    vec![
        fiber,
        Fiber { eta: 1.0, ..fiber },
        Fiber { eta: 1.02, ..fiber },
        Fiber { eta: 3.0, ..fiber },
        Fiber { g: 0.95, ..fiber },
        Fiber { g: 0.95, eta: 3.0, sigma_ms: 0.1, ..fiber },
        Fiber { sigma_ms: 1e-6, ..fiber },
        Fiber { sigma_ms: 1000.0, layers: 20.0, ..fiber },
        Fiber { kappa: 0.99, layers: 0.0, ..fiber },
        Fiber { kappa: 0.02, eta: 1.3, ..fiber },
    ]
}

/// The densities of the scattered lobes, in the fast model and in the oracle.
///
/// θ′ has an error of 1e-6 from two arc functions, see `close` in tests/it/exact.rs. The fast normalisers are
/// interpolated over the angle of the cone and θ_t.
#[test]
fn fast_matches_f64_oracle() {
    let mut random = Uniform(31);
    let mut fibers = limits();
    fibers.extend(Species::ALL.map(|species| Fiber::published(species).with_exit(ScatterExit::Reflecting)));
    fibers.extend((0..200).map(|_| random.fiber().with_exit(ScatterExit::Reflecting)));
    let (mut worst, mut count) = ((0.0f64, 0.0, 0.0), 0);
    for fiber in fibers {
        let bcsdf = Bcsdf::new(&fiber).unwrap();
        let oracle = Exact::new(&fiber, table_data()).unwrap();
        for k in 0..6 {
            let theta_o = if k == 5 { 1.565 } else { random.within(-1.5, 1.5) };
            let h = random.within(-1.0, 1.0) as f32;
            let hit = bcsdf.at(direction(theta_o, 0.0), Window::near(h));
            let exact = oracle.at(f64::from(direction(theta_o, 0.0).x).asin(), f64::from(h));
            for k in 0..40 {
                let wi = random.outgoing(&hit, k);
                let [theta_i, phi_i] = angles(wi);
                let (values, energy, expected) = (hit.eval(wi), hit.energy(), exact.densities(theta_i, phi_i));
                for p in SCATTERED {
                    let (a, b) = (f64::from(values.0[p][1] / energy.0[p][1]), expected[p]);
                    // Without light there is no shape.
                    if energy.0[p][1] < 1e-12 {
                        continue;
                    }
                    if b > 0.01 && (a / b - 1.0).abs() > worst.0 {
                        worst = ((a / b - 1.0).abs(), theta_o, theta_i);
                    }
                    count += 1;
                    assert!(
                        (a - b).abs() <= 2e-3 * b + 1e-4,
                        "{fiber:?}\nθ_o {theta_o} h {h} θ_i {theta_i} φ {phi_i}: {a} {b}"
                    );
                }
            }
        }
    }
    println!("worst relative difference {worst:?} of {count}");
}

/// The windows' few points against the mean of the near field. See tests/it/window.rs for their error.
#[test]
fn windows_are_the_mean_of_the_near_field() {
    for fiber in
        [Species::RedFox, Species::Bobcat].map(|species| Fiber::published(species).with_exit(ScatterExit::Reflecting))
    {
        let bcsdf = Bcsdf::new(&fiber).unwrap();
        for theta_o in [-0.3, 1.2] {
            let wo = direction(theta_o, 0.0);
            let hit = bcsdf.at(wo, Window::far());
            for (theta_i, phi) in [(0.2, 0.4), (-1.1, 3.0), (1.3, -2.0), (0.3, 1.5)] {
                let wi = direction(theta_i, phi);
                let n = 2000;
                let mut mean = [0.0; 2];
                for k in 0..n {
                    let h = (2.0 * (f64::from(k) + 0.5) / f64::from(n) - 1.0) as f32;
                    let near = bcsdf.at(wo, Window::near(h)).eval(wi);
                    (0..2).for_each(|i| mean[i] += f64::from(near.0[SCATTERED[i]][0]) / f64::from(n));
                }
                let values = SCATTERED.map(|p| f64::from(hit.eval(wi).0[p][0]));
                for (a, b) in values.into_iter().zip(mean) {
                    assert!((a - b).abs() <= 0.03 * b + 1e-4, "{fiber:?} θ_o {theta_o} θ_i {theta_i} φ {phi}: {a} {b}");
                }
            }
        }
    }
}

#[test]
fn pdf_integrates_to_one() {
    for fiber in limits() {
        let bcsdf = Bcsdf::new(&fiber).unwrap();
        for (theta_o, window) in [(0.7, Window::near(-0.45)), (-1.4, Window::far()), (0.0, Window::pixel(-0.3, 0.9))] {
            let hit = bcsdf.at(direction(theta_o, 0.4), window);
            let sum = integral(nodes(&fiber), |wi| hit.pdf(wi));
            assert!((sum - 1.0).abs() < 1e-3, "{fiber:?} {theta_o} {window:?}: {sum}");
        }
    }
}

#[test]
fn histogram_of_samples_matches_pdf() {
    let hits = [(0.35f64, Window::near(0.3)), (-1.35, Window::near(-0.2)), (0.9, Window::far())];
    let mut random = Uniform(33);
    let fibers = limits();
    let tests = fibers.len() * hits.len();
    for fiber in &fibers {
        let test = ChiSquared { cells: [20, 40], samples: 100_000, nodes: nodes(fiber), tests };
        let bcsdf = Bcsdf::new(fiber).unwrap();
        for (theta_o, window) in hits {
            let hit = bcsdf.at(direction(theta_o, 2.2), window);
            let follows = test.check(|| hit.sample(random.numbers()).unwrap().wi, |wi| hit.pdf(wi));
            assert_eq!(follows, Ok(()), "{fiber:?} θ_o {theta_o} {window:?}");
        }
    }
}

/// The weight of a near-field sample is the near-field total, and the density is the one that `pdf` returns.
#[test]
fn weight_is_the_near_field_total() {
    let mut random = Uniform(34);
    for _ in 0..500 {
        let fiber = random.fiber().with_exit(ScatterExit::Reflecting);
        let fiber = Fiber { sigma_ca: [fiber.sigma_ca[0]; 3], sigma_ma: [fiber.sigma_ma[0]; 3], ..fiber };
        let bcsdf = Bcsdf::new(&fiber).unwrap();
        let hit = bcsdf.at(direction(random.within(-1.55, 1.55), 0.0), Window::near(random.within(-1.0, 1.0) as f32));
        let total = hit.energy().total();
        for _ in 0..20 {
            let s = hit.sample(random.numbers()).unwrap();
            assert!((s.weight[0] / total[0] - 1.0).abs() < 1e-4, "{fiber:?} {s:?}");
            let pdf = hit.pdf(s.wi);
            assert!((pdf / s.pdf - 1.0).abs() < 3e-3 + 1e-4 / s.pdf, "{fiber:?} {s:?} {pdf}");
        }
    }
}

#[test]
fn mirrored_light_leaves_mirrored() {
    let mut random = Uniform(35);
    for fiber in limits() {
        let bcsdf = Bcsdf::new(&Fiber { alpha: 0.0, ..fiber }).unwrap();
        for _ in 0..50 {
            let [theta_o, theta_i] = [0; 2].map(|_| random.within(-1.5, 1.5));
            let (phi, h) = (random.within(-3.0, 3.0), random.within(-1.0, 1.0) as f32);
            let at = |sign: f64| {
                bcsdf.at(direction(sign * theta_o, 0.0), Window::near(h)).eval(direction(sign * theta_i, phi)).total()
                    [1]
            };
            let (a, b) = (at(1.0), at(-1.0));
            assert!((a - b).abs() <= 1e-4 * a + 1e-6, "{fiber:?} {theta_o} {theta_i} {a} {b}");
        }
    }
}

/// A fibre with the index of air does not refract.
#[test]
fn index_of_air_gives_the_open_shape() {
    let mut random = Uniform(36);
    let fiber = Fiber { eta: 1.0, ..full_fiber().without_absorption() };
    let [open, reflecting] = ScatterExit::ALL.map(|exit| Bcsdf::new(&fiber.with_exit(exit)).unwrap());
    for _ in 0..1000 {
        let (wo, wi) =
            (direction(random.within(-1.3, 1.3), 0.0), direction(random.within(-1.5, 1.5), random.within(-3.0, 3.0)));
        let window = Window::near(random.within(-0.7, 0.7) as f32);
        let [a, b] = [&open, &reflecting].map(|bcsdf| bcsdf.at(wo, window).eval(wi));
        for p in SCATTERED {
            // The normalisers are interpolated differently.
            assert!((a.0[p][1] - b.0[p][1]).abs() <= 2e-3 * a.0[p][1] + 1e-6, "{wo} {wi} {a:?} {b:?}");
        }
    }
}

#[test]
fn limits_are_finite() {
    let mut random = Uniform(37);
    for fiber in limits() {
        let bcsdf = Bcsdf::new(&fiber).unwrap();
        for theta_o in [-FRAC_PI_2, -1.57, 0.0, 1.3, FRAC_PI_2 - 1e-5, FRAC_PI_2] {
            for window in [Window::near(0.3), Window::far()] {
                let hit = bcsdf.at(direction(theta_o, 0.2), window);
                for theta_i in [-FRAC_PI_2, -1.2, 0.0, 0.4, 1.57, FRAC_PI_2] {
                    let (f, pdf) = hit.eval_pdf(direction(theta_i, 2.0));
                    let all = f.0.iter().flatten().chain([&pdf]).all(|x| x.is_finite() && *x >= 0.0);
                    assert!(all, "{fiber:?} {theta_o} {theta_i} {f:?}");
                }
                for _ in 0..40 {
                    let Some(s) = hit.sample(random.numbers()) else { continue };
                    let all = s.wi.is_finite() && s.weight.iter().all(|w| w.is_finite() && *w >= 0.0);
                    assert!(all && s.pdf.is_finite(), "{fiber:?} {theta_o} {s:?}");
                }
            }
        }
    }
}
