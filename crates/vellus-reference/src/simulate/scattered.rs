//! Where light that the medulla scattered leaves a whole fibre with a smooth cuticle: at its first encounter with the
//! cuticle after scattering, and at later ones.

use crate::simulate::energies::Offsets;
use crate::simulate::medulla::stream;
use crate::simulate::tracer::{CHUNK, Fate, Surface, Tracer, check, out_of_range};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};
use vellus::{Error, Fiber};
use vellus_io::{Progress, Steps};

/// The scattered light in equal cells of θ and φ.
///
/// The energy of the light that leaves into each cell, as a fraction of the light that hits the fibre, RGB, row by row
/// over θ from −90° to 90°. A row begins at φ = 0, the azimuth of ω_o, and covers the full circle.
#[derive(Clone, Debug, PartialEq)]
pub struct Scattered {
    /// Numbers of cells over θ and over φ.
    pub cells: [usize; 2],
    /// Light that left at its first encounter with the cuticle after scattering.
    pub first: Vec<[f64; 3]>,
    /// Light that the cuticle reflected from inside at least once after scattering.
    pub later: Vec<[f64; 3]>,
}

/// Traces `photons` ≥ 1 photons that arrive at the inclination `theta_o` (radians, |θ_o| < 90°). `cells`: the numbers
/// of cells over θ and over φ, each at least 1. At one offset h ≠ 0 the light is not symmetric in φ.
///
/// The result depends on the seed, but not on the number of threads. `progress` gets reports, but does not stop the
/// simulation.
///
/// # Errors
/// [`Error::OutOfRange`] if [`Fiber::validate`] returns it, or if `theta_o`, an offset, `cells` or `photons` is out of
/// range.
pub fn scattered(
    fiber: &Fiber,
    theta_o: f64,
    offsets: Offsets,
    cells: [usize; 2],
    photons: u64,
    seed: u64,
    progress: &dyn Progress,
) -> Result<Scattered, Error> {
    check(fiber, theta_o)?;
    offsets.check()?;
    if photons == 0 {
        return Err(out_of_range("photons", 0.0, "photons must be at least 1"));
    }
    if cells.contains(&0) {
        return Err(out_of_range("cells", 0.0, "cells must be at least 1 over theta and over phi"));
    }
    let steps = Steps::new(progress, photons, "tracing");
    let tracer = Tracer::new(fiber, Surface::SMOOTH);
    let empty = || [0, 1].map(|_| vec![[0.0; 3]; cells[0] * cells[1]]);
    let parts: Vec<[Vec<[f64; 3]>; 2]> = (0..photons.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let mut rng = stream(seed, chunk);
            let mut sums = empty();
            let range = chunk * CHUNK..((chunk + 1) * CHUNK).min(photons);
            let count = range.end - range.start;
            for k in range {
                let h = offsets.of_photon(k, photons, &mut rng);
                tracer.encounters(theta_o, h, &mut rng, &mut |fate, encounter, direction, energy| {
                    if fate == Fate::Scattered {
                        let sum = &mut sums[usize::from(encounter > 1)][cell(cells, direction)];
                        (0..3).for_each(|c| sum[c] += energy[c]);
                    }
                });
            }
            steps.advance(count);
            sums
        })
        .collect();
    // The order of the sum does not depend on threads.
    let mut all = empty();
    for part in parts {
        for (sum, x) in all.iter_mut().flatten().zip(part.iter().flatten()) {
            (0..3).for_each(|c| sum[c] += x[c]);
        }
    }
    let [first, later] = all.map(|sums| sums.into_iter().map(|sum| sum.map(|x| x / photons as f64)).collect());
    Ok(Scattered { cells, first, later })
}

/// The index of the cell of a direction.
fn cell([rows, columns]: [usize; 2], direction: [f64; 3]) -> usize {
    let theta = direction[0].clamp(-1.0, 1.0).asin();
    let phi = direction[2].atan2(direction[1]).rem_euclid(TAU);
    let row = ((theta / PI + 0.5) * rows as f64) as usize;
    let column = (phi / TAU * columns as f64) as usize;
    row.min(rows - 1) * columns + column.min(columns - 1)
}
