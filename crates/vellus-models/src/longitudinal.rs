//! Longitudinal densities of eight lobes, with respect to sin θᵢ, in one SIMD register.

use std::f32::consts::{FRAC_PI_2, TAU};
use vellus::parts::{Outgoing, Polar, bessel_i0e, exp, mills, normal_quantile};
use wide::f32x8;

/// Longitudinal densities of eight lobes, with respect to sin θᵢ.
pub trait Longitudinal: Copy {
    /// The densities in an outgoing direction.
    fn eval(&self, o: &Outgoing<f32>) -> f32x8;
    /// Samples sin θᵢ and cos θᵢ of one lobe.
    fn sample(&self, lane: usize, u: [f32; 2]) -> (f32, f32);
}

/// Shifts and widths of energy-conserving spherical Gaussians (d'Eon et al. 2011, Eq. 7), prepared once per fibre.
///
/// M̂(θᵢ) = exp(sin θ_c sin θᵢ/v) I₀(cos θ_c cos θᵢ/v) / (2v sinh(1/v)). Its integral over sin θᵢ is 1.
///
/// `vellus` has the same lobe for its own four lobes. The code is not shared, because this one has other register
/// widths, and its results differ in the last bit.
#[derive(Clone, Debug)]
pub struct Spherical {
    sin_alpha: f32x8,
    cos_alpha: f32x8,
    inverse_v: f32x8,
    norm: f32x8,
    v: [f32; 8],
    /// e^(−2/v)
    floor: [f32; 8],
}

/// Spherical Gaussians with the centres of one hit.
#[derive(Clone, Copy, Debug)]
pub struct SphericalAt<'m> {
    widths: &'m Spherical,
    sin: f32x8,
    cos: f32x8,
}

impl Spherical {
    /// `shift` has the α_p of θ_c = −θ_o − α_p, and `beta` the standard deviations √v, in radians.
    pub fn new(shift: [f32; 8], beta: [f32; 8]) -> Self {
        let v = beta.map(|b| f64::from(b).powi(2));
        let lanes = |f: &dyn Fn(usize) -> f64| f32x8::new(std::array::from_fn(|i| f(i) as f32));
        Spherical {
            sin_alpha: lanes(&|i| f64::from(shift[i]).sin()),
            cos_alpha: lanes(&|i| f64::from(shift[i]).cos()),
            inverse_v: lanes(&|i| 1.0 / v[i]),
            norm: lanes(&|i| -1.0 / (v[i] * (-2.0 / v[i]).exp_m1())),
            v: v.map(|v| v as f32),
            floor: v.map(|v| (-2.0 / v).exp() as f32),
        }
    }

    /// The lobes of a hit with outgoing inclination `o`.
    #[inline(always)]
    pub fn at(&self, o: Polar<f32>) -> SphericalAt<'_> {
        let (sin_o, cos_o) = (f32x8::splat(o.sin), f32x8::splat(o.cos));
        SphericalAt {
            widths: self,
            sin: -(sin_o * self.cos_alpha + cos_o * self.sin_alpha),
            // A centre beyond the pole has a negative cosine, but I₀ is even.
            cos: (cos_o * self.cos_alpha - sin_o * self.sin_alpha).abs(),
        }
    }
}

impl Longitudinal for SphericalAt<'_> {
    #[inline(always)]
    fn eval(&self, o: &Outgoing<f32>) -> f32x8 {
        // (sin sin + cos cos − 1)/v from the chord between two unit vectors, which avoids cancellation for small v.
        let (sin_i, cos_i) = (f32x8::splat(o.sin_i), f32x8::splat(o.cos_i));
        let (ds, dc) = (sin_i - self.sin, cos_i - self.cos);
        let exponent = (ds * ds + dc * dc) * self.widths.inverse_v * f32x8::splat(-0.5);
        exp(exponent) * bessel_i0e(cos_i * self.cos * self.widths.inverse_v) * self.widths.norm
    }

    /// Samples a direction of the spherical Gaussian and returns its inclination (d'Eon, Marschner and Hanika 2013).
    #[inline(always)]
    fn sample(&self, lane: usize, u: [f32; 2]) -> (f32, f32) {
        let (s, c) = (self.sin.to_array()[lane], self.cos.to_array()[lane]);
        let (v, floor) = (self.widths.v[lane], self.widths.floor[lane]);
        let drop = (-v * (u[0] + (1.0 - u[0]) * floor).max(f32::MIN_POSITIVE).ln()).clamp(0.0, 2.0);
        let (cos, sin) = (1.0 - drop, (drop * (2.0 - drop)).sqrt());
        let (sin_psi, cos_psi) = (TAU * u[1]).sin_cos();
        let across = cos * c - sin * cos_psi * s;
        let sin_i = cos * s + sin * cos_psi * c;
        (sin_i.clamp(-1.0, 1.0), across.hypot(sin * sin_psi))
    }
}

/// Gaussians in θᵢ, truncated to ±90° and normalised, as densities with respect to sin θᵢ: divided by cos θᵢ.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    centre: f32x8,
    inverse: f32x8,
    sigma: f32x8,
    norm: f32x8,
    /// The cumulative distribution at −90°.
    below: f32x8,
    /// The probability of ±90°.
    inside: f32x8,
}

impl Plane {
    /// Gaussians around `centre` with standard deviation `sigma`, in radians.
    #[inline(always)]
    pub fn new(centre: f32x8, sigma: f32x8) -> Self {
        let splat = f32x8::splat;
        let inverse = f32x8::ONE / sigma;
        // The cumulative normal distribution from its tail t = mills(|x|) e^(−x²/2): t for x < 0, 1 − t otherwise.
        let cumulative = |x: f32x8| {
            let tail = mills(x.abs()) * exp(x * x * splat(-0.5));
            x.simd_lt(f32x8::ZERO).select(tail, f32x8::ONE - tail)
        };
        let below = cumulative((splat(-FRAC_PI_2) - centre) * inverse);
        // 1 − F(90°), by symmetry.
        let above = cumulative((centre - splat(FRAC_PI_2)) * inverse);
        let inside = (f32x8::ONE - below - above).fast_max(splat(1e-6));
        let norm = splat(1.0 / TAU.sqrt()) * inverse / inside;
        Plane { centre, inverse, sigma, norm, below, inside }
    }

    /// The probability of ±90° of each Gaussian before truncation.
    #[inline(always)]
    pub fn inside(&self) -> f32x8 {
        self.inside
    }
}

impl Longitudinal for Plane {
    #[inline(always)]
    fn eval(&self, o: &Outgoing<f32>) -> f32x8 {
        let d = (f32x8::splat(o.theta_i) - self.centre) * self.inverse;
        // The density with respect to sin θ has a pole at ±90°. The bound keeps it finite.
        exp(d * d * f32x8::splat(-0.5)) * self.norm * f32x8::splat(1.0 / o.cos_i.max(1e-6))
    }

    #[inline(always)]
    fn sample(&self, lane: usize, u: [f32; 2]) -> (f32, f32) {
        let of = |values: f32x8| values.to_array()[lane];
        let theta = of(self.centre) + of(self.sigma) * normal_quantile(of(self.below) + u[0] * of(self.inside));
        let (sin, cos) = theta.clamp(-FRAC_PI_2, FRAC_PI_2).sin_cos();
        // In single precision, the cosine of 90° is −4e-8.
        (sin, cos.max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// d sin θᵢ/du · M(θᵢ) = 1 for truncated Gaussians, by central differences with error step/u. Spherical Gaussians
    /// use both random numbers; the tests of whole hits cover them.
    #[test]
    fn pdf_is_jacobian_of_sample() {
        let lanes = Plane::new(f32x8::splat(-1.1), f32x8::splat(0.3));
        for u in [0.03f32, 0.3, 0.6, 0.95] {
            let step = 2e-3;
            let at = |u: f32| lanes.sample(3, [u, 0.5]);
            let (sin_i, cos_i) = at(u);
            let slope = (at(u + step).0 - at(u - step).0) / (2.0 * step);
            let o = Outgoing { sin_i, cos_i, theta_i: sin_i.atan2(cos_i), phi: 0.0 };
            let product = slope * lanes.eval(&o).to_array()[3];
            assert!((product - 1.0).abs() < 2e-3 + (step / u.min(1.0 - u)).powi(2), "{u}: {product}");
        }
    }

    /// Both kinds integrate to 1 over sin θᵢ, at any inclination and width. Spherical ones also beyond the pole.
    #[test]
    fn lobes_integrate_to_one() {
        for theta_o in [-1.5f32, 0.2, 1.0] {
            for beta in [0.01f32, 0.2, 1.5] {
                let spherical = Spherical::new([0.1; 8], [beta; 8]);
                let (sin, cos) = theta_o.sin_cos();
                let (spherical, plane) =
                    (spherical.at(Polar { sin, cos }), Plane::new(f32x8::splat(-theta_o), f32x8::splat(beta)));
                let n = 20_000;
                let mut sum = [0.0f64; 2];
                for k in 0..n {
                    let theta_i = ((k as f32 + 0.5) / n as f32 - 0.5) * 2.0 * FRAC_PI_2;
                    let (sin_i, cos_i) = theta_i.sin_cos();
                    let o = Outgoing { sin_i, cos_i, theta_i, phi: 0.0 };
                    let values = [spherical.eval(&o).to_array()[0], plane.eval(&o).to_array()[0]];
                    (0..2).for_each(|i| sum[i] += f64::from(values[i] * cos_i) * std::f64::consts::PI / f64::from(n));
                }
                // θ has a rounding error of 1e-7, which is 1e-5 of the narrowest width. Special functions have 1e-6.
                sum.iter().for_each(|s| assert!((s - 1.0).abs() < 1e-4, "{theta_o} {beta}: {sum:?}"));
            }
        }
    }
}
