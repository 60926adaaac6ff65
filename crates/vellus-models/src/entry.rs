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

/// The unpolarised reflectance of a smooth interface with the relative index `eta` ≥ 1, at an angle of incidence with
/// the cosine `cos` in [0, 1].
///
/// [`fresnel`] with half a layer is up to 8 % less at medium angles, because it takes the mean of the polarisations of
/// a whole layer.
#[inline(always)]
pub(crate) fn interface(eta: f32, cos: f32) -> Fresnel<f32> {
    // The lower bound gives full transmission for η = 1 at grazing incidence, where both cosines would be 0.
    let cos = cos.max(1e-12);
    let cos_t = (1.0 - (1.0 - cos * cos) / (eta * eta)).max(0.0).sqrt().max(1e-12);
    let polarised = |a: f32, b: f32| {
        let scale = 1.0 / (a + b);
        [((a - b) * scale).powi(2), 4.0 * (a * scale) * (b * scale)]
    };
    let [s, p] = [polarised(cos, eta * cos_t), polarised(eta * cos, cos_t)];
    // The transmitted part is not 1 − F, which cancels at grazing incidence.
    Fresnel { reflected: 0.5 * (s[0] + p[0]), transmitted: 0.5 * (s[1] + p[1]) }
}

impl Entry {
    /// A ray from `wo` at the centre of `window`. `eta` is the refractive index and `layers` the number of cuticle
    /// layers. `None` is a single smooth interface.
    #[inline(always)]
    pub fn new(wo: glam::Vec3, window: Window, eta: f32, layers: Option<f32>) -> Self {
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
            fresnel: match layers {
                Some(layers) => fresnel(eta, layers, polar.cos * cos_gamma_o),
                None => interface(eta, polar.cos * cos_gamma_o),
            },
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Known values: ((η − 1)/(η + 1))² at normal incidence, 1 at grazing incidence, and at Brewster's angle half of
    /// ((η² − 1)/(η² + 1))², because one polarisation does not reflect.
    #[test]
    fn a_smooth_interface_reflects_as_fresnel_says() {
        for eta in [1.0f32, 1.1, 1.55, 2.0] {
            let brewster = 1.0 / (1.0 + eta * eta).sqrt();
            let normal = ((eta - 1.0) / (eta + 1.0)).powi(2);
            let at_brewster = 0.5 * ((eta * eta - 1.0) / (eta * eta + 1.0)).powi(2);
            for (cos, expected) in [(1.0, normal), (brewster, at_brewster)] {
                let f = interface(eta, cos);
                assert!((f.reflected - expected).abs() < 1e-6, "{eta} {cos}: {f:?}");
                assert!((f.reflected + f.transmitted - 1.0).abs() < 1e-6);
            }
        }
        assert!(interface(1.55, 0.0).reflected == 1.0 && interface(1.55, 0.0).transmitted < 1e-10);
        assert!(interface(1.0, 0.0).reflected == 0.0 && interface(1.0, 0.0).transmitted == 1.0);
    }
}
