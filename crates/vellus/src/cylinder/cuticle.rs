//! Reflectance of the cuticle with its layers (Yan17 Eq. 13, F; Yan et al. 2015 for the layers).

use crate::simd::lanes::Lanes;

/// The fractions that the cuticle reflects and transmits. They sum to 1.
///
/// Neither is computed as 1 minus the other: at grazing incidence the transmitted lobes need an accurate 1 − F.
#[derive(Clone, Copy, Debug)]
pub struct Fresnel<V> {
    /// F, the reflected fraction.
    pub reflected: V,
    /// 1 − F, the transmitted fraction.
    pub transmitted: V,
}

/// F(η, cos, l): unpolarised reflectance of `layers` cuticle slabs over a dielectric of
/// relative index `eta` ≥ 1, at an angle of incidence with cosine `cos` in [0, 1].
///
/// For each polarisation a slab reflects 2r/(1 + r), where r is the reflectance of a single interface. φ₁ is the mean
/// of both polarisations, and F = l φ₁ / (1 + (l − 1) φ₁). So l = 0.5 is nearly an ordinary interface, and l = 1 is
/// one slab.
///
/// D3: `cos` is the true 3-D incidence, cos θ_o · cos γ_o, with η, not the paper's (η′, γ).
#[doc(alias = "Eq. 13")]
#[inline]
pub fn fresnel<V: Lanes>(eta: f32, layers: f32, cos: V) -> Fresnel<V> {
    let [back, through] = parts(eta, layers, cos, refracted_cos2(eta, cos * cos).sqrt());
    let scale = V::splat(1.0) / (back + through);
    Fresnel { reflected: back * scale, transmitted: through * scale }
}

/// cos² of the refracted direction from cos² of incidence.
#[inline(always)]
pub(crate) fn refracted_cos2<V: Lanes>(eta: f32, cos2: V) -> V {
    (V::splat(1.0) - (V::splat(1.0) - cos2) * V::splat(1.0 / (eta * eta))).max(V::splat(0.0))
}

/// Two numbers with the ratio F : (1 − F), computed without divisions.
///
/// With r = (a − b)²/(a + b)² a slab reflects 2r/(1+r) = (a − b)²/(a² + b²) and transmits 2ab/(a² + b²). a and b are
/// cos and η cos_t for one polarisation, η cos and cos_t for the other. In F = l φ₁/((1 − φ₁) + l φ₁) the
/// denominators cancel, and no difference loses digits.
#[inline(always)]
pub(crate) fn parts<V: Lanes>(eta: f32, layers: f32, cos: V, cos_t: V) -> [V; 2] {
    let eta = V::splat(eta);
    let (a, b) = (cos, eta * cos_t);
    let (c, d) = (eta * cos, cos_t);
    let (s, p) = (a * a + b * b, c * c + d * d);
    let reflected = (a - b) * (a - b) * p + (c - d) * (c - d) * s;
    let through = a * b * p + c * d * s;
    // The lower bound gives full transmission for l = 0 at grazing incidence, where both numbers would be 0.
    [V::splat(0.5 * layers) * reflected, through.max(V::splat(1e-30))]
}
