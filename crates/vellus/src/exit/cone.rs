//! How much of the light in each state the cuticle lets through, as a function of κ and η.
//!
//! Light at the incidence cosine μ = cos θ′ cos γ, sin γ = κ h″, is totally reflected if μ² < 1 − 1/η². The rest is
//! partly reflected.

use crate::cylinder::cuticle::fresnel;
use crate::exit::states::{REGISTERS, STATES, Vector, cell, pack};
use crate::medulla::mixture::Between;
use wide::f32x8;

/// Nodes of κ in [0, 1] and of 1/η in [1/3, 1].
const KAPPAS: usize = 13;
const INDICES: usize = 49;
const LEAST_INDEX: f64 = 1.0 / 3.0;

/// For each state, the share of light that is not totally reflected, and its mean reflectance by one slab (l = 1).
#[derive(Clone, Debug)]
pub(crate) struct Cone(Vec<[Vector; 2]>);

/// Gauss–Legendre points on [−1, 1] and their weights, which sum to 2.
const GAUSS: [(f64, f64); 4] = [
    (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    (-0.339_981_043_584_856_3, 0.652_145_154_862_546_2),
    (0.339_981_043_584_856_3, 0.652_145_154_862_546_2),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
];

/// The share of a state that is not totally reflected, and its mean reflectance by one slab.
fn shares(kappa: f64, eta: f64, state: usize) -> [f64; 2] {
    let [[a, b], [low, high]] = cell(state);
    let squared = |x: f64| 0.5 * x + 0.25 * (2.0 * x).sin();
    let critical = (1.0 - 1.0 / (eta * eta)).max(0.0).sqrt();
    let (mut inside, mut reflected) = (0.0, 0.0);
    for (x, w) in GAUSS {
        let h = 0.5 * (low + high) + 0.5 * (high - low) * x;
        let cos_gamma = (1.0 - (kappa * h).powi(2)).sqrt();
        let last = (critical / cos_gamma).min(1.0).acos().min(b);
        if last <= a {
            continue;
        }
        inside += 0.5 * w * (squared(last) - squared(a));
        for (y, v) in GAUSS {
            let theta = 0.5 * (a + last) + 0.5 * (last - a) * y;
            let cos = theta.cos() * cos_gamma;
            let outside = (1.0 - eta * eta * (1.0 - cos * cos)).max(0.0).sqrt();
            let f = fresnel(eta as f32, 1.0, outside as f32).reflected;
            reflected += 0.5 * w * 0.5 * v * (last - a) * theta.cos().powi(2) * f64::from(f);
        }
    }
    let share = inside / (squared(b) - squared(a));
    [share, if inside > 0.0 { reflected / inside } else { 0.0 }]
}

impl Cone {
    pub fn new() -> Self {
        let position = |i: usize, n: usize| i as f64 / (n - 1) as f64;
        let rows = (0..KAPPAS * INDICES).map(|row| {
            let kappa = position(row / INDICES, KAPPAS);
            let eta = 1.0 / (LEAST_INDEX + (1.0 - LEAST_INDEX) * position(row % INDICES, INDICES));
            let all: [[f64; 2]; STATES] = std::array::from_fn(|state| shares(kappa, eta, state));
            [0, 1].map(|k| pack(|state| all[state][k] as f32))
        });
        Cone(rows.collect())
    }

    /// The transmittance of the cuticle with `layers` slabs for light in each state.
    #[inline(always)]
    pub fn transmittance(&self, kappa: f32, eta: f32, layers: f32) -> Vector {
        let k = Between::new(kappa * (KAPPAS - 1) as f32, KAPPAS);
        let least = LEAST_INDEX as f32;
        let index = (1.0 / eta - least) / (1.0 - least);
        let n = Between::new(index * (INDICES - 1) as f32, INDICES);
        let at = |i: usize, j: usize| &self.0[(k.index + i) * INDICES + n.index + j];
        let rows = [at(0, 0), at(0, 1), at(1, 0), at(1, 1)];
        let weights = [(1.0 - k.t) * (1.0 - n.t), (1.0 - k.t) * n.t, k.t * (1.0 - n.t), k.t * n.t].map(f32x8::splat);
        let mut out = [f32x8::ZERO; REGISTERS];
        for r in 0..REGISTERS {
            let [mut inside, mut slab] = [f32x8::ZERO; 2];
            for (row, weight) in rows.iter().zip(weights) {
                inside = row[0][r].mul_add(weight, inside);
                slab = row[1][r].mul_add(weight, slab);
            }
            // 1 − l φ/(1 + (l − 1) φ) = (1 − φ)/(1 − φ + l φ).
            let through = f32x8::ONE - slab;
            out[r] = inside * through / slab.mul_add(f32x8::splat(layers), through).fast_max(f32x8::splat(1e-20));
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The table between its nodes, against the quadrature. The share changes by its full amount over a 15° cell, so
    /// that linear interpolation over 1/72 in 1/η is off by up to about a twentieth of it for small κ.
    #[test]
    fn interpolation_is_close_to_quadrature() {
        let cone = Cone::new();
        let (mut sum, mut worst, mut count) = (0.0f64, 0.0f64, 0);
        for i in 0..23 {
            for j in 0..29 {
                let (kappa, eta) = (0.043 * f64::from(i) + 0.01, 1.0 + 0.069 * f64::from(j));
                let ours = cone.transmittance(kappa as f32, eta as f32, 0.5);
                for state in 0..STATES {
                    let [inside, slab] = shares(kappa, eta, state);
                    let exact = inside * (1.0 - slab) / (1.0 - 0.5 * slab);
                    let error = (f64::from(ours[state / 8].to_array()[state % 8]) - exact).abs();
                    sum += error;
                    worst = worst.max(error);
                    count += 1;
                }
            }
        }
        let mean = sum / f64::from(count);
        println!("mean {mean:.5}, worst {worst:.4}");
        assert!(mean < 2e-3 && worst < 0.06, "{mean} {worst}");
    }
}
