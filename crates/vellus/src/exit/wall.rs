//! The wall of a medulla with air (D24), for the light in each state: what it reflects, what the cuticle then lets
//! through, and the way between both.
//!
//! A state is described inside the medulla, at the inclination θ′ and the offset h″. In the normal plane, light of the
//! offset κ h″ then has the offset κ h″ η_m′/η′ in the cortex, and κ h″ η_m′ outside.

use crate::cylinder::cuticle::{parts, refracted_cos2};
use crate::exit::states::{REGISTERS, Vector, cell, pack};
use crate::fiber::Fiber;
use wide::f32x8;

/// Midpoints over the inclinations and the offsets of a state.
const POINTS: [usize; 2] = [4, 3];

/// Means over each state, weighted by cos²θ′.
pub(crate) struct Walls {
    /// The reflectance of the wall.
    pub back: Vector,
    /// The transmittance of the cuticle for light that passed the wall.
    pub through: Vector,
    /// The length of the path from the medulla to the cuticle, in fibre radii.
    pub cortex: Vector,
}

impl Walls {
    /// `None` if the medulla has the index of the cortex.
    pub fn new(fiber: &Fiber) -> Option<Self> {
        if fiber.medulla_air == 0.0 {
            return None;
        }
        let (splat, one) = (f32x8::splat, f32x8::ONE);
        let (eta_m, kappa) = (fiber.medulla_eta(), fiber.kappa);
        let end = |axis: usize, k: usize| pack(|state| cell(state)[axis][k] as f32);
        let ends = [[end(0, 0), end(0, 1)], [end(1, 0), end(1, 1)]];
        let zero = [f32x8::ZERO; REGISTERS];
        let mut walls = Walls { back: zero, through: zero, cortex: zero };
        for r in 0..REGISTERS {
            let at = |axis: usize, k: usize| {
                let [low, high] = [ends[axis][0][r], ends[axis][1][r]];
                low + (high - low) * splat((k as f32 + 0.5) / POINTS[axis] as f32)
            };
            let mut weights = f32x8::ZERO;
            for k in 0..POINTS[0] * POINTS[1] {
                let (theta, h) = (at(0, k / POINTS[1]), at(1, k % POINTS[1]));
                let (sin, cos) = theta.sin_cos();
                let (cos2, h2) = (cos * cos, h * h);
                // The cosine of the inclination in the cortex, and the square of the offset there.
                let across = sin * splat(eta_m / fiber.eta);
                let cortex2 = (one - across * across).fast_max(splat(1e-12));
                let offset2 = splat(kappa * kappa * (eta_m / fiber.eta).powi(2)) * h2 * cos2 / cortex2;
                // cos² of the angles to the wall, on its inner side, and to the cuticle, outside.
                let inner2 = cos2 * (one - h2);
                let outside2 = one - splat(eta_m * eta_m) * (one - cos2 * (one - splat(kappa * kappa) * h2));
                let fresnel = |eta: f32, layers: f32, cos2: f32x8| {
                    let cos2 = cos2.fast_max(f32x8::ZERO);
                    let [back, through] = parts(eta, layers, cos2.sqrt(), refracted_cos2(eta, cos2).sqrt());
                    back / (back + through)
                };
                let wall = fresnel(fiber.eta / eta_m, 0.5, inner2);
                let through = one - fresnel(fiber.eta, fiber.layers, outside2);
                let through = outside2.simd_gt(f32x8::ZERO).select(through, f32x8::ZERO);
                let way = (one - offset2).fast_max(f32x8::ZERO).sqrt()
                    - (splat(kappa * kappa) - offset2).fast_max(f32x8::ZERO).sqrt();
                walls.back[r] += cos2 * wall;
                walls.through[r] += cos2 * through;
                walls.cortex[r] += cos2 * (way / cortex2.sqrt());
                weights += cos2;
            }
            for sum in [&mut walls.back[r], &mut walls.through[r], &mut walls.cortex[r]] {
                *sum = (*sum / weights).fast_min(splat(1e6));
            }
        }
        Some(walls)
    }
}
