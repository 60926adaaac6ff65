//! Samples follow the pdf, with tilt and all other parameters non-zero.

use std::f64::consts::TAU;
use vellus::{Bcsdf, Fiber, Lobe, ScatterExit, Species, Window};
use vellus_testing::significance::max_abs_z;
use vellus_testing::sphere::{ChiSquared, integral, nodes};
use vellus_testing::{Uniform, direction, effort, full_fiber};

fn fibers() -> Vec<Fiber> {
    // The second fibre has a peak so sharp that a window spreads its light over azimuths. The third needs more
    // segments.
    let mut fibers = vec![
        full_fiber(),
        Fiber { g: 0.93, sigma_ms: 0.3, layers: 3.0, ..full_fiber() },
        Fiber { eta: 1.1, kappa: 0.5, sigma_ma: [3.0, 0.1, 0.1], ..full_fiber() },
    ];
    fibers.extend(fibers.clone().iter().map(|fiber| fiber.with_exit(ScatterExit::Open)));
    let species = Species::ALL.iter().flat_map(|s| [Fiber::preset(*s), Fiber::published(*s)]);
    fibers.extend(species.map(|fiber| fiber.with_absorption([0.05, 0.4, 0.9])));
    fibers
}

#[test]
fn pdf_integrates_to_one() {
    let windows = [Window::near(-0.45), Window::far(), Window::pixel(-0.3, 0.9)];
    for (fiber, window) in fibers().into_iter().flat_map(|fiber| windows.map(|window| (fiber, window))) {
        let bcsdf = Bcsdf::new(&fiber).unwrap();
        let hit = bcsdf.at(direction(0.7, 0.4), window);
        let sum = integral(nodes(&fiber), |wi| hit.pdf(wi));
        assert!((sum - 1.0).abs() < 1e-3, "{fiber:?} {window:?}: {sum}");
    }
}

/// A χ² test for each fibre, at five hits.
fn check_histograms(fibers: &[Fiber], samples: usize) {
    let hits = [
        (0.35f64, Window::near(0.3)),
        // Offsets where a part of C^N is mirrored.
        (-0.2, Window::near(0.001)),
        (-1.2, Window::near(-0.8)),
        (0.35, Window::far()),
        (-1.2, Window::pixel(-0.4, 0.9)),
    ];
    let mut random = Uniform(3);
    let tests = fibers.len() * hits.len();
    for fiber in fibers {
        let test = ChiSquared { cells: [20, 40], samples, nodes: nodes(fiber), tests };
        let bcsdf = Bcsdf::new(fiber).unwrap();
        for (theta_o, window) in hits {
            let hit = bcsdf.at(direction(theta_o, 2.2), window);
            let follows = test.check(|| hit.sample(random.numbers()).unwrap().wi, |wi| hit.pdf(wi));
            assert_eq!(follows, Ok(()), "{fiber:?} θ_o {theta_o} {window:?}");
        }
    }
}

/// With 800 cells the bound on χ² is 155 above its mean. A relative error δ of the density, constant in each cell,
/// adds n times the mean of δ². So a root mean square of 2.8 % fails with 200,000 samples, and one of 0.9 % with 2
/// million.
#[test]
fn sample_histogram_matches_pdf() {
    check_histograms(&fibers(), effort(200_000, 2_000_000));
}

/// For a grey fibre the weight of a sample is the near-field total. For a coloured one it is at most the sum of the
/// lobes' largest channels.
#[test]
fn weight_is_the_near_field_total() {
    let mut random = Uniform(4);
    for _ in 0..2000 {
        let mut fiber = random.any_fiber();
        let grey = random.next() < 0.5;
        if grey {
            fiber.sigma_ca = [fiber.sigma_ca[0]; 3];
            fiber.sigma_ma = [fiber.sigma_ma[0]; 3];
        }
        let bcsdf = Bcsdf::new(&fiber).unwrap();
        let wo = direction(random.within(-1.55, 1.55), random.within(-3.0, 3.0));
        let hit = bcsdf.at(wo, Window::near(random.within(-1.0, 1.0) as f32));
        let energy = hit.energy();
        let mut bound: f32 = energy.0.iter().map(|a| a[0].max(a[1]).max(a[2])).sum();
        assert!(bound <= 1.0 + 1e-5, "{fiber:?} {bound}");
        if (fiber.exit == ScatterExit::Reflecting || fiber.medulla_air > 0.0) && !grey {
            // The rest lobe has two parts, which may have their largest channels apart.
            bound = 1.0;
        }
        for _ in 0..20 {
            let s = hit.sample(random.numbers()).unwrap();
            assert!((s.wi.length() - 1.0).abs() < 1e-5 && s.pdf > 0.0, "{fiber:?} {s:?}");
            for c in 0..3 {
                assert!(s.weight[c] <= bound * (1.0 + 1e-4), "{fiber:?} {s:?} {bound}");
                if grey {
                    assert!((s.weight[c] / energy.total()[c] - 1.0).abs() < 1e-4, "{fiber:?} {s:?}");
                }
            }
            let (f, pdf) = hit.eval_pdf(s.wi);
            // The same direction through `eval`: δ = 1e-6 in both angles, see tests/it/exact.rs.
            assert!((pdf / s.pdf - 1.0).abs() < 3e-3 + 1e-4 / s.pdf, "{fiber:?} {s:?} {pdf}");
            assert!((f.total()[1] - s.weight[1] * s.pdf).abs() <= 3e-3 * f.total()[1] + 1e-4, "{fiber:?} {s:?}");
        }
    }
}

/// Sampling finds the energy of each lobe.
#[test]
fn lobe_probabilities_follow_the_energies() {
    let bcsdf = Bcsdf::new(&full_fiber()).unwrap();
    let hit = bcsdf.at(direction(0.5, 0.0), Window::near(0.4));
    let mut random = Uniform(5);
    let n = 200_000;
    let mut counts = [0.0; 6];
    for _ in 0..n {
        counts[hit.sample(random.numbers()).unwrap().lobe as usize] += 1.0 / f64::from(n);
    }
    let bound = max_abs_z(Lobe::ALL.len(), 0.01);
    for lobe in Lobe::ALL {
        let p = f64::from(hit.lobe_probabilities()[lobe as usize]);
        let tolerance = bound * (p * (1.0 - p) / f64::from(n)).sqrt();
        assert!((counts[lobe as usize] - p).abs() < tolerance, "{lobe:?}: {} {p}", counts[lobe as usize]);
    }
}

/// The mean and the standard error of a sum of samples.
#[derive(Clone, Copy, Default)]
struct Estimate {
    sum: f64,
    squares: f64,
}

impl Estimate {
    fn add(&mut self, x: f64) {
        self.sum += x;
        self.squares += x * x;
    }

    fn mean_and_error(&self, n: f64) -> (f64, f64) {
        let mean = self.sum / n;
        (mean, ((self.squares / n - mean * mean).max(0.0) / n).sqrt())
    }
}

/// A window's value is the mean of its near fields, for lights from 1° to the whole sphere.
///
/// Three estimates must agree. The first uses light samples with the window's value, the second direction samples with
/// the near field's value. The third combines both by the balance heuristic with the window's density.
fn windows_are_unbiased(n: u32) {
    // Three windows, four lights, three comparisons. At a rate of 0.05 the bound is 3.2 standard errors.
    let bound = max_abs_z(3 * 4 * 3, 0.05);
    let mut random = Uniform(13);
    let radii = [0.5f64, 5.0, 30.0, 180.0].map(f64::to_radians);
    for (fiber, window, towards) in [
        (full_fiber(), Window::far(), (-0.3, 2.6)),
        (full_fiber().with_exit(ScatterExit::Open), Window::far(), (-0.3, 2.6)),
        (Fiber::preset(Species::RedFox).with_absorption([0.2, 0.4, 0.8]), Window::pixel(-0.3, 0.9), (-0.4, -2.2)),
    ] {
        let bcsdf = Bcsdf::new(&fiber).unwrap();
        let hit = bcsdf.at(direction(0.35, 0.0), window);
        let axis = direction(towards.0, towards.1);
        let (across, along) = axis.any_orthonormal_pair();
        // Solid angles of the lights.
        let solid = radii.map(|r| TAU * (1.0 - r.cos()));
        let [mut lights, mut directions, mut both] = [[Estimate::default(); 4]; 3];
        for _ in 0..n {
            let s = hit.sample(random.numbers()).unwrap();
            let cos = f64::from(s.wi.dot(axis));
            for k in 0..4 {
                let inside = if cos >= radii[k].cos() { f64::from(s.weight[1]) } else { 0.0 };
                let pdf = f64::from(s.pdf);
                directions[k].add(inside);
                both[k].add(inside * pdf / (pdf + 1.0 / solid[k]));
            }
        }
        for k in 0..4 {
            let mut weighted = Estimate::default();
            for _ in 0..n {
                let cos = 1.0 - random.next() * (1.0 - radii[k].cos());
                let (sin_psi, cos_psi) = (TAU * random.next()).sin_cos();
                let sin = (1.0 - cos * cos).max(0.0).sqrt();
                let wi = axis * cos as f32 + across * (sin * cos_psi) as f32 + along * (sin * sin_psi) as f32;
                let (f, pdf) = hit.eval_pdf(wi.normalize());
                let value = f64::from(f.total()[1]) * solid[k];
                lights[k].add(value);
                weighted.add(value / (1.0 + f64::from(pdf) * solid[k]));
            }
            let count = f64::from(n);
            let ((l, l_error), (d, d_error)) = (lights[k].mean_and_error(count), directions[k].mean_and_error(count));
            let ((b, b_error), (w, w_error)) = (both[k].mean_and_error(count), weighted.mean_and_error(count));
            let (m, m_error) = (b + w, b_error.hypot(w_error));
            println!(
                "{:.1}°: lights {l:.6} ± {l_error:.1e}, directions {d:.6} ± {d_error:.1e}, both {m:.6} ± {m_error:.1e}",
                radii[k].to_degrees()
            );
            for (x, x_error) in [(d, d_error), (m, m_error)] {
                assert!((x - l).abs() <= bound * x_error.hypot(l_error), "{window:?} light {k}: {l} {d} {m}");
            }
            assert!((d - m).abs() <= bound * d_error.hypot(m_error), "{window:?} light {k}: {l} {d} {m}");
        }
    }
}

/// The standard errors are about 0.1 % with 400,000 samples, and 0.02 % with 10 million, of each light's total.
#[test]
fn windows_are_unbiased_against_the_near_field() {
    windows_are_unbiased(effort(400_000, 10_500_000));
}

/// Weights of windows are nearly constant. One in a hundred exceeds the sum of the lobes' largest channels by more than
/// 2 %, and none by more than 50 %. They can be larger because the few points of the scattered lobes are scaled to the
/// energy of each channel separately.
#[test]
fn window_weights_are_bounded() {
    let mut random = Uniform(14);
    let (mut count, mut above, mut worst) = (0, 0, 0.0f32);
    for _ in 0..3000 {
        let bcsdf = Bcsdf::new(&random.any_fiber()).unwrap();
        let wo = direction(random.within(-1.55, 1.55), random.within(-3.0, 3.0));
        let pixel = Window::pixel(random.within(-1.0, 1.0) as f32, random.within(0.05, 2.0) as f32);
        let hit = bcsdf.at(wo, if random.next() < 0.5 { Window::far() } else { pixel });
        let bound: f32 = hit.energy().0.iter().map(|a| a[0].max(a[1]).max(a[2])).sum();
        for _ in 0..300 {
            let s = hit.sample(random.numbers()).unwrap();
            let most = s.weight.into_iter().fold(0.0, f32::max) / bound;
            worst = worst.max(most);
            count += 1;
            above += i32::from(most > 1.02);
            assert!(s.weight.iter().all(|&w| w >= 0.0), "{:?} {s:?}", bcsdf.fiber());
        }
    }
    println!("{above} of {count}, at most {worst}");
    assert!(above * 50 < count && worst < 1.5, "{above} of {count}, at most {worst}");
}
