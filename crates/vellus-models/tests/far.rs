//! Far fields of near-field models against sums over very many offsets.

use vellus::{Fiber, Model, Scattering, Species, Window};
use vellus_models::{AnyModel, Directions, ModelKind, Yan2015};

/// The mean over 10,000 offsets, equidistant in γ: of directions one by one, through the model's own `eval`.
fn slow(model: &AnyModel, theta_o: f64, directions: &Directions) -> Vec<[f64; 3]> {
    let n = 10_000;
    let (sin, cos) = theta_o.to_radians().sin_cos();
    let wo = glam::Vec3::new(sin as f32, cos as f32, 0.0);
    let wi: Vec<_> = directions.vectors().collect();
    let mut sums = vec![[0.0; 3]; wi.len()];
    for k in 0..n {
        let gamma = ((f64::from(k) + 0.5) / f64::from(n) - 0.5) * std::f64::consts::PI;
        let weight = 0.5 * gamma.cos() * std::f64::consts::PI / f64::from(n);
        let hit = model.at(wo, Window::near(gamma.sin() as f32));
        for (sum, wi) in sums.iter_mut().zip(&wi) {
            let f = hit.eval(*wi).total();
            (0..3).for_each(|c| sum[c] += weight * f64::from(f[c]));
        }
    }
    sums
}

fn directions() -> Directions {
    let angles: Vec<[f64; 2]> =
        (0..60).map(|i| [f64::from(i % 5) * 13.0 - 12.0, f64::from(i / 5) * 31.0 - 17.0 + f64::from(i % 2)]).collect();
    Directions::new(&angles)
}

#[test]
fn far_fields_match_many_offsets() {
    let directions = directions();
    let mut worst = 0.0f64;
    for species in [Species::Bobcat, Species::RedFox, Species::Raccoon, Species::Human] {
        let preset = Fiber::preset(species);
        for (beta_n, theta_o) in [(preset.beta_n.to_degrees(), -30.0), (1.0, 20.0), (1.5, 65.0), (30.0, 0.0)] {
            let fiber = Fiber { sigma_ca: [0.1, 0.4, 1.2], beta_n: beta_n.to_radians(), ..preset };
            let kinds = [ModelKind::Chiang2016, ModelKind::ZinkeWeber2007, ModelKind::Yan2015];
            let split = [0.92, 1.15].map(|x| AnyModel::Yan2015(Yan2015::with_eta_m(&fiber, x * fiber.eta).unwrap()));
            let models = kinds.map(|kind| kind.model(&fiber).unwrap()).into_iter().chain(split);
            for (i, model) in models.enumerate() {
                let mut fast = vec![[0.0; 3]; directions.len()];
                let t = std::time::Instant::now();
                model.far_field(theta_o, &directions, &mut fast);
                let t = t.elapsed().as_secs_f64();
                let mut off = 0.0f64;
                for (fast, slow) in fast.iter().zip(slow(&model, theta_o, &directions)) {
                    for c in 0..3 {
                        off = off.max((f64::from(fast[c]) / slow[c] - 1.0).abs());
                    }
                }
                println!("{species} {beta_n} {theta_o} {i}: {off:.1e} {:.0} us", t * 1e6);
                worst = worst.max(off);
            }
        }
    }
    assert!(worst < 1e-3, "{worst}");
}
