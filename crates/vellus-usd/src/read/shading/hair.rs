//! Formulas of Chiang et al. 2016, "A Practical and Controllable Hair and Fur Model for Production Path Tracing", and
//! of d'Eon et al. 2011, "An Energy-Conserving Hair Reflectance Model".

use crate::read::shading::mapping::Mapping;
use crate::read::shading::value::Value;
use std::f64::consts::PI;
use vellus::Parameter;

/// The variance along the fibre, of the longitudinal roughness (Chiang et al., section 4.1).
pub(super) fn variance(roughness: f64) -> f64 {
    (0.726 * roughness + 0.812 * roughness.powi(2) + 3.7 * roughness.powi(20)).powi(2)
}

/// The scale of the logistic distribution around the fibre, of the azimuthal roughness, without the factor √(π/8)
/// (Chiang et al., section 4.1).
pub(super) fn scale(roughness: f64) -> f64 {
    0.265 * roughness + 1.194 * roughness.powi(2) + 5.372 * roughness.powi(22)
}

/// β_m in radians, of a variance along the fibre.
pub(super) fn beta_m(variance: f64) -> f64 {
    variance.sqrt()
}

/// β_n in radians, of the [`scale`] of TT. Its distribution has the scale √(π/8) s. A logistic distribution of scale s
/// has the variance π² s² / 3, and TT passes our azimuthal roughness twice.
pub(super) fn beta_n(scale: f64) -> f64 {
    PI * (PI / 8.0).sqrt() * scale / 6f64.sqrt()
}

/// α in radians, of the tilt of the cuticle's scales in degrees. R turns by twice the tilt, and by our α.
pub(super) fn alpha(tilt: f64) -> f64 {
    2.0 * tilt.to_radians()
}

/// σ per radius, of a colour and the azimuthal roughness (Chiang et al., section 4.2).
pub(super) fn absorption_of_color(color: f64, b: f64) -> f64 {
    let fit = 5.969 - 0.215 * b + 2.532 * b.powi(2) - 10.73 * b.powi(3) + 5.574 * b.powi(4) + 0.245 * b.powi(5);
    (color.clamp(1e-3, 1.0).ln() / fit).powi(2)
}

/// Amount of melanin, of a concentration from 0 to 1.
pub(super) fn melanin(concentration: f64) -> f64 {
    -(1.0 - concentration.min(1.0)).max(1e-4).ln()
}

/// σ of eumelanin and pheomelanin (d'Eon et al., section 6.1).
const PIGMENTS: [[f64; 3]; 2] = [[0.506, 0.841, 1.653], [0.343, 0.733, 1.924]];

/// σ of an amount of melanin, of which the share `redness` is pheomelanin.
pub(super) fn absorption_of_melanin(amount: f64, redness: f64, [eu, pheo]: [[f64; 3]; 2]) -> [f64; 3] {
    std::array::from_fn(|i| amount * ((1.0 - redness) * eu[i] + redness * pheo[i]))
}

/// σ per radius, of a colour (Chiang's inversion) and of melanin with the pigments of d'Eon et al. Both add up.
pub(super) fn absorption(color: Value, concentration: Value, redness: Value, around: Value) -> Value {
    let dye = color.with(around, |c, b| c.map(|c| absorption_of_color(c, b[0])));
    let melanin = concentration.with(redness, |c, r| absorption_of_melanin(melanin(c[0]), r[0], PIGMENTS));
    dye.with(melanin, |a, b| std::array::from_fn(|i| a[i] + b[i]))
}

/// β_m of a variance, which MaterialX's GLSL limits to this range.
pub(super) fn limited_beta_m(variance: Value) -> Value {
    variance.map_each(|v| beta_m(v.clamp(0.001, 1.0)))
}

/// β_n of a scale, which MaterialX's GLSL limits to this range.
pub(super) fn limited_beta_n(scale: Value) -> Value {
    scale.map_each(|s| beta_n(s.clamp(0.001, 1.0)))
}

/// Sets β_m and β_n of a variance and a scale.
pub(super) fn set_roughness(mapping: &mut Mapping, variance: Value, scale: Value, from: [&str; 2]) {
    mapping.set(Parameter::BetaM, limited_beta_m(variance), from[0]);
    mapping.set(Parameter::BetaN, limited_beta_n(scale), from[1]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_formulas_give_the_values_of_hand_calculation() {
        // √(π/8) = 0.626657; π · 0.626657 · 0.1 / √6 = 0.0803724.
        assert!((beta_n(0.1) - 0.0803724).abs() < 1e-6);
        assert!((alpha(1.8).to_degrees() - 3.6).abs() < 1e-9);
        // 0.726 · 0.2 + 0.812 · 0.04 = 0.17768; 3.7 · 0.2²⁰ is less than 1e-13.
        assert!((variance(0.2) - 0.17768f64.powi(2)).abs() < 1e-9);
        assert!((scale(0.2) - 0.10076).abs() < 1e-9);
        // The polynomial at 0.3 is 5.969 − 0.0645 + 0.22788 − 0.28971 + 0.0451494 + 0.00059535.
        let fit = 5.8884147f64;
        assert!((absorption_of_color(0.5, 0.3) - (0.5f64.ln() / fit).powi(2)).abs() < 1e-7);
        assert!((melanin(0.5) - 2f64.ln()).abs() < 1e-12 && melanin(1.0).is_finite());
        let sigma = absorption_of_melanin(2.0, 0.25, PIGMENTS);
        assert!((sigma[0] - 2.0 * (0.75 * 0.506 + 0.25 * 0.343)).abs() < 1e-12);
    }
}
