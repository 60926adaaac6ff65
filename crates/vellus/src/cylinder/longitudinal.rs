//! Longitudinal lobes M̂ₚ of R, TT, TRT and the rest: the energy-conserving spherical Gaussian.
//!
//! D8: instead of the paper's Gaussian in θ over cos²θ (see `as_printed` in `vellus-reference`), the lobe of
//! d'Eon et al. 2011, An Energy-Conserving Hair Reflectance Model, Eq. 7, with v = β²:
//!
//! M̂(θᵢ) = exp(sin θ_c sin θᵢ/v) I₀(cos θ_c cos θᵢ/v) / (2 v sinh(1/v)),  ∫ M̂ cos θᵢ dθᵢ = 1.
//!
//! Sampling follows d'Eon, Marschner and Hanika 2013, Importance Sampling for Physically-Based Hair Fiber Models: it
//! draws a direction of the spherical Gaussian and keeps its inclination.

use crate::fiber::Fiber;
use crate::simd::lanes::{Lanes, Quad};
use wide::{f32x4, f32x8};

/// Shift and width of the four lobes R, TT, TRT and rest, prepared once per fibre.
#[derive(Clone, Debug)]
pub(crate) struct Longitudinal {
    pub sin_alpha: [f32; 4],
    pub cos_alpha: [f32; 4],
    pub v: [f32; 4],
    pub inv_v: [f32; 4],
    /// 1/(v (1 − e^(−2/v)))
    pub norm: [f32; 4],
    /// e^(−2/v)
    pub floor: [f32; 4],
}

/// sin θ_c and |cos θ_c| of the four lobes. A centre beyond the pole folds back, because I₀ is even.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Centres<V: Lanes> {
    sin: V::Quad,
    cos: V::Quad,
}

impl<V: Lanes> Centres<V> {
    /// Sine and cosine of one lobe in one lane.
    #[inline(always)]
    pub fn lane(&self, p: usize, lane: usize) -> (f32, f32) {
        (self.sin.array()[p].lane(lane), self.cos.array()[p].lane(lane))
    }
}

impl Centres<f32> {
    /// The same centres in all eight lanes.
    pub fn repeated(&self) -> Centres<f32x8> {
        let quad = |x: f32x4| Quad::new(x.to_array().map(f32x8::splat));
        Centres { sin: quad(self.sin), cos: quad(self.cos) }
    }
}

impl Longitudinal {
    /// α_p and β_p of Table 2. The rest has the shift of TRT and the width 2β_m.
    #[doc(alias = "Table 2")]
    pub fn new(fiber: &Fiber) -> Self {
        let shift = [1.0, -0.5, -1.5, -1.5].map(|k| k * f64::from(fiber.alpha));
        let v = [1.0, 0.5, 1.5, 2.0].map(|k| (k * f64::from(fiber.beta_m)).powi(2));
        Longitudinal {
            sin_alpha: shift.map(|a| a.sin() as f32),
            cos_alpha: shift.map(|a| a.cos() as f32),
            v: v.map(|v| v as f32),
            inv_v: v.map(|v| (1.0 / v) as f32),
            norm: v.map(|v| (-1.0 / (v * (-2.0 / v).exp_m1())) as f32),
            floor: v.map(|v| (-2.0 / v).exp() as f32),
        }
    }

    /// θ_c = −θ_o − α_p. D11: the sign is minus because x runs from root to tip and scales open toward the tip.
    #[inline(always)]
    pub fn centres<V: Lanes>(&self, sin_o: V, cos_o: V) -> Centres<V> {
        let (s, c) = (V::Quad::constant(self.sin_alpha), V::Quad::constant(self.cos_alpha));
        let (sin_o, cos_o) = (V::Quad::splat(sin_o), V::Quad::splat(cos_o));
        Centres { sin: -(sin_o * c + cos_o * s), cos: (cos_o * c - sin_o * s).abs() }
    }

    /// M̂ₚ(θᵢ) of the four lobes, densities in sin θᵢ.
    #[doc(alias = "Eq. 5")]
    #[inline(always)]
    pub fn eval<V: Lanes>(&self, centres: &Centres<V>, sin_i: V, cos_i: V) -> V::Quad {
        // In log form: (sin sin + cos cos − 1)/v = −|Δ|²/2v, where Δ is the chord between the two unit vectors. It
        // stays precise for v = 3e-6.
        let inv_v = V::Quad::constant(self.inv_v);
        let (sin_i, cos_i) = (V::Quad::splat(sin_i), V::Quad::splat(cos_i));
        let (ds, dc) = (sin_i - centres.sin, cos_i - centres.cos);
        let exponent = (ds * ds + dc * dc) * inv_v * V::Quad::splat(V::splat(-0.5));
        let x = cos_i * centres.cos * inv_v;
        exponent.exp() * x.bessel_i0e() * V::Quad::constant(self.norm)
    }

    /// Draws (sin θᵢ, cos θᵢ) of lobe `p` from two uniform numbers, given the sine and cosine of its centre.
    #[inline]
    pub fn sample(&self, centre: (f32, f32), p: usize, u: [f32; 2]) -> (f32, f32) {
        let direction = self.sample_direction(centre, p, u);
        (direction[0], (direction[1] * direction[1] + direction[2] * direction[2]).sqrt())
    }

    /// Draws a direction (along the fibre, and two across) of the spherical Gaussian itself.
    #[inline]
    fn sample_direction(&self, (s, c): (f32, f32), p: usize, u: [f32; 2]) -> [f32; 3] {
        // 1 − cos of the angle from the lobe's centre. It is sampled directly, because for small v the cosine would
        // lose its digits.
        let drop = (-self.v[p] * (u[0] + (1.0 - u[0]) * self.floor[p]).max(f32::MIN_POSITIVE).ln()).clamp(0.0, 2.0);
        let (cos, sin) = (1.0 - drop, (drop * (2.0 - drop)).sqrt());
        let (sin_psi, cos_psi) = (std::f32::consts::TAU * u[1]).sin_cos();
        [cos * s + sin * cos_psi * c, cos * c - sin * cos_psi * s, sin * sin_psi]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lobes() -> Longitudinal {
        Longitudinal::new(&Fiber { alpha: 0.1, beta_m: 0.2, ..Fiber::hair() })
    }

    /// The sampler maps a small cell of the unit square to an area on the sphere. This area times the density of the
    /// spherical Gaussian, exp((cos − 1)/v)·norm/2π, equals the area of the cell. Tested by finite differences of the
    /// sampler.
    #[test]
    fn pdf_is_jacobian_of_sample() {
        let lobes = lobes();
        let centre = (0.6f32, 0.8f32);
        for p in 0..4 {
            for u in [[0.11f32, 0.2], [0.5, 0.77], [0.9, 0.4], [0.97, 0.05]] {
                let step = 2e-3;
                let at = |a: f32, b: f32| lobes.sample_direction(centre, p, [u[0] + a, u[1] + b]).map(f64::from);
                let difference = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|k| (a[k] - b[k]) / (2.0 * f64::from(step)));
                let (x, y) = (difference(at(step, 0.0), at(-step, 0.0)), difference(at(0.0, step), at(0.0, -step)));
                let cross = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
                let area = cross.iter().map(|c| c * c).sum::<f64>().sqrt();
                let w = at(0.0, 0.0);
                let cos = f64::from(centre.0) * w[0] + f64::from(centre.1) * w[1];
                let pdf =
                    ((cos - 1.0) * f64::from(lobes.inv_v[p])).exp() * f64::from(lobes.norm[p]) / std::f64::consts::TAU;
                // Central differences of the logarithm: (step/u)²/3 for u₀ ≥ 0.03 from the ends, and (2π step)²/6.
                assert!((area * pdf - 1.0).abs() < 2e-3, "lobe {p} {u:?}: {}", area * pdf);
            }
        }
    }

    /// `eval` returns this density integrated around the fibre.
    #[test]
    fn lobe_is_the_spherical_gaussian_around_the_fibre() {
        let lobes = lobes();
        let centres = lobes.centres(0.28f32, 0.96f32);
        for theta in [-1.3f32, -0.5, -0.3, 0.2, 1.5] {
            let (sin, cos) = theta.sin_cos();
            let values = lobes.eval(&centres, sin, cos).array();
            for p in 0..4 {
                let n = 2000;
                let (s, c, v) = (centres.sin.array()[p], centres.cos.array()[p], f64::from(lobes.v[p]));
                let ring: f64 = (0..n)
                    .map(|k| {
                        let psi = (f64::from(k) + 0.5) / f64::from(n) * std::f64::consts::TAU;
                        let dot = f64::from(s) * f64::from(sin) + f64::from(c) * f64::from(cos) * psi.cos();
                        ((dot - 1.0) / v).exp() / (v * -(-2.0 / v).exp_m1()) / f64::from(n)
                    })
                    .sum();
                assert!((f64::from(values[p]) - ring).abs() < 1e-4 * ring + 1e-7, "{theta} {p}: {} {ring}", values[p]);
            }
        }
    }
}
