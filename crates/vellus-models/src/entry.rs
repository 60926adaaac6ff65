//! Refraction of a ray into a dielectric cylinder at an offset: the first step of all near-field models.

use std::f32::consts::PI;
use vellus::parts::{Frame, Polar};
use vellus::{Fresnel, Lanes, Window, fresnel};

/// Angles and reflectance of a ray that enters a fibre.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    pub polar: Polar<f32>,
    pub frame: Frame<f32>,
    /// γ_o = asin h; γ_t is the refracted angle.
    pub gamma_o: f32,
    pub gamma_t: f32,
    pub cos_gamma_t: f32,
    /// h/η′, the offset of the refracted ray.
    pub h_inside: f32,
    /// 1/cos θ_t inside.
    pub elongation: f32,
    pub fresnel: Fresnel<f32>,
}

impl Entry {
    /// A ray from `wo` at the centre of `window`. `eta` is the refractive index and `layers` the number of cuticle
    /// layers, where 0.5 is a single interface.
    #[inline(always)]
    pub fn new(wo: glam::Vec3, window: Window, eta: f32, layers: f32) -> Self {
        let [low, high] = window.ends();
        let h = 0.5 * (low + high);
        let wo = wo.to_array();
        let polar = Polar::new(wo);
        let inverse_cos = 1.0 / polar.cos.max(1e-12);
        // 1/η′ = cos θ_o/√(η² − sin²θ_o), without cancellation for η → 1.
        let excess = ((eta - 1.0) * (eta + 1.0) + polar.cos * polar.cos).max(1e-20);
        let h_inside = h * polar.cos / excess.sqrt();
        let cos = |x: f32| ((1.0 - x) * (1.0 + x)).max(0.0).sqrt();
        let (cos_gamma_o, cos_gamma_t) = (cos(h), cos(h_inside));
        let [gamma_o, gamma_t] = f32::atan2_pair([h, h_inside], [cos_gamma_o, cos_gamma_t]);
        let sin_t = polar.sin / eta;
        Entry {
            polar,
            frame: Frame::new(wo, polar.cos, inverse_cos),
            gamma_o,
            gamma_t,
            cos_gamma_t,
            h_inside,
            elongation: 1.0 / ((1.0 - sin_t) * (1.0 + sin_t)).max(1e-12).sqrt(),
            fresnel: fresnel(eta, layers, polar.cos * cos_gamma_o),
        }
    }

    /// Transmittance of one pass through the cylinder, RGB.
    #[inline(always)]
    pub fn pass(&self, sigma: [f32; 3]) -> [f32; 3] {
        let length = 2.0 * self.cos_gamma_t * self.elongation;
        sigma.map(|s| (-s * length).exp())
    }

    /// The exit azimuths Φₚ of R, TT, TRT and TRRT, in radians.
    #[inline(always)]
    pub fn exits(&self) -> [f32; 4] {
        [0.0, 1.0, 2.0, 3.0].map(|p| 2.0 * p * self.gamma_t - 2.0 * self.gamma_o + p * PI)
    }
}
