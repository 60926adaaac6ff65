//! The cell over which a detector averages: quadrature over the directions in it.

use crate::profile::Quantity;
use vellus::Fiber;
use vellus_models::gauss_legendre;

/// The distance of the directions in a cell during a search, over θ and φ in degrees.
pub const ROUGH: [f64; 2] = [5.0; 2];

/// The most directions over one side of a cell.
const MOST: usize = 16;

/// The distance of the directions in a cell, over θ and φ in degrees, that the lobes of a fibre need.
///
/// The narrowest lobe over θ is TT, of half the roughness. Points are at most 1.5 of its standard deviations apart, and
/// there is one more than that. An average of a Gaussian is then right to within 0.4 %.
pub fn distance(fiber: &Fiber) -> [f64; 2] {
    [0.75 * fiber.beta_m, fiber.beta_n].map(|x| f64::from(x).to_degrees())
}

/// The number of directions over a side of a cell.
fn count(width: f64, distance: f64) -> usize {
    if width == 0.0 { 1 } else { ((width / distance).ceil() as usize).saturating_add(1).min(MOST) }
}

/// The directions of all cells, and their weights.
#[derive(Clone, Debug)]
pub struct Aperture {
    /// Directions of each cell.
    nodes: usize,
    /// θ and φ in degrees, cell by cell.
    angles: Vec<[f64; 2]>,
    weights: Vec<f64>,
}

impl Aperture {
    /// The cells with these full widths and centres, and the weights for values of a quantity. `distance` is that of
    /// the directions in a cell. All angles are in degrees.
    pub fn new(
        blur: [f64; 2],
        quantity: Quantity,
        centres: impl Iterator<Item = [f64; 2]>,
        distance: [f64; 2],
    ) -> Self {
        let [over_theta, over_phi] = [0, 1].map(|k| {
            let width = blur[k];
            let rule = gauss_legendre(count(width, distance[k]));
            rule.into_iter().map(|[x, weight]| [0.5 * width * x, 0.5 * weight]).collect::<Vec<_>>()
        });
        let nodes = over_theta.len() * over_phi.len();
        let (mut angles, mut weights) = (Vec::new(), Vec::new());
        for [theta, phi] in centres {
            let first = weights.len();
            for [dt, wt] in &over_theta {
                // Equal azimuths and inclinations of neighbouring cells are computed once.
                let theta = tidy(theta + dt);
                let cosine = theta.to_radians().cos().max(0.0);
                for [dp, wp] in &over_phi {
                    angles.push([theta.clamp(-90.0, 90.0), tidy(phi + dp)]);
                    // Cells have their solid angle, and the model returns f·cos θ.
                    weights.push(if theta.abs() >= 90.0 { 0.0 } else { wt * wp * cosine });
                }
            }
            let sum: f64 = weights[first..].iter().sum();
            for (weight, [theta, _]) in weights[first..].iter_mut().zip(&angles[first..]) {
                *weight /= match quantity {
                    Quantity::FCos => sum,
                    Quantity::F => sum * theta.to_radians().cos().max(1e-9),
                };
            }
        }
        Aperture { nodes, angles, weights }
    }

    /// θ and φ in degrees of the directions, cell by cell.
    pub fn angles(&self) -> &[[f64; 2]] {
        &self.angles
    }

    /// The average over each cell, RGB, of values of f·cos θ in all directions.
    pub fn averages(&self, values: &[[f32; 3]]) -> Vec<[f64; 3]> {
        let cells = values.chunks(self.nodes).zip(self.weights.chunks(self.nodes));
        cells
            .map(|(values, weights)| {
                let mut sum = [0.0; 3];
                for (value, weight) in values.iter().zip(weights) {
                    (0..3).for_each(|c| sum[c] += weight * f64::from(value[c]));
                }
                sum
            })
            .collect()
    }
}

/// An angle without the rounding errors of a sum.
fn tidy(x: f64) -> f64 {
    (x * 1e9).round() / 1e9
}
