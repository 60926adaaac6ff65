//! Azimuthal lobes of R, TT, TRT: a Gaussian around the exit azimuth, wrapped on the circle
//! (Yan17 Eq. 7, 16). The fourth lane is the rest's uniform 1/2π.

use crate::fiber::Fiber;
use crate::simd::lanes::{Lanes, Quad};
use crate::simd::special;
use std::f32::consts::{PI, TAU};

/// Widths of the lobes, prepared once per fibre.
#[derive(Clone, Debug)]
pub(crate) struct Azimuthal {
    pub sigma: [f32; 3],
    pub inverse_sigma: [f32; 3],
    /// −1/(2σ²). It is 0 for the rest, so that all its images are 1.
    pub exponent: [f32; 4],
    /// 1/(σ√2π). For the rest it is 1/2π divided by the number of images in the sum.
    pub norm: [f32; 4],
    /// The number of pairs of additional images of the Gaussian in the sum: 0, 1 or 2.
    pub images: u8,
}

impl Azimuthal {
    /// Variance (p + 1) β_n².
    #[doc(alias = "Eq. 16")]
    pub fn new(fiber: &Fiber) -> Self {
        let sigma = [1.0f32, 2.0, 3.0].map(|k| fiber.beta_n * k.sqrt());
        // The omitted images are at most e^(−16.3) of the peak, one rounding, for 0 pairs (|d| ≥ π, σ ≤ 0.55), and
        // e^(−23) for 1 (|d| ≥ 3π, σ ≤ 1.39). With 2 pairs and the widest allowed lobe (σ = 2.72, |d| ≥ 5π) they are
        // e^(−16).
        let widest = sigma[2];
        let images = if widest < 0.55 {
            0
        } else if widest < 1.39 {
            1
        } else {
            2
        };
        let exponent = sigma.map(|s| -0.5 / (s * s));
        let norm = sigma.map(|s| 1.0 / (s * TAU.sqrt()));
        Azimuthal {
            sigma,
            inverse_sigma: sigma.map(|s| 1.0 / s),
            exponent: [exponent[0], exponent[1], exponent[2], 0.0],
            norm: [norm[0], norm[1], norm[2], 1.0 / (TAU * f32::from(2 * images + 1))],
            images,
        }
    }

    /// D_p(φ) of R, TT, TRT and the rest around their centres. These are densities per radian.
    #[doc(alias = "Eq. 7")]
    #[inline(always)]
    pub fn eval<V: Lanes>(&self, centres: V::Quad, phi: V) -> V::Quad {
        let d = wrap_quad::<V>(V::Quad::splat(phi) - centres);
        let exponent = V::Quad::constant(self.exponent);
        let mut sum = (d * d * exponent).exp();
        for image in 1..=self.images {
            for turn in [TAU, -TAU] {
                let d = d + V::Quad::splat(V::splat(turn * f32::from(image)));
                sum = sum + (d * d * exponent).exp();
            }
        }
        sum * V::Quad::constant(self.norm)
    }

    /// Draws φ of lobe `p`, on any turn of the circle.
    pub fn sample(&self, centre: f32, p: usize, u: f32) -> f32 {
        centre + self.sigma[p] * special::normal_quantile(u)
    }
}

/// 1.5·2²³: adding and subtracting it rounds to an integer. Angles here are at most a few turns.
const ROUND: f32 = 12_582_912.0;
/// 2π in two parts. The product of the first with a small integer is exact.
const TAU_HI: f32 = 6.281_25;
const TAU_LO: f32 = 1.935_307_2e-3;

/// Wraps an angle to [−π, π].
#[inline(always)]
pub fn wrap<V: Lanes>(x: V) -> V {
    let turns = x * V::splat(1.0 / TAU) + V::splat(ROUND) - V::splat(ROUND);
    (x - turns * V::splat(TAU_HI) - turns * V::splat(TAU_LO)).max(V::splat(-PI)).min(V::splat(PI))
}

#[inline(always)]
fn wrap_quad<V: Lanes>(x: V::Quad) -> V::Quad {
    let constant = |x: f32| V::Quad::splat(V::splat(x));
    let turns = x * constant(1.0 / TAU) + constant(ROUND) - constant(ROUND);
    x - turns * constant(TAU_HI) - turns * constant(TAU_LO)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// dφ/du · D(φ) = 1 for lobes too narrow for a second image, tested by finite differences.
    #[test]
    fn pdf_is_jacobian_of_sample() {
        let lobes = Azimuthal::new(&Fiber { beta_n: 0.2, ..Fiber::hair() });
        let centres = [0.3f32, 2.8, -1.9, 0.0];
        for p in 0..3 {
            for u in [0.02f32, 0.3, 0.5, 0.81, 0.995] {
                let step = 1e-3;
                let slope =
                    (lobes.sample(centres[p], p, u + step) - lobes.sample(centres[p], p, u - step)) / (2.0 * step);
                let density = lobes.eval::<f32>(Quad::new(centres), lobes.sample(centres[p], p, u)).array()[p];
                // Central differences have the error x‴/x′·step²/6, and x‴/x′ < 6/u² at the distance u from either
                // end.
                let tolerance = 1e-3 + (step / u.min(1.0 - u)).powi(2);
                assert!((slope * density - 1.0).abs() < tolerance, "lobe {p} u {u}: {}", slope * density);
            }
        }
    }

    /// A lobe of any width integrates to 1 on the circle.
    #[test]
    fn wrapped_lobes_integrate_to_one() {
        for degrees in [0.1f32, 5.0, 17.5, 18.5, 45.0, 47.0, 90.0] {
            let lobes = Azimuthal::new(&Fiber { beta_n: degrees.to_radians(), ..Fiber::hair() });
            let n = 20_000;
            let mut sum = [0.0f64; 4];
            for k in 0..n {
                let phi = (k as f32 + 0.5) / n as f32 * TAU - PI;
                let values = lobes.eval::<f32>(Quad::new([0.3, 2.8, -1.9, 0.0]), phi).array();
                (0..4).for_each(|p| sum[p] += f64::from(values[p] * TAU) / f64::from(n));
            }
            for p in 0..4 {
                // The omitted images, and the rounding of φ, 1.2e-7, relative to the width.
                let tolerance = 2e-6 + 1.2e-7 / degrees.to_radians();
                assert!((sum[p] - 1.0).abs() < f64::from(tolerance), "β_n {degrees}° lobe {p}: {}", sum[p]);
            }
        }
    }
}
