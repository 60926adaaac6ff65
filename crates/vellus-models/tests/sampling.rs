//! Of every model: sampling draws what pdf says, pdf integrates to 1, weights are f/pdf.

#[path = "../../vellus/tests/common/mod.rs"]
mod common;

use common::{Uniform, direction, full_fiber};
use std::f64::consts::{PI, TAU};
use vellus::{Fiber, Model, Scattering, Species, Window};
use vellus_models::{AnyModel, ModelKind, Yan2015};

fn fibers() -> [Fiber; 3] {
    [
        full_fiber(),
        Fiber { g: 0.9, sigma_ms: 0.4, eta: 1.35, beta_n: 0.45, ..full_fiber() },
        Fiber::preset(Species::Deer).with_absorption([0.05, 0.4, 0.9]),
    ]
}

/// Ours is tested in its own crate; that of 2015 also with two indices, lower and higher in the medulla.
fn models() -> impl Iterator<Item = (ModelKind, Fiber, AnyModel)> {
    let others = ModelKind::ALL.iter().filter(|kind| **kind != ModelKind::Vellus);
    let one = others.flat_map(|&kind| fibers().map(|fiber| (kind, fiber, kind.model(&fiber).unwrap())));
    let kind = ModelKind::Yan2015;
    let two = fibers()
        .into_iter()
        .zip([1.15, 1.8, 1.4])
        .map(move |(fiber, eta_m)| (kind, fiber, AnyModel::Yan2015(Yan2015::with_eta_m(&fiber, eta_m).unwrap())));
    // Between shared tables.
    let kind = ModelKind::DEon2011;
    let shared = kind.model(&full_fiber()).unwrap();
    let fiber = Fiber { sigma_ca: [0.45, 1.1, 0.06], ..full_fiber() };
    let between = shared.with_fiber(&fiber).unwrap();
    one.chain(two).chain([(kind, fiber, between)])
}

#[test]
fn pdf_integrates_to_one() {
    for (kind, fiber, model) in models() {
        for (theta_o, h) in [(0.7, -0.45), (-1.2, 0.8)] {
            let hit = model.at(direction(theta_o, 0.4), Window::near(h));
            let (n_theta, n_phi) = (600, 360);
            let mut sum = 0.0;
            for i in 0..n_theta {
                let theta = ((f64::from(i) + 0.5) / f64::from(n_theta) - 0.5) * PI;
                for j in 0..n_phi {
                    let pdf = hit.pdf(direction(theta, (f64::from(j) + 0.5) / f64::from(n_phi) * TAU));
                    sum += f64::from(pdf) * theta.cos();
                }
            }
            sum *= PI / f64::from(n_theta) * TAU / f64::from(n_phi);
            // Midpoints 0.3° and 1° apart, of lobes 2.3° wide and more.
            assert!((sum - 1.0).abs() < 2e-3, "{kind} {fiber:?} {theta_o}: {sum}");
        }
    }
}

/// χ² of 300,000 samples in 16 × 32 equal-area cells against the pdf integrated over each cell, with significance 0.01 over
/// all tests together by Šidák; see `sample_histogram_matches_pdf` of `vellus`.
#[test]
fn sample_histogram_matches_pdf() {
    let (rows, columns, samples) = (16usize, 32usize, 300_000usize);
    let mut random = Uniform(7);
    let hits = [(0.35f64, 0.3f32), (-1.2, -0.8)];
    let tests = (models().count() * hits.len()) as f64;
    for (kind, fiber, model) in models() {
        for (theta_o, h) in hits {
            let hit = model.at(direction(theta_o, 2.2), Window::near(h));
            let mut observed = vec![0.0f64; rows * columns];
            for _ in 0..samples {
                let wi = hit.sample(random.numbers()).wi;
                let row = ((f64::from(wi.x) * 0.5 + 0.5) * rows as f64) as usize;
                let turn = f64::from(wi.z).atan2(wi.y.into()) / TAU;
                let column = (turn.rem_euclid(1.0) * columns as f64) as usize;
                observed[row.min(rows - 1) * columns + column.min(columns - 1)] += 1.0;
            }
            // 16 × 12 midpoints a cell, of lobes at least 2.3° wide in bands of 4° to 29°.
            let mut expected = vec![0.0f64; rows * columns];
            for row in 0..rows {
                let band = [row, row + 1].map(|r| (2.0 * r as f64 / rows as f64 - 1.0).clamp(-1.0, 1.0).asin());
                let (n_theta, n_phi) = (16, 12 * columns);
                for i in 0..n_theta {
                    let theta = band[0] + (band[1] - band[0]) * (f64::from(i) + 0.5) / f64::from(n_theta);
                    let weight = theta.cos() * (band[1] - band[0]) / f64::from(n_theta) * TAU / n_phi as f64;
                    for j in 0..n_phi {
                        let phi = (j as f64 + 0.5) / n_phi as f64 * TAU;
                        expected[row * columns + j / 12] += f64::from(hit.pdf(direction(theta, phi))) * weight;
                    }
                }
            }
            let (mut chi2, mut cells, mut pooled) = (0.0, 0, [0.0f64; 2]);
            for (o, e) in observed.iter().zip(&expected) {
                let e = e * samples as f64;
                if e < 10.0 {
                    pooled[0] += o;
                    pooled[1] += e;
                } else {
                    chi2 += (o - e).powi(2) / e;
                    cells += 1;
                }
            }
            if pooled[1] > 1.0 {
                chi2 += (pooled[0] - pooled[1]).powi(2) / pooled[1];
                cells += 1;
            }
            let df = f64::from(cells - 1);
            let alpha = 1.0 - 0.99f64.powf(1.0 / tests);
            // Upper normal quantile (Abramowitz and Stegun 26.2.23), and Wilson and Hilferty's of χ².
            let t = (-2.0 * alpha.ln()).sqrt();
            let z = t
                - (2.515_517 + t * (0.802_853 + t * 0.010_328))
                    / (1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308)));
            let w = 2.0 / (9.0 * df);
            let limit = df * (1.0 - w + z * w.sqrt()).powi(3);
            assert!(chi2 < limit, "{kind} {fiber:?} θ_o {theta_o} h {h}: χ² {chi2} over {limit}, {df} degrees");
        }
    }
}

/// f·cos θᵢ and pdf of a sample's direction are its weight times pdf, and its pdf.
#[test]
fn weight_is_f_over_pdf() {
    let mut random = Uniform(8);
    for (kind, fiber, model) in models() {
        for _ in 0..500 {
            let wo = direction(random.within(-1.4, 1.4), random.within(-3.0, 3.0));
            let hit = model.at(wo, Window::near(random.within(-1.0, 1.0) as f32));
            let s = hit.sample(random.numbers());
            assert!((s.wi.length() - 1.0).abs() < 1e-5 && s.pdf > 0.0, "{kind} {fiber:?} {s:?}");
            // Near the poles the azimuth of the direction itself rounds; and Gaussians in θ have their pole there.
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
