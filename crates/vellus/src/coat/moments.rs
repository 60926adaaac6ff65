//! How much light a fibre keeps at a scattering, and how far the light turns: the moments that determine the colour of a
//! coat.

use crate::bcsdf::Bcsdf;
use crate::fiber::Fiber;
use crate::near::NearHit;
use crate::prepared::Prepared;
use wide::f32x8;

/// Inclinations of ω_o, degrees. Directions are spread evenly over the sphere, and fibres intercept light in proportion
/// to cos θ, so their density is cos²θ. Each stands for the same share of the light.
pub const INCLINATIONS: usize = 3;
const THETA: [f32; INCLINATIONS] = [35.0, 42.0, 48.0];

/// For each inclination and lobe: the share of light A in the lobe, and A times the mean cosine between the directions
/// of the light before and after it, both averaged over the width of the fibre.
pub type Moments = [[[f32; 2]; 6]; INCLINATIONS];

/// The directions of the lobes of a fibre, which do not depend on absorption.
#[derive(Clone, Debug)]
pub struct Shape {
    fiber: Fiber,
    /// Mean cosines of the lobes, for each inclination at eight offsets.
    cosines: [[f32x8; 6]; INCLINATIONS],
}

/// Offsets h ≥ 0. A fibre is symmetric.
fn offsets() -> f32x8 {
    f32x8::new(std::array::from_fn(|i| (i as f32 + 0.5) / 8.0))
}

impl Shape {
    /// The fibre must be valid.
    pub fn new(fiber: &Fiber) -> Self {
        let white = fiber.without_absorption();
        let prepared = Prepared::new(&white, crate::medulla::tables::Tables::shipped());
        let h = offsets().to_array();
        let cosines = THETA.map(|theta| {
            let (sin, cos) = theta.to_radians().sin_cos();
            let at: [[f32; 6]; 8] = std::array::from_fn(|i| {
                let turns = NearHit::new(&prepared, [sin, cos, 0.0], h[i]).mean_cosines();
                // The inclination of specular lobes is that of the light. Scattered light has any inclination.
                std::array::from_fn(|p| {
                    let v = (fiber.beta_m * [1.0, 0.5, 1.5, 2.0, 2.0, 2.0][p]).powi(2);
                    if p < 3 { (-0.5 * v).exp() * (sin * sin - cos * cos * turns[p]) } else { -cos * turns[p] }
                })
            });
            std::array::from_fn(|p| f32x8::new(std::array::from_fn(|i| at[i][p])))
        });
        Shape { fiber: *fiber, cosines }
    }

    /// The moments of three fibres: of this one with three absorptions in cortex and medulla.
    pub fn moments(&self, cortex: [f32; 3], medulla: [f32; 3]) -> [Moments; 3] {
        let fiber = Fiber { sigma_ca: cortex, sigma_ma: medulla, ..self.fiber };
        let mut moments = [[[[0.0; 2]; 6]; INCLINATIONS]; 3];
        let Ok(model) = Bcsdf::new(&fiber) else { return moments };
        for (t, theta) in THETA.into_iter().enumerate() {
            let (sin, cos) = theta.to_radians().sin_cos();
            let wo = [f32x8::splat(sin), f32x8::splat(cos), f32x8::splat(0.0)];
            let energy = model.at8(wo, offsets()).energy();
            for (p, lobe) in energy.0.iter().enumerate() {
                for (c, share) in lobe.iter().enumerate() {
                    let mean = |x: f32x8| x.reduce_add() / 8.0;
                    moments[c][t][p] = [mean(*share), mean(*share * self.cosines[t][p])];
                }
            }
        }
        moments
    }
}
