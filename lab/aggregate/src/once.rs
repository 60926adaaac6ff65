//! Single scattering: the probability that light which collided leaves the bunch without another collision.

use crate::quadrature::points;
use std::f64::consts::{PI, TAU};

/// Azimuths from 0 to π at which single scattering is known.
pub(crate) const AZIMUTHS: usize = 97;

/// Azimuths of the whole circle, so that a change of azimuth is a shift of the index.
const CIRCLE: usize = 2 * (AZIMUTHS - 1);

/// E₁(φ) over the probability to collide, at [`AZIMUTHS`] equidistant changes of azimuth from 0 (back) to π.
///
/// E₁ = σ/2 ∫ exp(−σ (a + b)) dA over the unit disc, with σ = τ/2. a and b are the distances from the place of the
/// collision to the edge, along ω_o and ω_i. The probability to collide is the same integral without b. Exchanging
/// ω_o and ω_i exchanges a and b, so this factor is reciprocal. It is 1 for τ = 0.
///
/// `carried` shortens b: a fibre of a finite radius carries light through itself, in radii of the disc.
///
/// The error against a fine quadrature is below 1e-5 for τ ≤ 16.
pub(crate) fn leaves_after_one(tau: f64, carried: f64) -> Vec<f64> {
    let sigma = 0.5 * tau;
    let mut both = vec![0.0; AZIMUTHS];
    let mut first = 0.0;
    // ρ = sin ψ, because distances have the slope of √(1 − ρ²) at the edge.
    for (psi, weight) in points(0.0, 0.5 * PI, 8) {
        let rho = psi.sin();
        let area = weight * psi.cos() * rho * TAU / CIRCLE as f64;
        let distances: Vec<f64> = (0..CIRCLE)
            .map(|k| {
                let (sin, cos) = (k as f64 * TAU / CIRCLE as f64).sin_cos();
                -rho * cos + (1.0 - (rho * sin).powi(2)).max(0.0).sqrt()
            })
            .collect();
        let comes: Vec<f64> = distances.iter().map(|a| (-sigma * a).exp()).collect();
        let leaves: Vec<f64> = distances.iter().map(|b| (-sigma * (b - carried).max(0.0)).exp()).collect();
        first += area * comes.iter().sum::<f64>();
        for (shift, sum) in both.iter_mut().enumerate() {
            let turned = leaves[shift..].iter().chain(&leaves[..shift]);
            *sum += area * comes.iter().zip(turned).map(|(a, b)| a * b).sum::<f64>();
        }
    }
    both.into_iter().map(|sum| sum / first).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bunch::Bunch;
    use crate::quadrature::gauss;

    /// Back and forward have one integral over the offset: (1 − e^(−2τc))/2 and τ c e^(−τc), for the half chord c.
    #[test]
    fn back_and_forward_are_closed_forms() {
        for tau in [1e-3, 0.1, 1.0, 4.0, 16.0] {
            let leaves = leaves_after_one(tau, 0.0);
            let collides = 1.0 - Bunch::new(tau).unwrap().mean_passes();
            let over = |f: &dyn Fn(f64) -> f64| gauss(0.0, 0.5 * PI, 8, |g| g.cos() * f(tau * g.cos())) / collides;
            let back = over(&|chord| -0.5 * (-2.0 * chord).exp_m1());
            let forward = over(&|chord| chord * (-chord).exp());
            assert!((leaves[0] - back).abs() < 1e-5, "{tau}: {} {back}", leaves[0]);
            assert!((leaves[AZIMUTHS - 1] - forward).abs() < 1e-5, "{tau}: {} {forward}", leaves[AZIMUTHS - 1]);
            assert!(leaves.windows(2).all(|pair| pair[1] <= pair[0]), "{tau}");
        }
        assert!(leaves_after_one(0.0, 0.1).iter().all(|e| (e - 1.0).abs() < 1e-12));
    }
}
