//! Light in a disc that scatters and does not absorb: the table of multiple scattering.

use super::Random;
use crate::error::Error;
use crate::orders::{AZIMUTHS, COSINES, COUNTS, GROUPS, LAST, Multiple, Orders, TAUS, group};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Photons that share one stream of random numbers.
const BATCH: u64 = 50_000;

/// A disc of radius 1 and what light does in it.
///
/// The angle of each collision has the density (1 − g²)/(2π (1 + g² − 2 g cos Δ)), the wrapped Cauchy distribution. Its
/// n-fold convolution has the mean cosine gⁿ.
#[derive(Clone, Copy, Debug)]
pub struct Disc {
    /// The optical diameter, above 0.
    pub tau: f64,
    /// The mean cosine of a collision's angle, in (−1, 1).
    pub g: f64,
}

/// Sums of one batch.
struct Sums {
    counts: Vec<f64>,
    azimuths: [Vec<f64>; GROUPS],
    again: f64,
}

impl Sums {
    fn new() -> Self {
        Sums { counts: vec![0.0; COUNTS], azimuths: std::array::from_fn(|_| vec![0.0; AZIMUTHS]), again: 0.0 }
    }

    fn add(&mut self, other: &Sums) {
        let pairs = |a: &mut [f64], b: &[f64]| a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        pairs(&mut self.counts, &other.counts);
        self.azimuths.iter_mut().zip(&other.azimuths).for_each(|(a, b)| pairs(a, b));
        self.again += other.again;
    }

    /// Light that leaves at an azimuth in [−π, π]. Its weight is divided between the two nearest nodes, and by the
    /// width that each node stands for.
    fn leave(&mut self, collisions: usize, azimuth: f64, weight: f64) {
        self.counts[collisions.min(LAST + 1) - 2] += weight;
        let x = azimuth.abs() / PI * (AZIMUTHS - 1) as f64;
        let k = (x as usize).min(AZIMUTHS - 2);
        let share = x - k as f64;
        let width = |k: usize| if k == 0 || k == AZIMUTHS - 1 { 0.5 } else { 1.0 };
        let density = &mut self.azimuths[group(collisions)];
        density[k] += weight * (1.0 - share) / width(k);
        density[k + 1] += weight * share / width(k + 1);
    }
}

impl Disc {
    /// Simulates light that collides at least twice, with a multiple of 50,000 photons. Also returns the probability
    /// that light which collided collides again.
    pub fn simulate(&self, seed: u64, photons: u64) -> (Multiple, f64) {
        let batches: Vec<Sums> = (0..photons.div_ceil(BATCH))
            .into_par_iter()
            .map(|batch| self.batch(&mut Random::new(seed, batch)))
            .collect();
        let mut total = Sums::new();
        batches.iter().for_each(|batch| total.add(batch));
        let again = total.again / (batches.len() as u64 * BATCH) as f64;
        (Multiple::normalized(total.counts, total.azimuths), again)
    }

    fn batch(&self, random: &mut Random) -> Sums {
        let mut sums = Sums::new();
        (0..BATCH).for_each(|_| self.photon(random, &mut sums));
        sums
    }

    /// Traces light that comes along the azimuth π. The first two collisions are forced: the first by the choice of the
    /// offset, the second by a weight.
    fn photon(&self, random: &mut Random, sums: &mut Sums) {
        let sigma = 0.5 * self.tau;
        let (mut position, mut free) = loop {
            let h = 2.0 * random.uniform() - 1.0;
            let half = (1.0 - h * h).sqrt();
            let hits = -libm::expm1(-self.tau * half);
            if random.uniform() * -libm::expm1(-self.tau) < hits {
                break ([half, h], -libm::log1p(-random.uniform() * hits) / sigma);
            }
        };
        let mut angle = PI;
        let mut weight = 1.0;
        for collisions in 1.. {
            let direction = [libm::cos(angle), libm::sin(angle)];
            position = [position[0] + free * direction[0], position[1] + free * direction[1]];
            angle = libm::remainder(angle + self.turn(random), 2.0 * PI);
            let along = position[0] * libm::cos(angle) + position[1] * libm::sin(angle);
            let square = position[0] * position[0] + position[1] * position[1];
            let edge = -along + (1.0 - square + along * along).max(0.0).sqrt();
            let stays = -libm::expm1(-sigma * edge);
            if collisions == 1 {
                weight = stays;
                sums.again += stays;
            } else if random.uniform() >= stays {
                return sums.leave(collisions, angle, weight);
            }
            free = -libm::log1p(-random.uniform() * stays) / sigma;
        }
    }

    /// An angle of the wrapped Cauchy distribution.
    fn turn(&self, random: &mut Random) -> f64 {
        2.0 * libm::atan((1.0 - self.g) / (1.0 + self.g) * libm::tan(PI * (random.uniform() - 0.5)))
    }
}

/// The bytes of the table `data/orders.vellus`, from this number of photons for each node.
pub fn build(seed: u64, photons: u64) -> Vec<u8> {
    let nodes: Vec<Multiple> = TAUS
        .iter()
        .flat_map(|&tau| COSINES.map(|g| Disc { tau, g }))
        .zip(seed..)
        .map(|(disc, seed)| disc.simulate(seed, photons).0)
        .collect();
    Orders::to_bytes(&nodes)
}

/// What the table of this crate has for a disc, interpolated between its nodes.
///
/// # Errors
/// [`Error::Table`] if the table is damaged.
pub fn tabulated(disc: Disc) -> Result<Multiple, Error> {
    Ok(Orders::shipped()?.at(disc.tau, disc.g))
}
