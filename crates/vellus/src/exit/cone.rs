//! How much of the light in each state the cuticle lets through, as a function of κ and η.
//!
//! Light at the incidence cosine μ = cos θ′ cos γ, sin γ = κ h″, is totally reflected if μ² < 1 − 1/η². The rest is
//! partly reflected.

use crate::cylinder::cuticle::fresnel;
use crate::exit::states::{REGISTERS, STATES, Vector, cell, pack};
use crate::medulla::mixture::Between;
use wide::f32x8;

/// Nodes of κ² in [0, 1] and of 1/η² in [1/9, 1]. Light at the offset h″ and the inclination θ′ reaches the critical
/// angle where sin² θ′ + κ² h″² cos² θ′ = 1/η², which is linear in both.
const KAPPAS: usize = 17;
const INDICES: usize = 37;
const LEAST_SQUARE: f64 = 1.0 / 9.0;

/// The mean transmittance of l slabs is taken from the mean reflectance φ of one slab, as if all light of a state had
/// this reflectance. This share of it is taken as light that is reflected wholly or not at all. Without it the
/// transmittance of 3 slabs is too small by 0.0024 on average over all states, with it by 0.0008.
const UNEVEN: f32 = 0.03;

/// For each state, the share of light that one slab (l = 1) transmits, and the share that it reflects partly.
#[derive(Clone, Debug)]
pub(crate) struct Cone(Vec<[Vector; 2]>);

/// Gauss–Legendre points on [−1, 1] and their weights, which sum to 2.
const GAUSS: [(f64, f64); 4] = [
    (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    (-0.339_981_043_584_856_3, 0.652_145_154_862_546_2),
    (0.339_981_043_584_856_3, 0.652_145_154_862_546_2),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
];

/// The shares of a state that one slab transmits and that it reflects. The rest is totally reflected.
fn shares(kappa: f64, eta: f64, state: usize) -> [f64; 2] {
    let [[a, b], [low, high]] = cell(state);
    let squared = |x: f64| 0.5 * x + 0.25 * (2.0 * x).sin();
    let critical = (1.0 - 1.0 / (eta * eta)).max(0.0).sqrt();
    // The offset at which light of the inclination θ′ reaches the critical angle. The integrand has a kink there.
    let kink = |theta: f64| ((1.0 - (critical / theta.cos()).powi(2)).max(0.0).sqrt() / kappa).clamp(low, high);
    let ends = if kappa > 0.0 { [low, kink(b), kink(a), high] } else { [low, low, low, high] };
    let [mut transmitted, mut reflected] = [0.0; 2];
    for range in ends.windows(2) {
        let width = range[1] - range[0];
        for (x, w) in GAUSS {
            let h = 0.5 * (range[0] + range[1]) + 0.5 * width * x;
            let cos_gamma = (1.0 - (kappa * h).powi(2)).sqrt();
            let last = (critical / cos_gamma).min(1.0).acos().min(b);
            if last <= a {
                continue;
            }
            for (y, v) in GAUSS {
                // The reflectance rises with a square root at the critical angle.
                let s = 0.5 + 0.5 * y;
                let theta = last - (last - a) * s * s;
                let cos = theta.cos() * cos_gamma;
                let outside = (1.0 - eta * eta * (1.0 - cos * cos)).max(0.0).sqrt();
                let f = fresnel(eta as f32, 1.0, outside as f32);
                let light = 0.5 * w * width / (high - low) * v * s * (last - a) * theta.cos().powi(2);
                transmitted += light * f64::from(f.transmitted);
                reflected += light * f64::from(f.reflected);
            }
        }
    }
    [transmitted, reflected].map(|x| x / (squared(b) - squared(a)))
}

impl Cone {
    pub fn new() -> Self {
        let position = |i: usize, n: usize| i as f64 / (n - 1) as f64;
        let rows = (0..KAPPAS * INDICES).map(|row| {
            let kappa = position(row / INDICES, KAPPAS).sqrt();
            let eta = 1.0 / (LEAST_SQUARE + (1.0 - LEAST_SQUARE) * position(row % INDICES, INDICES)).sqrt();
            let all: [[f64; 2]; STATES] = std::array::from_fn(|state| shares(kappa, eta, state));
            [0, 1].map(|k| pack(|state| all[state][k] as f32))
        });
        Cone(rows.collect())
    }

    /// The transmittance of the cuticle with `layers` slabs for light in each state.
    #[inline(always)]
    pub fn transmittance(&self, kappa: f32, eta: f32, layers: f32) -> Vector {
        let k = Between::new(kappa * kappa * (KAPPAS - 1) as f32, KAPPAS);
        let least = LEAST_SQUARE as f32;
        let index = (1.0 / (eta * eta) - least) / (1.0 - least);
        let n = Between::new(index * (INDICES - 1) as f32, INDICES);
        let at = |i: usize, j: usize| &self.0[(k.index + i) * INDICES + n.index + j];
        let rows = [at(0, 0), at(0, 1), at(1, 0), at(1, 1)];
        let weights = [(1.0 - k.t) * (1.0 - n.t), (1.0 - k.t) * n.t, k.t * (1.0 - n.t), k.t * n.t].map(f32x8::splat);
        let mut out = [f32x8::ZERO; REGISTERS];
        for r in 0..REGISTERS {
            let [mut through, mut back] = [f32x8::ZERO; 2];
            for (row, weight) in rows.iter().zip(weights) {
                through = row[0][r].mul_add(weight, through);
                back = row[1][r].mul_add(weight, back);
            }
            // 1 − l φ/(1 + (l − 1) φ) = (1 − φ)/(1 − φ + l φ), where φ = back/(through + back).
            let layered = back.mul_add(f32x8::splat(layers), through).fast_max(f32x8::splat(1e-20));
            let even = (through + back) * f32x8::splat(1.0 - UNEVEN) / layered;
            out[r] = (through * (even + f32x8::splat(UNEVEN))).fast_min(f32x8::ONE);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The transmittance by the midpoint rule, with the layers at each point.
    fn quadrature(kappa: f64, eta: f64, layers: f32, state: usize) -> f64 {
        let [theta, offset] = cell(state);
        let (n, mut sum, mut weights) = (64, 0.0, 0.0);
        for i in 0..n * n {
            let at = |[a, b]: [f64; 2], k: usize| a + (b - a) * (k as f64 + 0.5) / n as f64;
            let (theta, h) = (at(theta, i / n), at(offset, i % n));
            let cos2 = theta.cos().powi(2) * (1.0 - (kappa * h).powi(2));
            let outside = 1.0 - eta * eta * (1.0 - cos2);
            weights += theta.cos().powi(2);
            if outside > 0.0 {
                let f = fresnel(eta as f32, layers, outside.sqrt() as f32);
                sum += theta.cos().powi(2) * f64::from(f.transmitted);
            }
        }
        sum / weights
    }

    /// The table between its nodes, against quadrature. The mean reflectance of l slabs is taken as that of the mean
    /// reflectance of one, too.
    #[test]
    fn interpolation_is_close_to_quadrature() {
        let cone = Cone::new();
        assert!(size_of_val(cone.0.as_slice()) <= 128 << 10);
        for layers in [0.5f32, 1.0, 3.0] {
            let (mut sum, mut worst, mut count) = (0.0f64, 0.0f64, 0);
            for i in 0..23 {
                for j in 0..29 {
                    let (kappa, eta) = (0.043 * f64::from(i) + 0.01, 1.0 + 0.069 * f64::from(j));
                    let ours = cone.transmittance(kappa as f32, eta as f32, layers);
                    for state in 0..STATES {
                        let exact = quadrature(kappa, eta, layers, state);
                        let error = (f64::from(ours[state / 8].to_array()[state % 8]) - exact).abs();
                        sum += error;
                        worst = worst.max(error);
                        count += 1;
                    }
                }
            }
            let mean = sum / f64::from(count);
            println!("{layers} layers: mean {mean:.5}, worst {worst:.4}");
            assert!(mean < 3e-3 && worst < 0.08, "{layers}: {mean} {worst}");
        }
    }
}
