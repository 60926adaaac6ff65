//! Accuracy of tables: compares compressed with simulated profiles at random parameters. These are between the nodes,
//! so the error includes rank, noise and interpolation.

use crate::exact::{Profile, mean_path};
use crate::simulate::medulla::{SimRng, azimuthal, longitudinal, longitudinal_borders, stream};
use rand::Rng;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};
use vellus::{TableData, grid};
use vellus_io::{Progress, Steps};

/// Number of azimuths of a comparison. Each longitudinal half has half as many steps in θᵢ.
const DIRECTIONS: usize = 720;

/// Number of random streams of one simulation.
const PARTS: u64 = 16;

/// The table that a profile belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableKind {
    /// C^N.
    Azimuthal,
    /// C^M, backward half.
    Backward,
    /// C^M, forward half.
    Forward,
}

impl TableKind {
    /// All tables.
    pub const ALL: [TableKind; 3] = [TableKind::Azimuthal, TableKind::Backward, TableKind::Forward];

    /// The name in reports.
    pub fn name(self) -> &'static str {
        ["azimuthal", "backward", "forward"][self as usize]
    }
}

/// The error of one profile.
#[derive(Clone, Debug, PartialEq)]
pub struct ProfileError {
    /// The table.
    pub kind: TableKind,
    /// τ, g, and h″ or θ_o (radians).
    pub parameters: [f64; 3],
    /// L1 error: ∫ |table − simulation|, where the simulation has integral 1.
    pub l1: f64,
    /// The L1 error that the noise of the simulation alone would give: the expected L1 distance between the simulation
    /// and its mean.
    pub noise: f64,
    /// Relative error of the mean path; only for azimuthal profiles.
    pub mean_path: Option<f64>,
}

/// The parameters of comparison `index`. They are uniform over the axes of the tables, so small τ and sharp peaks are
/// as frequent as other values.
fn parameters(seed: u64, index: u64) -> ([f64; 3], SimRng) {
    let mut rng = stream(seed, index);
    let mut uniform = || (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    let p = [uniform(), uniform(), uniform()];
    ([grid::tau_at(p[0]), grid::g_at(p[1]), p[2]], rng)
}

/// Expected Σ |p̂ − p| of a histogram of `n` samples: Σ √(2 p/(π n)) while np is not small.
fn histogram_noise(probabilities: &[f64], n: f64) -> f64 {
    probabilities.iter().map(|p| (2.0 * p / (PI * n)).sqrt().min(2.0 * p)).sum()
}

/// Compares the azimuthal profile of comparison `index` with a simulation of `photons` photons.
pub fn check_azimuthal(tables: &TableData, photons: u64, seed: u64, index: u64) -> ProfileError {
    let ([tau, g, position], _) = parameters(seed, index);
    let h = grid::offset_at(position);
    let parts: Vec<_> = (0..PARTS)
        .into_par_iter()
        .map(|part| azimuthal(tau, g, h, photons / PARTS, DIRECTIONS, &mut stream(seed ^ 0xa21, index * PARTS + part)))
        .collect();
    let mean = |f: &dyn Fn(usize) -> f64| (0..parts.len()).map(f).sum::<f64>() / PARTS as f64;
    let step = TAU / DIRECTIONS as f64;
    let profile = Profile::azimuthal(tables, tau, g, h);
    let simulated: Vec<f64> = (0..DIRECTIONS).map(|j| mean(&|k| parts[k].density[j]) * step).collect();
    let l1 = simulated.iter().enumerate().map(|(j, s)| (bin_azimuth(&profile, j, step) - s).abs()).sum();
    let path = mean(&|k| parts[k].mean_path);
    ProfileError {
        kind: TableKind::Azimuthal,
        parameters: [tau, g, h],
        l1,
        noise: histogram_noise(&simulated, photons as f64),
        mean_path: Some(mean_path(tables, tau, g, h) / path - 1.0),
    }
}

/// The probability of the bin around node `j`, by the midpoint rule with eight points.
fn bin_azimuth(profile: &Profile, j: usize, step: f64) -> f64 {
    let at = |k: i32| (j as f64 + (f64::from(k) + 0.5) / 8.0 - 0.5) * step;
    (0..8).map(|k| profile.eval(at(k).rem_euclid(TAU)) * step / 8.0).sum()
}

/// Compares both halves of the longitudinal profile of comparison `index`. θ_o is at most the last node of the tables.
pub fn check_longitudinal(tables: &TableData, photons: u64, seed: u64, index: u64) -> [ProfileError; 2] {
    let ([tau, g, position], _) = parameters(seed ^ 0x10e6, index);
    let theta_o = grid::theta_at(position);
    let nodes = DIRECTIONS / 2 + 1;
    let parts: Vec<_> = (0..PARTS)
        .into_par_iter()
        .map(|part| {
            longitudinal(tau, g, theta_o, photons / PARTS, nodes, &mut stream(seed ^ 0xa22, index * PARTS + part))
        })
        .collect();
    let borders = longitudinal_borders(nodes);
    let profiles = Profile::longitudinal(tables, tau, g, theta_o);
    [0usize, 1].map(|half| {
        let total: f64 = parts.iter().map(|p| p.fraction[half]).sum();
        let simulated: Vec<f64> = (0..nodes)
            .map(|j| {
                let density: f64 = parts.iter().map(|p| p.density[half][j] * p.fraction[half] / total).sum();
                density * (borders[j + 1] - borders[j])
            })
            .collect();
        let profile = &profiles[half];
        let table = |j: usize| {
            let (lo, hi) = (borders[j].asin(), borders[j + 1].asin());
            (0..8)
                .map(|k| lo + (hi - lo) * (f64::from(k) + 0.5) / 8.0)
                .map(|theta| profile.eval(theta) * theta.cos() * (hi - lo) / 8.0)
                .sum::<f64>()
        };
        ProfileError {
            kind: [TableKind::Backward, TableKind::Forward][half],
            parameters: [tau, g, theta_o],
            l1: simulated.iter().enumerate().map(|(j, s)| (table(j) - s).abs()).sum(),
            noise: histogram_noise(&simulated, photons as f64 * total / PARTS as f64),
            mean_path: None,
        }
    })
}

/// Compares `profiles` random profiles of each table with simulations of `photons` photons. `progress` gets reports,
/// but does not stop the work.
pub fn check(tables: &TableData, profiles: u64, photons: u64, seed: u64, progress: &dyn Progress) -> Vec<ProfileError> {
    let steps = Steps::new(progress, 2 * profiles, "simulating");
    let mut errors = Vec::new();
    for index in 0..profiles {
        errors.push(check_azimuthal(tables, photons, seed, index));
        steps.advance(1);
        errors.extend(check_longitudinal(tables, photons, seed, index));
        steps.advance(1);
    }
    errors
}

/// Mean, 95th percentile and maximum of values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// Mean.
    pub mean: f64,
    /// 95th percentile.
    pub p95: f64,
    /// Largest.
    pub max: f64,
}

/// Mean, 95th percentile and maximum of `values`, which must not be empty.
pub fn summary(mut values: Vec<f64>) -> Summary {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    Summary {
        mean: values.iter().sum::<f64>() / n as f64,
        p95: values[((0.95 * n as f64).ceil() as usize).clamp(1, n) - 1],
        max: values[n - 1],
    }
}
