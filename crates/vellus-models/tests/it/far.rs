//! Compares far fields of near-field models with sums over very many offsets.

use vellus::{Fiber, Model, Scattering, Species, Window};
use vellus_models::{AnyModel, Directions, ModelKind, Yan2015};

/// The mean over 6,000 offsets, equidistant in γ, by `eval` of the model in each direction.
fn slow(model: &AnyModel, theta_o: f64, directions: &Directions) -> Vec<[f64; 3]> {
    let n = 6_000;
    let (sin, cos) = theta_o.to_radians().sin_cos();
    let wo = glam::Vec3::new(sin as f32, cos as f32, 0.0);
    let mut sums = vec![[0.0; 3]; directions.len()];
    for k in 0..n {
        let gamma = ((f64::from(k) + 0.5) / f64::from(n) - 0.5) * std::f64::consts::PI;
        let weight = 0.5 * gamma.cos() * std::f64::consts::PI / f64::from(n);
        let hit = model.at(wo, Window::near(gamma.sin() as f32));
        for (sum, wi) in sums.iter_mut().zip(directions.vectors()) {
            let f = hit.eval(*wi).total();
            (0..3).for_each(|c| sum[c] += weight * f64::from(f[c]));
        }
    }
    sums
}

/// The largest relative error in any direction and channel. Many directions have the same θ or φ.
fn worst(model: &AnyModel, theta_o: f64) -> f64 {
    let angles: Vec<[f64; 2]> =
        (0..40).map(|i| [f64::from(i % 5) * 13.0 - 12.0, f64::from(i / 5) * 41.0 - 17.0 + f64::from(i % 2)]).collect();
    let directions = Directions::new(&angles);
    let mut fast = vec![[0.0; 3]; directions.len()];
    model.far_field(theta_o, &directions, &mut fast);
    let slow = slow(model, theta_o, &directions);
    let pairs = fast.iter().flatten().zip(slow.iter().flatten());
    pairs.fold(0.0, |most, (fast, slow)| (f64::from(*fast) / slow - 1.0).abs().max(most))
}

/// With the sampling density of `Azimuthal::exits`, lobes have a ripple of at most 3e-4. Scattered lobes are piecewise
/// linear in h″ between the nodes of their table, so Gauss–Legendre quadrature has an error of 1.4e-3.
#[test]
fn far_fields_match_very_many_offsets() {
    for species in [Species::RedFox, Species::Human] {
        let preset = Fiber::published(species);
        for (beta_n, theta_o) in [(preset.beta_n.to_degrees(), -30.0), (1.5, 65.0), (40.0, 10.0)] {
            let fiber = Fiber { sigma_ca: [0.1, 0.4, 1.2], beta_n: beta_n.to_radians(), ..preset };
            for kind in [ModelKind::Chiang2016, ModelKind::ZinkeWeber2007, ModelKind::Yan2015] {
                let tolerance = if kind == ModelKind::Yan2015 { 2e-3 } else { 3e-4 };
                let off = worst(&kind.model(&fiber).unwrap(), theta_o);
                assert!(off < tolerance, "{kind} of {species}, β_n {beta_n}°: {off}");
            }
            // With and without total reflection off the medulla.
            for factor in [0.92, 1.15] {
                let model = AnyModel::Yan2015(Yan2015::with_eta_m(&fiber, factor * fiber.eta).unwrap());
                let off = worst(&model, theta_o);
                assert!(off < 2e-3, "η_m = {factor} η, {species}, β_n {beta_n}°: {off}");
            }
        }
    }
}

/// The limits of all ranges give finite results.
#[test]
fn far_fields_of_all_models_are_finite() {
    let directions = Directions::new(&[[-90.0, 10.0], [0.0, 0.0], [0.0, 180.0], [89.0, -360.0], [90.0, 77.0]]);
    for &kind in ModelKind::ALL {
        for kappa in [0.0, 0.3, 0.99] {
            let fiber = Fiber { kappa, eta: 1.3, sigma_ca: [0.5; 3], ..Fiber::published(Species::Dog) };
            let model = kind.model(&fiber).unwrap();
            for theta_o in [-90.0, 0.0, 60.0] {
                let mut out = vec![[-1.0; 3]; directions.len()];
                model.far_field(theta_o, &directions, &mut out);
                assert!(out.iter().flatten().all(|x| x.is_finite() && *x >= 0.0), "{kind} {kappa} {theta_o}: {out:?}");
            }
        }
    }
}
