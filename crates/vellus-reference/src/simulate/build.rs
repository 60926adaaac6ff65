//! Builds the tables of the medulla: simulates profiles in pieces, and compresses them to [`TableData`].

use crate::simulate::compress::{Problem, compress};
use crate::simulate::exits::ExitQuality;
use crate::simulate::medulla::{azimuthal, longitudinal, longitudinal_borders, stream};
use ndarray::Array2;
use rayon::prelude::*;
use std::str::FromStr;
use vellus::{FactorTable, TableData, grid};
use vellus_io::{Progress, Steps};

/// Resolution and effort of the tables.
#[derive(Clone, Debug, PartialEq)]
pub struct Quality {
    /// Number of nodes of τ, g, h″ and θ_o.
    pub nodes: [usize; 4],
    /// Number of exit azimuths, a multiple of 4. Each longitudinal half has half as many steps in θᵢ.
    pub directions: usize,
    /// Photons per profile.
    pub photons: u64,
    /// Number of components of the azimuthal, backward and forward mixtures.
    pub ranks: [usize; 3],
    /// Number of sweeps of the compression.
    pub sweeps: usize,
    /// Stride of the nodes in g of the mean path. It must divide the number of steps in g.
    pub path_stride: usize,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Resolution and effort of the table of first exits.
    pub exits: ExitQuality,
}

impl Quality {
    /// The names that [`str::parse`] knows.
    pub const NAMES: [&str; 2] = ["shipping", "smoke"];

    /// The quality of the tables that `vellus` contains.
    pub fn shipping() -> Self {
        Quality {
            nodes: [24, 16, 16, 18],
            directions: 720,
            photons: 200_000,
            ranks: [40, 16, 32],
            sweeps: 2000,
            path_stride: 3,
            seed: 2017,
            exits: ExitQuality::shipping(),
        }
    }

    /// A coarse quality, fast enough for tests.
    pub fn smoke() -> Self {
        Quality {
            nodes: [10, 7, 8, 12],
            directions: 180,
            photons: 10_000,
            ranks: [24, 16, 24],
            sweeps: 60,
            path_stride: 3,
            seed: 2017,
            exits: ExitQuality::smoke(),
        }
    }

    /// All pieces of the simulation. They are independent of each other and reproducible.
    pub fn slabs(&self) -> Vec<Slab> {
        let kinds = [SlabKind::Azimuthal, SlabKind::Longitudinal];
        kinds.into_iter().flat_map(|kind| (0..self.nodes[0]).map(move |tau| Slab { kind, tau })).collect()
    }

    fn theta_nodes(&self) -> usize {
        self.directions / 2 + 1
    }

    /// Number of values of a profile.
    fn profile_len(&self, kind: SlabKind) -> usize {
        match kind {
            SlabKind::Azimuthal => self.directions + 1,
            SlabKind::Longitudinal => 2 * self.theta_nodes(),
        }
    }

    fn third(&self, kind: SlabKind) -> usize {
        match kind {
            SlabKind::Azimuthal => self.nodes[2],
            SlabKind::Longitudinal => self.nodes[3],
        }
    }

    /// Number of values that [`Quality::simulate`] returns for `slab`.
    pub fn slab_len(&self, slab: Slab) -> usize {
        self.nodes[1] * self.third(slab.kind) * self.profile_len(slab.kind)
    }

    /// Simulates one slab on all threads. The result does not depend on the number of threads.
    pub fn simulate(&self, slab: Slab) -> Vec<f32> {
        let position = |i: usize, n: usize| i as f64 / (n - 1) as f64;
        let tau = grid::tau_at(position(slab.tau, self.nodes[0]));
        let third = self.third(slab.kind);
        (0..self.nodes[1] * third)
            .into_par_iter()
            .flat_map_iter(|i| {
                let g = grid::g_at(position(i / third, self.nodes[1]));
                let last = position(i % third, third);
                let number = ((slab.kind as u64) << 32) + ((slab.tau as u64) << 20) + i as u64;
                let mut rng = stream(self.seed, number);
                let profile: Vec<f32> = match slab.kind {
                    SlabKind::Azimuthal => {
                        let p = azimuthal(tau, g, grid::offset_at(last), self.photons, self.directions, &mut rng);
                        p.density.into_iter().chain([p.mean_path]).map(|x| x as f32).collect()
                    }
                    SlabKind::Longitudinal => {
                        let theta = grid::theta_at(last);
                        let p = longitudinal(tau, g, theta, self.photons, self.theta_nodes(), &mut rng);
                        p.density.into_iter().flatten().map(|x| x as f32).collect()
                    }
                };
                profile
            })
            .collect()
    }

    /// Compresses the simulated slabs, which must be in the order of [`Quality::slabs`]. `progress` gets reports, but
    /// does not stop the work.
    pub fn assemble(&self, slabs: &[Vec<f32>], progress: &dyn Progress) -> TableData {
        let steps = Steps::new(progress, 3 * self.sweeps as u64, "compressing");
        let (azimuthal, longitudinal) = slabs.split_at(self.nodes[0]);
        let azimuthal = azimuthal.concat();
        let longitudinal = longitudinal.concat();
        let run = |(problem, rank, seed): (Problem, usize, u64)| {
            compress(&problem, rank, self.sweeps, self.seed.wrapping_add(seed), &steps)
        };
        let tables: Vec<FactorTable> = [
            (self.azimuthal_problem(&azimuthal), self.ranks[0], 1),
            (self.longitudinal_problem(&longitudinal, 0), self.ranks[1], 2),
            (self.longitudinal_problem(&longitudinal, 1), self.ranks[2], 3),
        ]
        .into_par_iter()
        .map(run)
        .collect();
        let [mut azimuthal_table, backward, forward]: [FactorTable; 3] = tables.try_into().expect("three tables");
        close_circle(&mut azimuthal_table);

        let [n_tau, n_g, n_h, _] = self.nodes;
        let stride = self.path_stride;
        assert!((n_g - 1).is_multiple_of(stride), "the last node must be kept");
        let mut mean_path = Vec::new();
        for tau in 0..n_tau {
            for g in (0..n_g).step_by(stride) {
                for h in 0..n_h {
                    let profile = (tau * n_g + g) * n_h + h;
                    mean_path.push(azimuthal[profile * (self.directions + 1) + self.directions]);
                }
            }
        }
        TableData {
            azimuthal: azimuthal_table,
            backward,
            forward,
            mean_path,
            mean_path_nodes: [n_tau, n_g.div_ceil(stride), n_h],
        }
    }

    fn azimuthal_problem(&self, slabs: &[f32]) -> Problem {
        let n = self.directions;
        let rows = slabs.len() / (n + 1);
        Problem {
            nodes: [self.nodes[0], self.nodes[1], self.nodes[2]],
            values: Array2::from_shape_fn((rows, n), |(i, j)| slabs[i * (n + 1) + j]),
            weights: Array2::ones((self.nodes[2], n)),
        }
    }

    /// The axis of half 0 is θᵢ. The axis of half 1 is δ = θᵢ + θ_o. It is longer, with the same step, and each profile
    /// fills a part of it.
    fn longitudinal_problem(&self, slabs: &[f32], half: usize) -> Problem {
        let n = self.theta_nodes();
        let third = self.nodes[3];
        let rows = slabs.len() / (2 * n);
        let borders = longitudinal_borders(n);
        let step = std::f64::consts::PI / (n - 1) as f64;
        let axis = if half == 0 { grid::OutgoingAxis::BACKWARD } else { grid::OutgoingAxis::FORWARD };
        let outgoing = ((axis.last - axis.first) / step).round() as usize + 1;
        let shift = |i: usize| {
            let theta = grid::theta_at(i as f64 / (third - 1) as f64);
            if half == 0 { 0.0 } else { theta / step }
        };
        // If θ_o is not a multiple of the step, profiles are shifted by linear interpolation.
        let source = |i: usize, j: usize| j as f64 - shift(i);
        Problem {
            nodes: [self.nodes[0], self.nodes[1], third],
            values: Array2::from_shape_fn((rows, outgoing), |(i, j)| {
                let x = source(i % third, j);
                if x < -1e-6 || x > (n - 1) as f64 + 1e-6 {
                    return 0.0;
                }
                let k = (x.max(0.0) as usize).min(n - 2);
                let t = (x - k as f64) as f32;
                let profile = &slabs[(2 * i + half) * n..][..n];
                profile[k] + t * (profile[k + 1] - profile[k])
            }),
            weights: Array2::from_shape_fn((third, outgoing), |(i, j)| {
                let x = source(i, j);
                if x < -1e-6 || x > (n - 1) as f64 + 1e-6 {
                    return 0.0;
                }
                let k = x.round() as usize;
                // Relative to the largest weight. A weight of 0 at the poles would leave components unconstrained
                // there, and a larger floor would reduce accuracy elsewhere.
                let floor = [0.03, 0.1][half];
                ((borders[k + 1] - borders[k]) / step).max(floor) as f32
            }),
        }
    }
}

impl FromStr for Quality {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        match name {
            "shipping" => Ok(Quality::shipping()),
            "smoke" => Ok(Quality::smoke()),
            _ => Err(format!("expected {}", Quality::NAMES.join(" or "))),
        }
    }
}

/// One piece of the simulation: all profiles with the same τ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slab {
    /// The table that it belongs to.
    pub kind: SlabKind,
    /// Index of the node of τ.
    pub tau: usize,
}

/// The table that a slab belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlabKind {
    /// C^N and ⟨L⟩.
    Azimuthal,
    /// C^M, both halves.
    Longitudinal,
}

/// Repeats the first azimuth after the last, and scales every component to integral 1. The factor over τ gets the
/// scale.
fn close_circle(table: &mut FactorTable) {
    let rank = table.rank;
    let first = table.factors[3][..rank].to_vec();
    let n = table.factors[3].len() / rank;
    for r in 0..rank {
        let mean: f32 = table.factors[3].iter().skip(r).step_by(rank).sum::<f32>() / n as f32;
        let integral = mean * std::f32::consts::TAU;
        table.factors[3].iter_mut().skip(r).step_by(rank).for_each(|x| *x /= integral);
        table.factors[0].iter_mut().skip(r).step_by(rank).for_each(|x| *x *= integral);
    }
    let first = first.iter().enumerate().map(|(r, _)| table.factors[3][r]).collect::<Vec<_>>();
    table.factors[3].extend(first);
}
