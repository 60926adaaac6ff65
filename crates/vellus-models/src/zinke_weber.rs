//! A. Zinke, A. Weber 2007, *Light Scattering from Filaments*, IEEE TVCG 13(2): the near field.
//!
//! A fibre is hit at an offset h; light that meets the interface p times leaves at Φₚ(h) with the energy Aₚ(h). The
//! ideal paths are deltas; roughness is put in by normalised Gaussians in θᵢ (shifted by the cuticle's tilt) and φ: S =
//! Σ Aₚ g(θᵢ + θ_o + αₚ; βₚ) g(φ − Φₚ; √(p+1) β_n) / cos²θᵢ.
//!
//! R, TT, TRT and TRRT, the last as `rest`; their paths go on without end. Of a [`Fiber`] it takes η, α, β_m, β_n
//! (widths and shifts of Yan17 Table 2, so that only the model differs from ours) and σ_c,a; κ, σ_m, g and l are
//! ignored.
//!
//! Limits: light is lost where a Gaussian reaches beyond ±90° (half of it at grazing incidence), and with the orders
//! left out, (1 − F) F³ of it; the test says how much. Not reciprocal.

use crate::azimuthal::{Gaussians, GaussiansAt};
use crate::entry::Entry;
use crate::factored::Factored;
use crate::longitudinal::Plane;
use glam::Vec3;
use vellus::{Error, Fiber, Field, Lobe, Model, Window};
use wide::f32x8;

const NAMES: [Lobe; 8] = [Lobe::R, Lobe::Tt, Lobe::Trt, Lobe::Rest, Lobe::Rest, Lobe::Rest, Lobe::Rest, Lobe::Rest];

/// The model of one fibre.
#[derive(Clone, Debug)]
pub struct ZinkeWeber2007 {
    eta: f32,
    sigma_a: [f32; 3],
    shift: f32x8,
    sigma: f32x8,
    around: Gaussians,
}

impl ZinkeWeber2007 {
    /// Prepares a fibre.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] where [`Fiber::validate`] finds one.
    pub fn new(fiber: &Fiber) -> Result<Self, Error> {
        fiber.validate()?;
        let four = |x: [f32; 4]| std::array::from_fn(|i| x[i.min(3)]);
        Ok(ZinkeWeber2007 {
            eta: fiber.eta,
            sigma_a: fiber.sigma_ca,
            shift: f32x8::new(four([1.0, -0.5, -1.5, -2.5].map(|k| k * fiber.alpha))),
            sigma: f32x8::new(four([1.0, 0.5, 1.5, 2.5].map(|k| k * fiber.beta_m))),
            around: Gaussians::new(four([1.0f32, 2.0, 3.0, 4.0].map(|k| k.sqrt() * fiber.beta_n)).map(Some)),
        })
    }
}

impl Model for ZinkeWeber2007 {
    type Hit<'a> = Factored<Plane, GaussiansAt<'a>>;

    #[inline]
    fn at(&self, wo: Vec3, window: Window) -> Self::Hit<'_> {
        let entry = Entry::new(wo, window, self.eta, 0.5);
        let pass = entry.pass(self.sigma_a);
        let (f, t) = (entry.fresnel.reflected, entry.fresnel.transmitted);
        let theta_o = entry.polar.sin.atan2(entry.polar.cos);
        let along = Plane::new(f32x8::splat(-theta_o) - self.shift, self.sigma);
        let inside = along.inside().to_array();
        let energy = pass.map(|pass| {
            let (tt, again) = (t * t * pass, f * pass);
            let ideal = [f, tt, tt * again, tt * again * again];
            // What the Gaussians leave within ±90°.
            std::array::from_fn(|i| if i < 4 { ideal[i] * inside[i] } else { 0.0 })
        });
        let [r, tt, trt, trrt] = entry.exits();
        let centre = f32x8::new([r, tt, trt, trrt, 0.0, 0.0, 0.0, 0.0]);
        let around = GaussiansAt { widths: &self.around, centre };
        Factored::new(entry.frame, energy, along, around, &NAMES)
    }

    fn field(&self) -> Field {
        Field::Near
    }

    fn with_fiber(&self, fiber: &Fiber) -> Result<Self, Error> {
        Self::new(fiber)
    }
}
