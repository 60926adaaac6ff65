//! Energies of the paths through a whole fibre with a smooth cuticle and flat scales, by Monte Carlo.
//!
//! [`mod@crate::simulate::profile`] has a rough cuticle with tilted scales.

use crate::simulate::medulla::{SimRng, stream, uniform2};
use crate::simulate::tracer::{CHUNK, Surface, Tracer, check, out_of_range};
use rayon::prelude::*;
use vellus::{Error, Fiber};
use vellus_io::{Progress, Steps};

pub use crate::simulate::tracer::Fate;

/// Energies with their standard errors, RGB, as fractions of the light that hits the fibre.
#[derive(Clone, Debug, PartialEq)]
pub struct Energies {
    /// Photons traced.
    pub photons: u64,
    /// Mean energy of each [`Fate`].
    pub mean: [[f64; 3]; 6],
    /// Standard error of each mean.
    pub error: [[f64; 3]; 6],
    /// Mean and standard error of all light that leaves: the sum without [`Fate::Guided`].
    pub total: [[f64; 3]; 2],
}

/// Offsets at which light enters the fibre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Offsets {
    /// One offset h, in [−1, 1].
    At(f64),
    /// Uniform over the whole width.
    Whole,
}

impl Offsets {
    /// Checks that the offset is in range.
    pub(crate) fn check(self) -> Result<(), Error> {
        match self {
            Offsets::At(h) if !(-1.0..=1.0).contains(&h) => Err(out_of_range("h", h, "h must be in [-1, 1]")),
            _ => Ok(()),
        }
    }

    /// The offset of photon `k` of `photons`. Over the whole width, offsets are stratified.
    pub(crate) fn of_photon(self, k: u64, photons: u64, rng: &mut SimRng) -> f64 {
        match self {
            Offsets::At(h) => h,
            Offsets::Whole => 2.0 * (k as f64 + f64::from(uniform2(rng).0)) / photons as f64 - 1.0,
        }
    }
}

/// Energies of light that arrives at inclination `theta_o` (radians, |θ_o| < 90°), from `photons` ≥ 2 photons.
///
/// The result depends on the seed, but not on the number of threads. A cancelled simulation ends early, and its result
/// means nothing.
///
/// # Errors
/// [`Error::OutOfRange`] if [`Fiber::validate`] returns it, or if `theta_o`, an offset or `photons` is out of range.
pub fn energies(
    fiber: &Fiber,
    theta_o: f64,
    offsets: Offsets,
    photons: u64,
    seed: u64,
    progress: &dyn Progress,
) -> Result<Energies, Error> {
    check(fiber, theta_o)?;
    offsets.check()?;
    if photons < 2 {
        return Err(out_of_range("photons", photons as f64, "photons must be at least 2"));
    }
    let steps = Steps::new(progress, photons, "tracing");
    let tracer = Tracer::new(fiber, Surface::SMOOTH);
    let sums: Vec<Sums> = (0..photons.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let mut rng = stream(seed, chunk);
            let mut sums = Sums::default();
            if progress.is_cancelled() {
                return sums;
            }
            let range = chunk * CHUNK..((chunk + 1) * CHUNK).min(photons);
            let count = range.end - range.start;
            for k in range {
                let mut photon = [[0.0; 3]; 6];
                // Offsets over the whole width are stratified. The standard error is therefore an overestimate.
                let h = offsets.of_photon(k, photons, &mut rng);
                tracer.photon(theta_o, h, &mut rng, &mut |fate, _, energy| {
                    (0..3).for_each(|c| photon[fate as usize][c] += energy[c]);
                });
                sums.add(&photon);
            }
            steps.advance(count);
            sums
        })
        .collect();
    // The order of the sum does not depend on threads.
    let mut all = Sums::default();
    sums.iter().for_each(|s| all.merge(s));
    Ok(all.energies(photons))
}

/// Sums of energies and of their squares. The last row is the total that leaves.
#[derive(Clone, Default)]
struct Sums {
    first: [[f64; 3]; 7],
    second: [[f64; 3]; 7],
}

impl Sums {
    fn add(&mut self, photon: &[[f64; 3]; 6]) {
        for c in 0..3 {
            let mut total = 0.0;
            for p in 0..6 {
                self.first[p][c] += photon[p][c];
                self.second[p][c] += photon[p][c].powi(2);
                total += if p == Fate::Guided as usize { 0.0 } else { photon[p][c] };
            }
            self.first[6][c] += total;
            self.second[6][c] += total * total;
        }
    }

    fn merge(&mut self, other: &Sums) {
        for p in 0..7 {
            for c in 0..3 {
                self.first[p][c] += other.first[p][c];
                self.second[p][c] += other.second[p][c];
            }
        }
    }

    fn energies(&self, photons: u64) -> Energies {
        let n = photons as f64;
        let mean = |p: usize| self.first[p].map(|s| s / n);
        let error = |p: usize| {
            std::array::from_fn(|c| {
                let mean = self.first[p][c] / n;
                ((self.second[p][c] / n - mean * mean).max(0.0) / (n - 1.0)).sqrt()
            })
        };
        Energies {
            photons,
            mean: std::array::from_fn(mean),
            error: std::array::from_fn(error),
            total: [mean(6), error(6)],
        }
    }
}
