//! The azimuth of scattered light in the near field: the model beside a simulated fibre.

use crate::simulate::energies::Offsets;
use crate::simulate::medulla::stream;
use crate::simulate::scattered::scattered;
use crate::simulate::tracer::{CHUNK, Fate, Surface, Tracer, check, out_of_range};
use rayon::prelude::*;
use std::f64::consts::TAU;
use vellus::{Bcsdf, Error, Fiber, Lobe, Window, direction};

/// Bins of 15° over the full circle. It is not folded, because light at h ≠ 0 is not symmetric in φ.
pub const BINS: usize = 24;

/// Points of the model in a bin.
const WITHIN: usize = 8;

/// How far the model's scattered light is from that of a simulated fibre, RGB.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AzimuthError {
    /// The scattered light of the simulated fibre, as a fraction of the light that hits the fibre.
    pub light: [f64; 3],
    /// Σ |model − simulation| over the bins, divided by `light` where it is above 0. It contains noise.
    pub l1: [f64; 3],
    /// The expected L1 distance between the simulation and its mean, divided like `l1`. The noise adds at most this to
    /// the expectation of `l1`.
    pub noise: [f64; 3],
}

/// Compares the light that the medulla scattered, over the azimuth at which it leaves the fibre at any inclination.
///
/// The light arrives at the inclination `theta_o` (radians, |θ_o| < 90°) and the offset `h` in [−1, 1]. The simulation
/// has two halves, together `photons` ≥ 2. The standard deviation of their mean is that of half of their difference,
/// which gives the noise. The result depends on the seed, but not on the number of threads.
///
/// # Errors
/// [`Error::OutOfRange`] if [`Fiber::validate`] returns it, or if `theta_o`, `h` or `photons` is out of range.
pub fn azimuth_error(fiber: &Fiber, theta_o: f64, h: f64, photons: u64, seed: u64) -> Result<AzimuthError, Error> {
    if photons < 2 {
        return Err(out_of_range("photons", photons as f64, "photons must be at least 2"));
    }
    let half = |seed: u64| scattered(fiber, theta_o, Offsets::At(h), [1, BINS], photons / 2, seed, &());
    let halves = [half(seed)?, half(!seed)?];
    let model = azimuths(fiber, theta_o, h)?;
    let mut error = AzimuthError::default();
    for c in 0..3 {
        for (bin, ours) in model.iter().enumerate() {
            let [a, b] = halves.each_ref().map(|half| half.first[bin][c] + half.later[bin][c]);
            let mean = 0.5 * (a + b);
            error.light[c] += mean;
            error.l1[c] += (ours[c] - mean).abs();
            error.noise[c] += 0.5 * (a - b).abs();
        }
        if error.light[c] > 0.0 {
            error.l1[c] /= error.light[c];
            error.noise[c] /= error.light[c];
        }
    }
    Ok(error)
}

/// The model's TTˢ, TRTˢ and scattered part of the rest lobe in each bin, as a fraction of the light that hits the
/// fibre, RGB. The arguments are those of [`azimuth_error`].
///
/// # Errors
/// [`Error::OutOfRange`] if [`Fiber::validate`] returns it.
pub fn azimuths(fiber: &Fiber, theta_o: f64, h: f64) -> Result<[[f64; 3]; BINS], Error> {
    let bcsdf = Bcsdf::new(fiber)?;
    let hit = bcsdf.at(direction(theta_o, 0.0), Window::near(h as f32));
    let energy = hit.energy().0.map(|lobe| lobe.map(f64::from));
    // The unscattered part of the rest lobe is even in φ. At one offset TRT, and each order after it, is the one
    // before times F T, so the orders after TRT sum to TRT²/(TT − TRT).
    let higher: [f64; 3] = std::array::from_fn(|c| {
        let [tt, trt] = [Lobe::Tt, Lobe::Trt].map(|lobe| energy[lobe as usize][c]);
        if tt > trt { trt * trt / (tt - trt) } else { 0.0 }
    });
    let step = TAU / (BINS * WITHIN) as f64;
    let mut bins = [[0.0; 3]; BINS];
    for (bin, sum) in bins.iter_mut().enumerate() {
        for k in 0..WITHIN {
            let light = hit.azimuthal((((bin * WITHIN + k) as f64 + 0.5) * step) as f32).0;
            for c in 0..3 {
                let lobes = [Lobe::Tts, Lobe::Trts, Lobe::Rest].map(|lobe| f64::from(light[lobe as usize][c]));
                sum[c] += step * (lobes.iter().sum::<f64>() - higher[c] / TAU);
            }
        }
    }
    Ok(bins)
}

/// The light that leaves a fibre, over the azimuth φ − φ_o: [`BINS`] bins from 0 to 2π, RGB, as fractions of the light
/// that hits it. The cuticle is smooth.
///
/// The light arrives at the inclination `theta_o` and the azimuth `phi_o` (radians, |θ_o| < 90°) from the longer axis
/// of the section. The result depends on the seed, but not on the number of threads.
///
/// # Errors
/// [`Error::OutOfRange`] if [`Fiber::validate`] returns it, or if `theta_o` or an offset is out of range.
pub fn all_azimuths(
    fiber: &Fiber,
    [theta_o, phi_o]: [f64; 2],
    offsets: Offsets,
    photons: u64,
    seed: u64,
) -> Result<[[f64; 3]; BINS], Error> {
    check(fiber, theta_o)?;
    offsets.check()?;
    let tracer = Tracer::new(fiber, Surface::SMOOTH).turned(phi_o);
    let chunks: Vec<_> = (0..photons.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let (mut rng, mut sums) = (stream(seed, chunk), [[0.0; 3]; BINS]);
            for k in chunk * CHUNK..((chunk + 1) * CHUNK).min(photons) {
                let h = offsets.of_photon(k, photons, &mut rng);
                tracer.photon(theta_o, h, &mut rng, &mut |fate, [_, y, z], energy| {
                    let bin = (z.atan2(y).rem_euclid(TAU) / TAU * BINS as f64) as usize % BINS;
                    if fate != Fate::Guided {
                        (0..3).for_each(|c| sums[bin][c] += energy[c]);
                    }
                });
            }
            sums
        })
        .collect();
    let mut light = [[0.0; 3]; BINS];
    for sums in chunks {
        (0..BINS).for_each(|bin| (0..3).for_each(|c| light[bin][c] += sums[bin][c] / photons as f64));
    }
    Ok(light)
}
