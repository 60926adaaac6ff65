//! Directions in the fibre's frame: x along the fibre from root to tip.

use crate::simd::lanes::Lanes;
use wide::f32x8;

/// Whether this is a unit vector in single precision. False for NaN.
///
/// A normalised vector has the squared length 1 within 4e-7. Renderers rotate vectors between frames, which adds a
/// few rounding errors. 1e-3 is far above these, and far below the error of a missing normalisation.
pub(crate) fn is_unit(w: glam::Vec3) -> bool {
    (w.length_squared() - 1.0).abs() < 1e-3
}

/// The unit vector at the inclination `theta` and the azimuth `phi`, both in radians, in the fibre's frame.
pub fn direction(theta: f64, phi: f64) -> glam::Vec3 {
    let ((sin_theta, cos_theta), (sin_phi, cos_phi)) = (theta.sin_cos(), phi.sin_cos());
    glam::Vec3::new(sin_theta as f32, (cos_theta * cos_phi) as f32, (cos_theta * sin_phi) as f32)
}

/// The inclination of a direction.
#[derive(Clone, Copy, Debug)]
pub struct Polar<V> {
    /// sin θ, clamped to [−1, 1].
    pub sin: V,
    /// cos θ ≥ 0.
    pub cos: V,
}

impl<V: Lanes> Polar<V> {
    /// The inclination of a unit vector.
    #[inline(always)]
    pub fn new([x, y, z]: [V; 3]) -> Self {
        Polar { sin: x.max(V::splat(-1.0)).min(V::splat(1.0)), cos: (y * y + z * z).sqrt() }
    }
}

/// The azimuth of ω_o, from which all others are measured, as cos φ_o and sin φ_o.
#[derive(Clone, Copy, Debug)]
pub struct Frame<V> {
    cos: V,
    sin: V,
}

/// ω_i in the form that the lobes use.
#[derive(Clone, Copy, Debug)]
pub struct Outgoing<V> {
    /// sin θᵢ
    pub sin_i: V,
    /// cos θᵢ
    pub cos_i: V,
    /// θᵢ, or θ′ inside the fibre if it was refracted.
    pub theta_i: V,
    /// φ_i − φ_o
    pub phi: V,
}

/// How an inclination changes where light enters a fibre.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Refraction {
    pub inverse_eta: f32,
    /// 1 − 1/η²
    pub excess: f32,
}

impl Refraction {
    /// No refraction.
    pub const NONE: Refraction = Refraction { inverse_eta: 1.0, excess: 0.0 };

    /// From 1/η.
    pub fn new(inverse_eta: f32) -> Self {
        Refraction { inverse_eta, excess: (1.0 - inverse_eta) * (1.0 + inverse_eta) }
    }

    /// sin θ′ and cos θ′ inside the fibre, from sin θ and cos²θ outside.
    ///
    /// Without refraction this is sin θ and √cos²θ, to the last bit and without a branch.
    #[inline(always)]
    pub fn inside<V: Lanes>(&self, sin: V, cos2: V) -> (V, V) {
        if self.excess == 0.0 {
            return (sin, cos2.sqrt());
        }
        (sin * V::splat(self.inverse_eta), (cos2 + sin * sin * V::splat(self.excess)).sqrt())
    }
}

impl Frame<f32> {
    /// The same frame in all eight lanes.
    pub(crate) fn repeated(&self) -> Frame<f32x8> {
        Frame { cos: f32x8::splat(self.cos), sin: f32x8::splat(self.sin) }
    }
}

impl<V: Lanes> Frame<V> {
    /// `cos` is cos θ_o, `inverse` its inverse. Along the axis the azimuth is arbitrary.
    #[inline(always)]
    pub fn new([_, y, z]: [V; 3], cos: V, inverse: V) -> Self {
        let tiny = V::splat(1e-12);
        Frame {
            cos: cos.select_lt(tiny, V::splat(1.0), y * inverse),
            sin: cos.select_lt(tiny, V::splat(0.0), z * inverse),
        }
    }

    /// The cosine and the sine of the azimuth of ω_o.
    #[inline(always)]
    pub(crate) fn toward(&self) -> [V; 2] {
        [self.cos, self.sin]
    }

    /// A direction relative to ω_o.
    #[cfg(feature = "unstable")]
    #[inline(always)]
    pub fn outgoing(&self, wi: [V; 3]) -> Outgoing<V> {
        self.refracted(wi, &Refraction::NONE).0
    }

    /// A direction relative to ω_o, with its inclination inside the fibre, then the cosine and the sine of its azimuth.
    #[inline(always)]
    pub(crate) fn refracted(&self, [x, y, z]: [V; 3], refraction: &Refraction) -> (Outgoing<V>, [V; 2]) {
        let (c, s) = (self.cos, self.sin);
        let cos2 = y * y + z * z;
        let (sin, cos) = refraction.inside(x, cos2);
        let (along, across) = (y * c + z * s, z * c - y * s);
        let [phi, theta_i] = V::atan2_pair([across, sin], [along, cos]);
        let cos_i = cos2.sqrt();
        let inverse = V::splat(1.0) / cos_i.max(V::splat(1e-12));
        (Outgoing { sin_i: x, cos_i, theta_i, phi }, [along * inverse, across * inverse])
    }

    /// The direction at an inclination and an azimuth relative to ω_o.
    #[inline(always)]
    pub fn direction(&self, sin_i: V, cos_i: V, (sin_phi, cos_phi): (V, V)) -> [V; 3] {
        let (c, s) = (self.cos, self.sin);
        [sin_i, cos_i * (cos_phi * c - sin_phi * s), cos_i * (sin_phi * c + cos_phi * s)]
    }
}
