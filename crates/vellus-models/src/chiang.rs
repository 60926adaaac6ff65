//! M. J.-Y. Chiang, B. Bitterli, C. Tappan, B. Burley 2016, *A Practical and Controllable Hair and Fur Model for
//! Production Path Tracing*, Computer Graphics Forum 35(2).
//!
//! A near-field model. It has R, TT, TRT and one rest lobe with all higher orders, so a fibre without absorption
//! scatters all light. Longitudinal lobes are the energy-conserving spherical Gaussians of d'Eon et al. 2011 with v,
//! v/4, 4v and 4v. Azimuthal lobes are trimmed logistics with one width. The rest lobe is uniform in azimuth.
//!
//! The model uses these parameters of a [`Fiber`]: η, σ_c,a (per radius), β_m (√v), β_n (the standard deviation of the
//! logistic, πs/√3) and α. The angle of the scales is α/2, so R shifts by α, TT by −α/2 and TRT by −2α. There is no
//! medulla and no layered cuticle: κ, σ_m, g and l are ignored. For artistic controls, see [`roughness`] and
//! [`vellus::Color::HairReflectance`].
//!
//! Limits: all lobes have the same azimuthal width. The model is not reciprocal.

use crate::azimuthal::{Logistics, LogisticsAt};
use crate::entry::Entry;
use crate::factored::Factored;
use crate::longitudinal::{Spherical, SphericalAt};
use glam::Vec3;
use std::f32::consts::PI;
use vellus::{Error, Fiber, Lobe, Model, Window, WindowSupport};
use wide::f32x8;

const NAMES: [Lobe; 8] = [Lobe::R, Lobe::Tt, Lobe::Trt, Lobe::Rest, Lobe::Rest, Lobe::Rest, Lobe::Rest, Lobe::Rest];

/// β_m and β_n of a [`Fiber`], standard deviations in radians, from the perceptual roughnesses of the paper in [0, 1].
///
/// Eq. 7 and 8, with the factor √(π/8) of pbrt. Above about 0.91 and 0.92, the results exceed the 90° that a fibre
/// allows.
pub fn roughness(beta_m: f32, beta_n: f32) -> [f32; 2] {
    let sqrt_v = 0.726 * beta_m + 0.812 * beta_m.powi(2) + 3.7 * beta_m.powi(20);
    let s = (PI / 8.0).sqrt() * (0.265 * beta_n + 1.194 * beta_n.powi(2) + 5.372 * beta_n.powi(22));
    [sqrt_v, s * PI / 3f32.sqrt()]
}

/// The model of one fibre.
#[derive(Clone, Debug)]
pub struct Chiang2016 {
    eta: f32,
    sigma_a: [f32; 3],
    longitudinal: Spherical,
    azimuthal: Logistics,
}

impl Chiang2016 {
    /// The model of a fibre.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if [`Fiber::validate`] returns it.
    pub fn new(fiber: &Fiber) -> Result<Self, Error> {
        fiber.validate()?;
        let fiber = &fiber.in_air();
        let (alpha, beta) = (fiber.alpha, fiber.beta_m);
        let four = |r: f32, tt: f32, trt: f32| [r, tt, trt, trt, trt, trt, trt, trt];
        let uniform = std::array::from_fn(|i| i >= 3);
        Ok(Chiang2016 {
            eta: fiber.eta,
            sigma_a: fiber.sigma_ca,
            longitudinal: Spherical::new(
                std::array::from_fn(|i| if i < 3 { [alpha, -0.5 * alpha, -2.0 * alpha][i] } else { 0.0 }),
                four(beta, 0.5 * beta, 2.0 * beta),
            ),
            azimuthal: Logistics::new(fiber.beta_n * 3f32.sqrt() / PI, uniform),
        })
    }
}

impl Model for Chiang2016 {
    type Hit<'a> = Factored<SphericalAt<'a>, LogisticsAt<'a>>;

    #[inline]
    fn at(&self, wo: Vec3, window: Window) -> Self::Hit<'_> {
        let entry = Entry::new(wo, window, self.eta, None);
        let pass = entry.pass(self.sigma_a);
        let (f, t) = (entry.fresnel.reflected, entry.fresnel.transmitted);
        let energy = pass.map(|pass| {
            let (tt, again) = (t * t * pass, f * pass);
            // Σ (F T)ᵏ from k = 2. 1 − F T is (1 − F) + F (1 − T), which avoids cancellation.
            let rest = tt * again * again / (t + f * (1.0 - pass)).max(1e-20);
            [f, tt, tt * again, rest, 0.0, 0.0, 0.0, 0.0]
        });
        let [r, tt, trt, _] = entry.exits();
        let centre = f32x8::new([r, tt, trt, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let azimuthal = LogisticsAt { widths: &self.azimuthal, centre };
        Factored::new(entry.frame, energy, self.longitudinal.at(entry.polar), azimuthal, &NAMES)
    }

    fn field(&self) -> WindowSupport {
        WindowSupport::Near
    }

    fn with_fiber(&self, fiber: &Fiber) -> Result<Self, Error> {
        Self::new(fiber)
    }
}
