//! Formulas in f64 that depend on numbers only.

use std::f64::consts::{PI, TAU};

/// F(η, cos, l): the reflectance of `layers` ≥ 0 cuticle slabs over a dielectric of relative index `eta` ≥ 1, at an
/// angle of incidence with the cosine `cos` in [0, 1] (Yan17 Eq. 13). [`vellus::fresnel`] is the fast version.
pub fn fresnel(eta: f64, layers: f64, cos: f64) -> f64 {
    if eta == 1.0 || layers == 0.0 {
        return 0.0;
    }
    let [r_s, r_p] = polarised(eta, cos);
    let phi = 0.5 * (2.0 * r_s / (1.0 + r_s) + 2.0 * r_p / (1.0 + r_p));
    layers * phi / (1.0 + (layers - 1.0) * phi)
}

/// The unpolarised reflectance of a smooth interface with the relative index `eta` ≥ 1, at an angle of incidence with
/// the cosine `cos` in [0, 1].
pub fn interface(eta: f64, cos: f64) -> f64 {
    let [r_s, r_p] = polarised(eta, cos);
    if eta == 1.0 { 0.0 } else { 0.5 * (r_s + r_p) }
}

/// The reflectance of an interface for both polarisations.
fn polarised(eta: f64, cos: f64) -> [f64; 2] {
    let cos_t = (1.0 - (1.0 - cos * cos) / (eta * eta)).max(0.0).sqrt();
    [(cos, eta * cos_t), (eta * cos, cos_t)].map(|(a, b)| ((a - b) / (a + b)).powi(2))
}

/// M̂(θᵢ), the longitudinal lobe of d'Eon et al. 2011 (D8), with the centre `theta_c` (radians) and the variance `v` >
/// 0. It is a density in sin θᵢ. The log form does not overflow for any `v`.
pub fn longitudinal(theta_c: f64, v: f64, theta_i: f64) -> f64 {
    let x = (theta_c.cos() * theta_i.cos() / v).abs();
    let log = (theta_c.sin() * theta_i.sin() - 1.0) / v + x;
    log.exp() * bessel_i0e(x) / (v * -(-2.0 / v).exp_m1())
}

/// e⁻ˣ I₀(x), the scaled modified Bessel function, for x ≥ 0. The relative error is below 1e-14.
///
/// It sums the power series for x < 30. Above, it sums the asymptotic series, whose terms fall below 1e-17.
pub fn bessel_i0e(x: f64) -> f64 {
    if x < 30.0 {
        let (mut term, mut sum, mut k) = (1.0, 1.0, 1.0);
        while term > 1e-18 * sum {
            term *= (x / (2.0 * k)).powi(2);
            sum += term;
            k += 1.0;
        }
        return sum * (-x).exp();
    }
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..25 {
        let odd = f64::from(2 * k - 1);
        term *= odd * odd / (8.0 * f64::from(k) * x);
        sum += term;
    }
    sum / (TAU * x).sqrt()
}

/// A normal density of standard deviation `sigma`, wrapped on the circle, at the distance `d` from its centre (both in
/// radians). All images within eight standard deviations are summed.
pub fn wrapped_gaussian(d: f64, sigma: f64) -> f64 {
    let d = wrap(d);
    let images = ((8.0 * sigma + PI) / TAU) as i32;
    let sum: f64 = (-images..=images).map(|k| (-0.5 * ((d + TAU * f64::from(k)) / sigma).powi(2)).exp()).sum();
    sum / (sigma * TAU.sqrt())
}

/// Wraps an angle to [−π, π).
pub(crate) fn wrap(x: f64) -> f64 {
    (x + PI).rem_euclid(TAU) - PI
}

/// The density per radian of the wrapped Cauchy distribution with this mean of cos φ and sin φ.
pub(super) fn wrapped_cauchy([cos, sin]: [f64; 2], phi: f64) -> f64 {
    let square = cos * cos + sin * sin;
    (1.0 - square) / (1.0 + square - 2.0 * (cos * phi.cos() + sin * phi.sin())) / TAU
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 50-digit values (mpmath), rounded to double.
    const I0E: [(f64, f64); 14] = [
        (0.0, 1.0),
        (0.001, 0.9990007495835156),
        (0.1, 0.9071009257823011),
        (1.0, 0.46575960759364043),
        (3.0, 0.2430003541618254),
        (4.999, 0.18356038432689242),
        (5.0, 0.18354081260932836),
        (5.001, 0.18352124723440244),
        (10.0, 0.1278333371634286),
        (29.99, 0.07315824574297991),
        (30.01, 0.07313365342356991),
        (100.0, 0.03994437929909668),
        (3125.0, 0.00713678197586958),
        (328281.0, 0.0006962855098856036),
    ];

    #[test]
    fn bessel_matches_high_precision() {
        for (x, expected) in I0E {
            let value = bessel_i0e(x);
            assert!((value / expected - 1.0).abs() < 1e-14, "{x}: {value} {expected}");
        }
    }
}
