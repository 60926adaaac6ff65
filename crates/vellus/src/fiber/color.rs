//! The colour of a fibre: as absorption, as melanin, or as the reflectance of many fibres.

use crate::error::Error;
use crate::fiber::parameter::Parameter;

/// A way to give the colour of the cortex.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Color {
    /// σ_c,a itself, RGB, per fibre radius, in [0, 1000].
    Absorption([f32; 3]),
    /// Concentrations of the two pigments, each in [0, 100]. Hair lies between 0 (white) and 8 (black eumelanin).
    ///
    /// σ = c_e (0.419, 0.697, 1.37) + c_p (0.187, 0.4, 1.05): the RGB constants of d'Eon et al. 2011, An
    /// Energy-Conserving Hair Reflectance Model, which pbrt-v3/v4 and Mitsuba 3 also use.
    Melanin {
        /// Concentration of eumelanin, brown to black.
        eumelanin: f32,
        /// Concentration of pheomelanin, yellow to red.
        pheomelanin: f32,
    },
    /// The colour of an *assembly* of such fibres, RGB in [0.001, 0.999], by the fit of Chiang et al. 2016, A
    /// Practical and Controllable Hair and Fur Model for Production Path Tracing, Eq. 9. The fit is for hair without
    /// medulla.
    Reflectance([f32; 3]),
}

impl Color {
    /// σ_c,a, RGB, per fibre radius. `beta_n` is the azimuthal roughness in radians; only a reflectance depends on it.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for an absorption, concentration, reflectance or roughness out of range.
    pub fn absorption(self, beta_n: f32) -> Result<[f32; 3], Error> {
        const EUMELANIN: [f32; 3] = [0.419, 0.697, 1.37];
        const PHEOMELANIN: [f32; 3] = [0.187, 0.4, 1.05];
        match self {
            Color::Absorption(sigma) => Parameter::SigmaCa.check(sigma).map(|()| sigma),
            Color::Melanin { eumelanin, pheomelanin } => {
                Parameter::Melanin.check([eumelanin, pheomelanin, 0.0])?;
                Ok(std::array::from_fn(|c| eumelanin * EUMELANIN[c] + pheomelanin * PHEOMELANIN[c]))
            }
            Color::Reflectance(color) => {
                Parameter::Reflectance.check(color)?;
                Parameter::BetaN.check([beta_n; 3])?;
                let b = f64::from(perceptual_roughness(beta_n));
                let d = 5.969 + b * (-0.215 + b * (2.532 + b * (-10.73 + b * (5.574 + b * 0.245))));
                Ok(color.map(|c| ((f64::from(c).ln() / d).powi(2)) as f32))
            }
        }
    }
}

/// Chiang's azimuthal roughness in [0, 1] for which the logistic has the standard deviation `beta_n`: π s/√3 = β_n
/// with s = √(π/8) (0.265 β + 1.194 β² + 5.372 β²²) (Chiang et al. 2016, Eq. 8, with the factor of pbrt). Wider lobes
/// than theirs get 1.
fn perceptual_roughness(beta_n: f32) -> f32 {
    let s = beta_n * 3f32.sqrt() / std::f32::consts::PI / (std::f32::consts::PI / 8.0).sqrt();
    let (mut lo, mut hi) = (0.0f32, 1.0f32);
    // The polynomial is monotone in β, and 30 bisections reach the last bit.
    for _ in 0..30 {
        let b = 0.5 * (lo + hi);
        if 0.265 * b + 1.194 * b * b + 5.372 * b.powi(22) < s { lo = b } else { hi = b }
    }
    0.5 * (lo + hi)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn melanin_is_linear_and_reflectance_is_monotone() {
        let brown = Color::Melanin { eumelanin: 1.3, pheomelanin: 0.2 }.absorption(0.1).unwrap();
        assert!((brown[0] - (1.3 * 0.419 + 0.2 * 0.187)).abs() < 1e-6);
        let sigma = Color::Reflectance([0.1, 0.5, 0.9]).absorption(0.15).unwrap();
        assert!(sigma[0] > sigma[1] && sigma[1] > sigma[2] && sigma[2] > 0.0);
    }

    /// pbrt-v4 documents σ_a for β_n = 0.3 and a grey of 0.5: (ln 0.5/5.7508…)² with its polynomial.
    #[test]
    fn reflectance_agrees_with_the_published_polynomial() {
        let b = 0.3f64;
        let s = (std::f64::consts::PI / 8.0).sqrt() * (0.265 * b + 1.194 * b * b + 5.372 * b.powi(22));
        let beta_n = (s * std::f64::consts::PI / 3f64.sqrt()) as f32;
        let d: f64 = 5.969 - 0.215 * b + 2.532 * b.powi(2) - 10.73 * b.powi(3) + 5.574 * b.powi(4) + 0.245 * b.powi(5);
        let expected = (0.5f64.ln() / d).powi(2);
        let sigma = f64::from(Color::Reflectance([0.5; 3]).absorption(beta_n).unwrap()[1]);
        assert!((sigma / expected - 1.0).abs() < 1e-4, "{sigma} {expected}");
    }

    #[test]
    fn bad_colours_are_named() {
        let e = Color::Reflectance([0.5, 1.2, 0.5]).absorption(0.1).unwrap_err().to_string();
        assert!(e.contains("reflectance.g = 1.2") && e.contains("[0.001, 0.999]"), "{e}");
        assert!(Color::Melanin { eumelanin: f32::NAN, pheomelanin: 0.0 }.absorption(0.1).is_err());
    }
}
