//! The far field of a whole fibre, with a rough cuticle and tilted scales, as a gonioreflectometer measures it.

use crate::simulate::medulla::{stream, uniform2};
use crate::simulate::tracer::{CHUNK, Fate, Surface, Tracer};
use rayon::prelude::*;
use std::f64::consts::TAU;
use vellus::{Error, Fiber};
use vellus_io::{Progress, Steps};

/// A grid of cells over θ and φ, in radians.
#[derive(Clone, Debug, PartialEq)]
pub struct Cells {
    /// θ of the centres, ascending and equidistant.
    pub theta: Vec<f64>,
    /// φ of the centres, ascending and equidistant.
    pub phi: Vec<f64>,
    /// Width of a cell in θ and in φ.
    pub size: [f64; 2],
}

/// Number of chunks whose histograms are in memory at a time.
const BATCH: u64 = 64;

/// Energy per solid angle that leaves into each cell, RGB, row by row over θ.
///
/// This is f·cos θᵢ of the far field, averaged over each cell. The photons arrive at inclination `theta_o` (radians)
/// over the whole width of the fibre. The result depends on the seed, but not on the number of threads. A cancelled
/// simulation ends early, and its result means nothing.
///
/// # Errors
/// [`Error::OutOfRange`] if [`Fiber::validate`] returns it.
pub fn profile(
    fiber: &Fiber,
    theta_o: f64,
    cells: &Cells,
    photons: u64,
    seed: u64,
    progress: &dyn Progress,
) -> Result<Vec<[f64; 3]>, Error> {
    fiber.validate()?;
    let tracer = Tracer::new(fiber, Surface::of(fiber));
    let steps = Steps::new(progress, photons, "tracing");
    let chunks = photons.div_ceil(CHUNK);
    let mut sums = vec![[0.0; 3]; cells.theta.len() * cells.phi.len()];
    for first in (0..chunks).step_by(BATCH as usize) {
        if progress.is_cancelled() {
            break;
        }
        let batch: Vec<Vec<[f64; 3]>> = (first..chunks.min(first + BATCH))
            .into_par_iter()
            .map(|chunk| {
                let mut rng = stream(seed, chunk);
                let mut sums = vec![[0.0; 3]; cells.theta.len() * cells.phi.len()];
                if progress.is_cancelled() {
                    return sums;
                }
                let range = chunk * CHUNK..((chunk + 1) * CHUNK).min(photons);
                let count = range.end - range.start;
                for k in range {
                    let h = 2.0 * (k as f64 + f64::from(uniform2(&mut rng).0)) / photons as f64 - 1.0;
                    tracer.photon(theta_o, h, &mut rng, &mut |fate, direction, energy| {
                        if fate != Fate::Guided {
                            cells.add(&mut sums, direction, energy);
                        }
                    });
                }
                steps.advance(count);
                sums
            })
            .collect();
        for part in batch {
            for (sum, x) in sums.iter_mut().zip(part) {
                (0..3).for_each(|c| sum[c] += x[c]);
            }
        }
    }
    for (i, sum) in sums.iter_mut().enumerate() {
        let theta = cells.theta[i / cells.phi.len()];
        let [low, high] = [-0.5, 0.5].map(|x| (theta + x * cells.size[0]).sin());
        let solid_angle = cells.size[1] * (high - low);
        *sum = sum.map(|x| x / (solid_angle * photons as f64));
    }
    Ok(sums)
}

impl Cells {
    /// Adds light that leaves. Half of it goes to the mirror image in φ, because offsets have both signs.
    fn add(&self, sums: &mut [[f64; 3]], direction: [f64; 3], energy: [f64; 3]) {
        let theta = direction[0].clamp(-1.0, 1.0).asin();
        let phi = direction[2].atan2(direction[1]);
        let Some(row) = index(&self.theta, self.size[0], theta) else { return };
        for phi in [phi, -phi] {
            // If the cells cover more than a full turn, some directions belong to two cells.
            for turn in [-TAU, 0.0, TAU] {
                if let Some(column) = index(&self.phi, self.size[1], phi + turn) {
                    let sum = &mut sums[row * self.phi.len() + column];
                    (0..3).for_each(|c| sum[c] += 0.5 * energy[c]);
                }
            }
        }
    }
}

/// The index of the cell with an angle. The centres are equidistant and ascending.
fn index(middles: &[f64], size: f64, angle: f64) -> Option<usize> {
    let step = if middles.len() > 1 { middles[1] - middles[0] } else { size };
    let nearest = ((angle - middles.first()?) / step).round();
    if nearest < 0.0 || nearest >= middles.len() as f64 {
        return None;
    }
    let i = nearest as usize;
    ((angle - middles[i]).abs() <= 0.5 * size).then_some(i)
}
