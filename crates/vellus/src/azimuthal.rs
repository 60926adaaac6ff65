//! Azimuthal lobes of R, TT, TRT: a Gaussian around the exit azimuth, wrapped on the circle
//! (Yan17 Eq. 7, 16).

use crate::fiber::Fiber;
use crate::lanes::Lanes;
use crate::special;
use std::f32::consts::{PI, TAU};

/// Widths of the three lobes, prepared once a fibre.
#[derive(Clone, Debug)]
pub(crate) struct Azimuthal {
    sigma: [f32; 3],
    /// −1/(2σ²)
    exponent: [f32; 3],
    /// 1/(σ√2π)
    norm: [f32; 3],
    /// Pairs of further images of the Gaussian that are summed: 0, 1 or 2.
    images: u8,
}

impl Azimuthal {
    /// Variance (p + 1) β_n².
    #[doc(alias = "Eq. 16")]
    pub fn new(fiber: &Fiber) -> Self {
        let sigma = [1.0f32, 2.0, 3.0].map(|k| fiber.beta_n * k.sqrt());
        // What lies beyond the last image summed: nothing over e^(−17) of the peak for 0 images,
        // (|d| ≥ π, σ ≤ 0.53), and e^(−23) for 1 (|d| ≥ 3π, σ ≤ 1.39). With 2 images and the
        // widest lobe allowed (σ = 2.72, |d| ≥ 5π) it is e^(−16).
        let widest = sigma[2];
        let images = if widest < 0.53 { 0 } else if widest < 1.39 { 1 } else { 2 };
        Azimuthal {
            sigma,
            exponent: sigma.map(|s| -0.5 / (s * s)),
            norm: sigma.map(|s| 1.0 / (s * TAU.sqrt())),
            images,
        }
    }

    /// D_p(φ) for φ within ±π of each centre modulo 2π; densities per radian.
    #[doc(alias = "Eq. 7")]
    pub fn eval<V: Lanes>(&self, centres: &[V; 3], phi: V) -> [V; 3] {
        let d: [V; 3] = V::each(std::array::from_fn(|p| phi - centres[p]), wrap);
        let gauss = |offset: f32| -> [V; 3] {
            V::each(
                std::array::from_fn(|p| {
                    let x = d[p] + V::splat(offset);
                    x * x * V::splat(self.exponent[p])
                }),
                special::exp,
            )
        };
        let mut sum = gauss(0.0);
        for image in 1..=self.images {
            for turn in [TAU, -TAU] {
                let more = gauss(turn * f32::from(image));
                sum = std::array::from_fn(|p| sum[p] + more[p]);
            }
        }
        std::array::from_fn(|p| sum[p] * V::splat(self.norm[p]))
    }

    /// Draws φ of lobe `p`; any turn of the circle.
    pub fn sample(&self, centre: f32, p: usize, u: f32) -> f32 {
        centre + self.sigma[p] * special::normal_quantile(u)
    }
}

/// The same angle in [−π, π].
pub(crate) fn wrap(x: wide::f32x8) -> wide::f32x8 {
    // 1.5·2²³ rounds to the nearest whole turn; angles here are a few turns at most.
    let round = wide::f32x8::splat(12_582_912.0);
    let turns = x * wide::f32x8::splat(1.0 / TAU) + round - round;
    // 2π in two parts, the first exact in a product with a small integer.
    let hi = wide::f32x8::splat(6.281_25);
    let lo = wide::f32x8::splat(1.935_307_2e-3);
    (x - turns * hi - turns * lo).fast_max(wide::f32x8::splat(-PI)).fast_min(wide::f32x8::splat(PI))
}
