//! RenderMan's `PxrMarschnerHair`.

use crate::error::Error;
use crate::read::shading::mapping::Mapping;
use crate::read::shading::value::Value;
use vellus::Parameter;

/// Reads `PxrMarschnerHair`. Its lobes have gains and colours of their own, so the result is an approximation: the
/// absorption gives TT the colour `specularColorTT` on average.
pub(super) fn map(mapping: &mut Mapping) -> Result<(), Error> {
    let eta = mapping.constant("specularIor", 1.55)?;
    let tint = mapping.share("specularColorTT", [0.4; 3])?;
    let chord = mean_chord(eta.max(1.0));
    let sigma = tint.map_each(|c| -c.clamp(1e-4, 1.0).ln() / chord);
    mapping.set(Parameter::SigmaCa, sigma, "specularColorTT");
    let cone = mapping.number("specularConeAngleR", 8.0)?;
    mapping.set(Parameter::BetaM, cone.map_each(f64::to_radians), "specularConeAngleR");
    mapping.set(Parameter::Eta, Value::number(eta), "specularIor");
    // Marschner's α is negative towards the root, and R turns by twice that angle.
    let offset = mapping.constant("specularOffset", -3.0)?;
    mapping.set(Parameter::Alpha, Value::number(-2.0 * offset.to_radians()), "specularOffset");
    mapping.lose_unless(1.0, &["specularGainR", "specularGainTRT", "specularGainTT", "specularGainGLINTS"])?;
    mapping.lose_unless(1.0, &["specularColorR", "specularMixFresnel", "specularEccentricity", "presence"])?;
    mapping.lose_unless(0.0, &["diffuseGain", "glowGain", "specularEnergyCompensation", "shadowColor"])?;
    mapping.lose("specularColorTRT");
    mapping.lose("cone angles of TT and TRT");
    mapping.known(&["specularConeAngleTT", "specularConeAngleTRT"]);
    mapping.lose("specularGlintWidth");
    Ok(())
}

/// The mean length, in radii, of the way through the fibre at normal incidence: the mean of 2 √(1 − h²/η²) over h.
fn mean_chord(eta: f64) -> f64 {
    let sine = 1.0 / eta;
    (1.0 - sine * sine).sqrt() + eta * sine.asin()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_chord_is_the_mean_over_the_offsets() {
        for eta in [1.2f64, 1.55, 2.0] {
            // The midpoint rule of a smooth function: its error is far below 1e-6 with 1,000 intervals.
            let sum: f64 = (0..1000).map(|i| 2.0 * (1.0 - ((i as f64 + 0.5) / 1000.0 / eta).powi(2)).sqrt()).sum();
            assert!((mean_chord(eta) - sum / 1000.0).abs() < 1e-6);
        }
        // No refraction: half a circle's area over its radius.
        assert!((mean_chord(1.0) - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    }
}
