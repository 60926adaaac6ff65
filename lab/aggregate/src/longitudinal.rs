//! The distribution along the fibre of eight lobes: spherical Gaussians (d'Eon et al. 2011, Eq. 7), as in `vellus`
//! (D8).
//!
//! The code is not shared with `vellus`, because these lobes also change their widths with the number of collisions.

use std::f32::consts::TAU;
use vellus::parts::{bessel_i0e, exp};
use wide::f32x8;

/// Eight lobes with their centres and widths. Each is a density in sin θᵢ with the integral 1.
///
/// The variance depends on the azimuth: v + t cos²(φ/2). A fibre that is tilted turns light that it sends back by twice
/// its own angle, and light that it sends on not at all.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Longitudinal {
    sin: f32x8,
    cos: f32x8,
    v: f32x8,
    tilt: f32x8,
}

impl Longitudinal {
    /// Lobes around −θ_o − `shift`, with the variances `v` > 0 and `tilt` ≥ 0. A centre beyond the pole folds back.
    #[inline]
    pub fn new(sin_o: f32, cos_o: f32, shift: [f32; 8], v: [f32; 8], tilt: [f32; 8]) -> Self {
        let (s, c) = (f32x8::new(shift.map(f32::sin)), f32x8::new(shift.map(f32::cos)));
        let (sin_o, cos_o) = (f32x8::splat(sin_o), f32x8::splat(cos_o));
        Longitudinal {
            sin: -(sin_o * c + cos_o * s),
            cos: (cos_o * c - sin_o * s).abs(),
            v: f32x8::new(v),
            tilt: f32x8::new(tilt),
        }
    }

    /// The densities of all lobes. `back` is cos²(φ/2).
    #[inline(always)]
    pub fn eval(&self, sin_i: f32, cos_i: f32, back: f32) -> [f32; 8] {
        // (sin sin + cos cos − 1)/v from the chord between two unit vectors, which avoids cancellation for small v.
        let (sin_i, cos_i) = (f32x8::splat(sin_i), f32x8::splat(cos_i));
        let (ds, dc) = (sin_i - self.sin, cos_i - self.cos);
        let inverse_v = f32x8::ONE / (self.v + self.tilt * f32x8::splat(back));
        let exponent = (ds * ds + dc * dc) * inverse_v * f32x8::splat(-0.5);
        let norm = inverse_v / (f32x8::ONE - exp(inverse_v * f32x8::splat(-2.0)));
        (exp(exponent) * bessel_i0e(cos_i * self.cos * inverse_v) * norm).to_array()
    }

    /// Draws sin θᵢ and cos θᵢ of one lobe (d'Eon, Marschner and Hanika 2013).
    #[inline]
    pub fn sample(&self, lobe: usize, back: f32, u: [f32; 2]) -> (f32, f32) {
        let of = |values: f32x8| values.to_array()[lobe];
        let (s, c, v) = (of(self.sin), of(self.cos), of(self.v) + of(self.tilt) * back);
        let floor = (-2.0 / v).exp();
        let drop = (-v * (u[0] + (1.0 - u[0]) * floor).max(f32::MIN_POSITIVE).ln()).clamp(0.0, 2.0);
        let (cos, sin) = (1.0 - drop, (drop * (2.0 - drop)).sqrt());
        let (sin_psi, cos_psi) = (TAU * u[1]).sin_cos();
        let across = cos * c - sin * cos_psi * s;
        let sin_i = cos * s + sin * cos_psi * c;
        (sin_i.clamp(-1.0, 1.0), across.hypot(sin * sin_psi))
    }
}

/// cos²(φ/2): 1 for light that goes back, 0 for light that goes on.
#[inline(always)]
pub(crate) fn back(phi: f32) -> f32 {
    0.5 + 0.5 * phi.cos()
}

/// The density in sin θᵢ of one lobe around the inclination `centre`.
pub(crate) fn density(theta: f64, centre: f64, v: f64) -> f64 {
    let (cos, centre_cos) = (theta.cos(), centre.cos().abs());
    let (ds, dc) = (theta.sin() - centre.sin(), cos - centre_cos);
    let bessel = bessel_i0e(f32x8::splat((cos * centre_cos / v) as f32)).to_array()[0];
    (-0.5 * (ds * ds + dc * dc) / v).exp() * f64::from(bessel) / -(v * (-2.0 / v).exp_m1())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At any inclination and width, also of lobes with their centre beyond the pole.
    #[test]
    fn lobes_integrate_to_one() {
        let v = [1e-3, 0.01, 0.04, 0.2, 1.0, 4.0, 20.0, 0.1];
        for theta_o in [-1.5f32, 0.2, 1.0] {
            let lobes =
                Longitudinal::new(theta_o.sin(), theta_o.cos(), [0.1; 8], v.map(|v| 0.8 * v), v.map(|v| 0.4 * v));
            let n = 20_000;
            let mut sums = [0.0f64; 8];
            for k in 0..n {
                let theta = ((f64::from(k) + 0.5) / f64::from(n) - 0.5) * std::f64::consts::PI;
                let values = lobes.eval(theta.sin() as f32, theta.cos() as f32, 0.5);
                let width = theta.cos() * std::f64::consts::PI / f64::from(n);
                (0..8).for_each(|i| sums[i] += f64::from(values[i]) * width);
            }
            // Special functions in single precision.
            assert!(sums.iter().all(|sum| (sum - 1.0).abs() < 1e-5), "{theta_o}: {sums:?}");
        }
    }
}
