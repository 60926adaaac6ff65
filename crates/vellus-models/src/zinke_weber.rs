//! A. Zinke, A. Weber 2007, *Light Scattering from Filaments*, IEEE TVCG 13(2): the near field.
//!
//! Light hits a fibre at an offset h. The path with p internal segments leaves at Φₚ(h) with the energy Aₚ(h). Ideal
//! paths are delta functions. Normalised Gaussians in θᵢ (shifted by αₚ) and φ add roughness: S =
//! Σ Aₚ g(θᵢ + θ_o + αₚ; βₚ) g(φ − Φₚ; √(p+1) β_n) / cos²θᵢ.
//!
//! The lobes are R, TT, TRT and TRRT, and TRRT is the rest lobe. The model of the paper allows any number of
//! orders. It uses these parameters of a [`Fiber`]: η, α, β_m, β_n (widths and shifts of Yan17 Table 2, so it differs
//! from `vellus` in the model only) and σ_c,a. κ, σ_m, g and l are ignored.
//!
//! Limits: light is lost where a Gaussian extends beyond ±90° (half of it at grazing incidence). The missing orders
//! have (1 − F) F³ of the light. A test measures both. The model is not reciprocal.

use crate::azimuthal::{Gaussians, GaussiansAt};
use crate::entry::Entry;
use crate::factored::Factored;
use crate::longitudinal::Plane;
use glam::Vec3;
use vellus::{Error, Fiber, Lobe, Model, Window, WindowSupport};
use wide::f32x8;

const NAMES: [Lobe; 8] = [Lobe::R, Lobe::Tt, Lobe::Trt, Lobe::Rest, Lobe::Rest, Lobe::Rest, Lobe::Rest, Lobe::Rest];

/// The model of one fibre.
#[derive(Clone, Debug)]
pub struct ZinkeWeber2007 {
    eta: f32,
    sigma_a: [f32; 3],
    shift: f32x8,
    sigma: f32x8,
    azimuthal: Gaussians,
}

impl ZinkeWeber2007 {
    /// The model of a fibre.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if [`Fiber::validate`] returns it.
    pub fn new(fiber: &Fiber) -> Result<Self, Error> {
        fiber.validate()?;
        let fiber = &fiber.in_air();
        let four = |x: [f32; 4]| std::array::from_fn(|i| x[i.min(3)]);
        Ok(ZinkeWeber2007 {
            eta: fiber.eta,
            sigma_a: fiber.sigma_ca,
            shift: f32x8::new(four([1.0, -0.5, -1.5, -2.5].map(|k| k * fiber.alpha))),
            sigma: f32x8::new(four([1.0, 0.5, 1.5, 2.5].map(|k| k * fiber.beta_m))),
            azimuthal: Gaussians::new(four([1.0f32, 2.0, 3.0, 4.0].map(|k| k.sqrt() * fiber.beta_n)).map(Some)),
        })
    }
}

impl Model for ZinkeWeber2007 {
    type Hit<'a> = Factored<Plane, GaussiansAt<'a>>;

    #[inline]
    fn at(&self, wo: Vec3, window: Window) -> Self::Hit<'_> {
        let entry = Entry::new(wo, window, self.eta, None);
        let pass = entry.pass(self.sigma_a);
        let (f, t) = (entry.fresnel.reflected, entry.fresnel.transmitted);
        let theta_o = entry.polar.sin.atan2(entry.polar.cos);
        let longitudinal = Plane::new(f32x8::splat(-theta_o) - self.shift, self.sigma);
        let inside = longitudinal.inside().to_array();
        let energy = pass.map(|pass| {
            let (tt, again) = (t * t * pass, f * pass);
            let ideal = [f, tt, tt * again, tt * again * again];
            // The part of the Gaussians within ±90°.
            std::array::from_fn(|i| if i < 4 { ideal[i] * inside[i] } else { 0.0 })
        });
        let [r, tt, trt, trrt] = entry.exits();
        let centre = f32x8::new([r, tt, trt, trrt, 0.0, 0.0, 0.0, 0.0]);
        let azimuthal = GaussiansAt { widths: &self.azimuthal, centre };
        Factored::new(entry.frame, energy, longitudinal, azimuthal, &NAMES)
    }

    fn field(&self) -> WindowSupport {
        WindowSupport::Near
    }

    fn with_fiber(&self, fiber: &Fiber) -> Result<Self, Error> {
        Self::new(fiber)
    }
}
