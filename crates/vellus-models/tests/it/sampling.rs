//! For every model: samples follow the pdf, the pdf integrates to 1, and weights are f/pdf.

use vellus::{Fiber, Model, Scattering, Species, Window};
use vellus_models::{AnyModel, ModelKind, Yan2015};
use vellus_testing::significance::max_abs_z;
use vellus_testing::sphere::{ChiSquared, integral};
use vellus_testing::{Uniform, direction, full_fiber};

fn fibers() -> [Fiber; 3] {
    [
        full_fiber(),
        Fiber { g: 0.9, sigma_ms: 0.4, eta: 1.35, beta_n: 0.45, ..full_fiber() },
        Fiber::published(Species::Deer).with_absorption([0.05, 0.4, 0.9]),
    ]
}

/// Our model is tested in its own crate. The model of 2015 is also tested with two indices, lower and higher in the
/// medulla.
fn models() -> impl Iterator<Item = (ModelKind, Fiber, AnyModel)> {
    let others = ModelKind::ALL.iter().filter(|kind| **kind != ModelKind::Vellus);
    let one = others.flat_map(|&kind| fibers().map(|fiber| (kind, fiber, kind.model(&fiber).unwrap())));
    let kind = ModelKind::Yan2015;
    let two = fibers()
        .into_iter()
        .zip([1.15, 1.8, 1.4])
        .map(move |(fiber, eta_m)| (kind, fiber, AnyModel::Yan2015(Yan2015::with_eta_m(&fiber, eta_m).unwrap())));
    // This model interpolates between shared tables.
    let kind = ModelKind::DEon2011;
    let shared = kind.model(&full_fiber()).unwrap();
    let fiber = Fiber { sigma_ca: [0.45, 1.1, 0.06], ..full_fiber() };
    let between = shared.with_fiber(&fiber).unwrap();
    one.chain(two).chain([(kind, fiber, between)])
}

/// The model of 2015 with its original sampling.
fn published() -> impl Iterator<Item = (ModelKind, Fiber, AnyModel)> {
    let model = |fiber: Fiber| AnyModel::Yan2015(Yan2015::with_eta_m(&fiber, 1.4).unwrap().with_original_sampling());
    fibers().into_iter().map(move |fiber| (ModelKind::Yan2015, fiber, model(fiber)))
}

#[test]
fn pdf_integrates_to_one() {
    for (kind, fiber, model) in models().chain(published()) {
        for (theta_o, h) in [(0.7, -0.45), (-1.2, 0.8)] {
            let hit = model.at(direction(theta_o, 0.4), Window::near(h));
            let sum = integral([600, 360], |wi| hit.pdf(wi));
            // Midpoints are 0.3° and 1° apart, and lobes are at least 2.3° wide.
            assert!((sum - 1.0).abs() < 2e-3, "{kind} {fiber:?} {theta_o}: {sum}");
        }
    }
}

/// With the steepest scales, the Gaussians of some lobes are beyond a pole. What is left of them is hardly sampled.
#[test]
fn pdf_integrates_to_one_for_the_steepest_scales() {
    for kind in [ModelKind::Marschner2003, ModelKind::ZinkeWeber2007, ModelKind::Yan2015] {
        for alpha in [-44.99f32, 44.99].map(f32::to_radians) {
            let fiber = Fiber { alpha, beta_m: 0.0524, ..full_fiber() };
            let model = kind.model(&fiber).unwrap();
            for theta_o in [-1.5, -1.1, -0.5, 0.8, 1.4] {
                let hit = model.at(direction(theta_o, 0.4), Window::near(0.3));
                let sum = integral([900, 240], |wi| hit.pdf(wi));
                // The narrowest lobe has a standard deviation of 1.5°, and midpoints are 0.2° apart.
                assert!((sum - 1.0).abs() < 3e-3, "{kind} {alpha} {theta_o}: {sum}");
            }
        }
    }
}

/// [`ChiSquared`], for lobes at least 2.3° wide in bands of 4° to 29°.
#[test]
fn sample_histogram_matches_pdf() {
    let mut random = Uniform(7);
    let hits = [(0.35f64, 0.3f32), (-1.2, -0.8)];
    let tests = models().chain(published()).count() * hits.len();
    let test = ChiSquared { cells: [16, 32], samples: 300_000, nodes: [360, 384], tests };
    for (kind, fiber, model) in models().chain(published()) {
        for (theta_o, h) in hits {
            let hit = model.at(direction(theta_o, 2.2), Window::near(h));
            let follows = test.check(|| hit.sample(random.numbers()).unwrap().wi, |wi| hit.pdf(wi));
            assert_eq!(follows, Ok(()), "{kind} {fiber:?} θ_o {theta_o} h {h}");
        }
    }
}

/// In the direction of a sample, f·cos θᵢ is its weight times its pdf, and the pdf is its pdf.
#[test]
fn weight_is_f_over_pdf() {
    let mut random = Uniform(8);
    for (kind, fiber, model) in models() {
        for _ in 0..500 {
            let wo = direction(random.within(-1.4, 1.4), random.within(-3.0, 3.0));
            let hit = model.at(wo, Window::near(random.within(-1.0, 1.0) as f32));
            let s = hit.sample(random.numbers()).unwrap();
            assert!((s.wi.length() - 1.0).abs() < 1e-5 && s.pdf > 0.0, "{kind} {fiber:?} {s:?}");
            // Near the poles the azimuth of the direction is rounded, and Gaussians in θ have their pole there.
            if s.wi.x.abs() > 0.999 {
                continue;
            }
            let (f, pdf) = hit.eval_pdf(s.wi);
            assert!((pdf / s.pdf - 1.0).abs() < 3e-3 + 1e-4 / s.pdf, "{kind} {fiber:?} {s:?} {pdf}");
            for c in 0..3 {
                let expected = s.weight[c] * s.pdf;
                assert!((f.total()[c] - expected).abs() <= 4e-3 * expected + 1e-4, "{kind} {fiber:?} {s:?} {f:?}");
            }
        }
    }
}

/// Samples whose weights only include their own lobe also give the energy of each lobe.
#[test]
fn published_sampling_finds_the_energy() {
    let mut random = Uniform(9);
    let bound = max_abs_z(published().count() * 18, 0.01);
    for (_, fiber, model) in published() {
        let hit = model.at(direction(0.35, 2.2), Window::near(0.3));
        let n = 200_000;
        let (mut sums, mut squares) = ([[0.0f64; 3]; 6], [[0.0f64; 3]; 6]);
        for _ in 0..n {
            let s = hit.sample(random.numbers()).unwrap();
            for c in 0..3 {
                let w = f64::from(s.weight[c]);
                sums[s.lobe as usize][c] += w / f64::from(n);
                squares[s.lobe as usize][c] += w * w / f64::from(n);
            }
        }
        let energy = hit.energy();
        for (lobe, c) in (0..18).map(|i| (i / 3, i % 3)) {
            let (mean, exact) = (sums[lobe][c], f64::from(energy.0[lobe][c]));
            let error = ((squares[lobe][c] - mean * mean) / f64::from(n)).max(0.0).sqrt();
            // The transmitted share comes from a table, with an error of 2e-3.
            assert!(
                (mean - exact).abs() <= bound * error + 2e-3 * exact,
                "{fiber:?} {lobe} {c}: {mean} {exact} ± {error}"
            );
        }
    }
}
