//! How much light a fibre keeps at a scattering, and how far the light turns.

use crate::bcsdf::Bcsdf;
use crate::fiber::Fiber;
use crate::medulla::tables::Tables;
use crate::near::Near;
use crate::prepared::Prepared;
use wide::f32x8;

/// The inclination of ω_o that stands for all light in the coat, radians: 42°. Of inclinations between 25° and 65° it
/// gave the best fit, and several together gave no better one.
const THETA: f32 = 0.733;

/// For each lobe: the share of light A in the lobe, and A times the mean cosine of the angle ψ by which its light
/// turns. Both are averaged over the width of the fibre.
pub type Moments = [[f32; 2]; 6];

/// The directions of the lobes of a fibre. They do not depend on absorption.
#[derive(Clone, Debug)]
pub struct Shape {
    fiber: Fiber,
    /// ⟨cos ψ⟩ of the lobes at eight offsets.
    cosines: [f32x8; 6],
}

/// Offsets h ≥ 0. A fibre is symmetric.
fn offsets() -> [f32; 8] {
    std::array::from_fn(|i| (i as f32 + 0.5) / 8.0)
}

impl Shape {
    /// The fibre must be valid.
    pub fn new(fiber: &Fiber) -> Self {
        let fiber = &Fiber { aspect_ratio: 1.0, ..*fiber };
        let prepared = Prepared::new(&fiber.without_absorption(), Tables::shipped());
        let (sin, cos) = THETA.sin_cos();
        let at = offsets().map(|h| {
            let near = if prepared.section.is_some() { Near::bent } else { Near::new };
            let turns = near(&prepared, [sin, cos, 0.0], h).mean_cosines();
            std::array::from_fn(|p| {
                // R, TT and TRT keep the inclination, except for their width (Table 2). Scattered light and the rest
                // leave at any inclination, and as much of it on both sides of the normal plane.
                let Some(width) = [1.0, 0.5, 1.5].get(p) else { return -cos * turns[p] };
                (-0.5 * (fiber.beta_m * width).powi(2)).exp() * (sin * sin - cos * cos * turns[p])
            })
        });
        let at: [[f32; 6]; 8] = at;
        let cosines = std::array::from_fn(|p| f32x8::new(std::array::from_fn(|i| at[i][p])));
        Shape { fiber: *fiber, cosines }
    }

    /// The moments of three fibres: of this one with three absorptions in cortex and medulla, each in range.
    pub fn moments(&self, cortex: [f32; 3], medulla: [f32; 3]) -> [Moments; 3] {
        let fiber = Fiber { sigma_ca: cortex, sigma_ma: medulla, ..self.fiber };
        let mut moments = [Moments::default(); 3];
        // A fibre out of range reflects nothing.
        let Ok(model) = Bcsdf::new(&fiber) else { return moments };
        let (sin, cos) = THETA.sin_cos();
        let energy = model.at8([sin, cos, 0.0].map(f32x8::splat), f32x8::new(offsets())).energy();
        let mean = |x: f32x8| x.reduce_add() / 8.0;
        for (p, (lobe, cosine)) in energy.0.iter().zip(self.cosines).enumerate() {
            for (channel, share) in lobe.iter().enumerate() {
                moments[channel][p] = [mean(*share), mean(*share * cosine)];
            }
        }
        moments
    }
}
