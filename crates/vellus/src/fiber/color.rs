//! The colour of a fibre: as absorption, as melanin, or as the reflectance of many fibres.

use crate::coat::CoatColors;
use crate::error::Error;
use crate::fiber::Fiber;
use crate::fiber::parameter::Parameter;

/// A way to give the colour of a fibre.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Color {
    /// σ_c,a itself, RGB, per fibre radius, in [0, 1000].
    Absorption([f32; 3]),
    /// Concentrations of the two pigments, each in [0, 100]. Hair lies between 0 (white) and 8 (black eumelanin).
    ///
    /// σ = c_e (0.419, 0.697, 1.37) + c_p (0.187, 0.4, 1.05): the RGB constants of d'Eon et al. 2011, An
    /// Energy-Conserving Hair Reflectance Model, which pbrt-v3/v4 and Mitsuba 3 also use. It is σ_c,a, and
    /// [`Fiber::medulla_pigment`] times as much is σ_m,a.
    Melanin {
        /// Concentration of eumelanin, brown to black.
        eumelanin: f32,
        /// Concentration of pheomelanin, yellow to red.
        pheomelanin: f32,
    },
    /// The colour of a dense coat of such fibres in white light, RGB in [0.001, 0.999]: see [`CoatColors`]. It sets the
    /// absorption of cortex and medulla. [`Fiber::with_color`] says what it costs.
    Reflectance([f32; 3]),
    /// σ_c,a by the fit of Chiang et al. 2016, A Practical and Controllable Hair and Fur Model for Production Path
    /// Tracing, Eq. 9: the colour of an assembly of hairs without medulla in their model, RGB in [0.001, 0.999]. It is
    /// for comparisons.
    HairReflectance([f32; 3]),
}

impl Color {
    /// The parameter that gives a colour in this way, and its value.
    pub fn parameter(self) -> (Parameter, [f32; 3]) {
        match self {
            Color::Absorption(sigma) => (Parameter::SigmaCa, sigma),
            Color::Melanin { eumelanin, pheomelanin } => (Parameter::Melanin, [eumelanin, pheomelanin, 0.0]),
            Color::Reflectance(color) => (Parameter::Reflectance, color),
            Color::HairReflectance(color) => (Parameter::HairReflectance, color),
        }
    }

    /// The fibre with this colour.
    pub(crate) fn apply(self, fiber: Fiber) -> Result<Fiber, Error> {
        let (parameter, value) = self.parameter();
        parameter.check(value)?;
        Ok(match self {
            Color::Absorption(sigma) => fiber.with_absorption(sigma),
            Color::Melanin { eumelanin, pheomelanin } => fiber.with_pigment(melanin(eumelanin, pheomelanin)),
            Color::Reflectance(color) => {
                let colors = CoatColors::new(&fiber)?;
                Fiber { reflectance: Some(color), ..fiber.with_pigment(color.map(|c| colors.absorption(c))) }
            }
            Color::HairReflectance(color) => {
                Parameter::BetaN.check([fiber.beta_n; 3])?;
                let b = f64::from(perceptual_roughness(fiber.beta_n));
                let d = 5.969 + b * (-0.215 + b * (2.532 + b * (-10.73 + b * (5.574 + b * 0.245))));
                fiber.with_absorption(color.map(|c| ((f64::from(c).ln() / d).powi(2)) as f32))
            }
        })
    }
}

/// The absorption of a concentration of 1, RGB, per fibre radius.
pub const EUMELANIN: [f32; 3] = [0.419, 0.697, 1.37];
/// See [`EUMELANIN`].
pub const PHEOMELANIN: [f32; 3] = [0.187, 0.4, 1.05];

/// The absorption of two concentrations, RGB, per fibre radius.
fn melanin(eumelanin: f32, pheomelanin: f32) -> [f32; 3] {
    std::array::from_fn(|c| eumelanin * EUMELANIN[c] + pheomelanin * PHEOMELANIN[c])
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

    fn hair(beta_n: f32, color: Color) -> Result<[f32; 3], Error> {
        Fiber { beta_n, ..Fiber::hair() }.with_color(color).map(|fiber| fiber.sigma_ca)
    }

    #[test]
    fn melanin_is_linear_and_reflectance_is_monotone() {
        let brown = Fiber::hair().with_color(Color::Melanin { eumelanin: 1.3, pheomelanin: 0.2 }).unwrap();
        assert!((brown.sigma_ca[0] - (1.3 * 0.419 + 0.2 * 0.187)).abs() < 1e-6);
        assert!((brown.sigma_ma[0] - 0.3 * brown.sigma_ca[0]).abs() < 1e-6);
        for color in [Color::Reflectance([0.1, 0.5, 0.9]), Color::HairReflectance([0.1, 0.5, 0.9])] {
            let sigma = hair(0.15, color).unwrap();
            assert!(sigma[0] > sigma[1] && sigma[1] > sigma[2] && sigma[2] > 0.0);
        }
    }

    /// pbrt-v4 documents σ_a for β_n = 0.3 and a grey of 0.5: (ln 0.5/5.7508…)² with its polynomial.
    #[test]
    fn hair_reflectance_agrees_with_the_published_polynomial() {
        let b = 0.3f64;
        let s = (std::f64::consts::PI / 8.0).sqrt() * (0.265 * b + 1.194 * b * b + 5.372 * b.powi(22));
        let beta_n = (s * std::f64::consts::PI / 3f64.sqrt()) as f32;
        let d: f64 = 5.969 - 0.215 * b + 2.532 * b.powi(2) - 10.73 * b.powi(3) + 5.574 * b.powi(4) + 0.245 * b.powi(5);
        let expected = (0.5f64.ln() / d).powi(2);
        let sigma = f64::from(hair(beta_n, Color::HairReflectance([0.5; 3])).unwrap()[1]);
        assert!((sigma / expected - 1.0).abs() < 1e-4, "{sigma} {expected}");
    }

    #[test]
    fn bad_colours_are_named() {
        let e = hair(0.1, Color::Reflectance([0.5, 1.2, 0.5])).unwrap_err().to_string();
        assert!(e.contains("reflectance.g = 1.2") && e.contains("[0.001, 0.999]"), "{e}");
        assert!(hair(0.1, Color::Melanin { eumelanin: f32::NAN, pheomelanin: 0.0 }).is_err());
        assert!(hair(9.0, Color::Reflectance([0.5; 3])).unwrap_err().to_string().contains("beta_n"));
    }
}
