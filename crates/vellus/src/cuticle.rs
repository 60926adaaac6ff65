//! Reflectance of the cuticle with its layers (Yan17 Eq. 13, F; Yan et al. 2015 for the layers).

use crate::lanes::Lanes;

/// What the cuticle reflects and lets through; the two sum to 1.
///
/// Both are computed, neither by subtraction: at grazing incidence 1 − F is what the
/// transmitted lobes live on.
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
/// Per polarisation a slab reflects 2r/(1 + r), r being the single interface; φ₁ is the mean of
/// both, and F = l φ₁ / (1 + (l − 1) φ₁). So l = 0.5 is nearly an ordinary interface and l = 1
/// one slab.
///
/// D3: `cos` is the true 3-D incidence, cos θ_o · cos γ_o, with η; not the paper's (η′, γ).
#[doc(alias = "Eq. 13")]
pub fn fresnel<V: Lanes>(eta: f32, layers: f32, cos: V) -> Fresnel<V> {
    let one = V::splat(1.0);
    let sin2 = (one - cos) * (one + cos);
    let cos_t = (one - sin2 * V::splat(1.0 / (eta * eta))).max(V::splat(0.0)).sqrt();
    let eta = V::splat(eta);
    // The sums vanish only for eta = 1 and cos = 0, where nothing reflects.
    let floor = V::splat(1e-20);
    let s = (cos - eta * cos_t) / (cos + eta * cos_t).max(floor);
    let p = (eta * cos - cos_t) / (eta * cos + cos_t).max(floor);
    let (r_s, r_p) = (s * s, p * p);
    // 1 − 2r/(1+r) = (1−r)/(1+r), and 1 − r = 4 a b/(a+b)².
    let complement = |a: V, b: V| {
        let sum = (a + b).max(floor);
        V::splat(4.0) * a * b / (sum * sum)
    };
    let slab = |r: V| V::splat(2.0) * r / (one + r);
    let phi = V::splat(0.5) * (slab(r_s) + slab(r_p));
    // The floor decides for transmission where nothing reflects: l = 0 at grazing incidence.
    let through = (V::splat(0.5)
        * (complement(cos, eta * cos_t) / (one + r_s) + complement(eta * cos, cos_t) / (one + r_p)))
    .max(V::splat(1e-30));
    // 1 + (l − 1) φ₁ = (1 − φ₁) + l φ₁, a sum without cancellation.
    let back = V::splat(layers) * phi;
    let scale = one / (through + back);
    Fresnel { reflected: back * scale, transmitted: through * scale }
}
