//! From simulation to table file: which profiles are simulated, at what quality, and how they
//! become [`TableData`].

use crate::compress::{Problem, compress};
use crate::medulla::{azimuthal, longitudinal, longitudinal_borders, stream};
use ndarray::Array2;
use rayon::prelude::*;
use vellus::{FactorTable, TableData, grid};

/// How much work goes into the tables.
#[derive(Clone, Debug, PartialEq)]
pub struct Quality {
    /// Nodes of τ, g, h″ and θ_o.
    pub nodes: [usize; 4],
    /// Exit azimuths over the circle, a multiple of 4; the longitudinal halves have half as many
    /// steps over θᵢ, each.
    pub directions: usize,
    /// Photons a profile.
    pub photons: u64,
    /// Components of the azimuthal, backward and forward mixtures.
    pub ranks: [usize; 3],
    /// Sweeps of the compression.
    pub sweeps: usize,
    /// Stride of the mean path's nodes in g among the profiles', from the first to the last.
    pub path_stride: usize,
    /// Seed of everything.
    pub seed: u64,
}

impl Quality {
    /// What the crate ships.
    pub fn shipping() -> Self {
        Quality {
            nodes: [24, 16, 16, 18],
            directions: 720,
            photons: 200_000,
            ranks: [40, 16, 32],
            sweeps: 2000,
            path_stride: 3,
            seed: 2017,
        }
    }

    /// Small enough for a test: coarse in every direction.
    pub fn smoke() -> Self {
        Quality {
            nodes: [10, 7, 8, 12],
            directions: 180,
            photons: 10_000,
            ranks: [24, 16, 24],
            sweeps: 60,
            path_stride: 3,
            seed: 2017,
        }
    }

    /// All pieces of the simulation; any order, any time, each the same every time.
    pub fn slabs(&self) -> Vec<Slab> {
        let kinds = [SlabKind::Azimuthal, SlabKind::Longitudinal];
        kinds.into_iter().flat_map(|kind| (0..self.nodes[0]).map(move |tau| Slab { kind, tau })).collect()
    }

    fn theta_nodes(&self) -> usize {
        self.directions / 2 + 1
    }

    /// Numbers a profile of that kind has.
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

    /// Numbers [`Quality::simulate`] returns for `slab`.
    pub fn slab_len(&self, slab: Slab) -> usize {
        self.nodes[1] * self.third(slab.kind) * self.profile_len(slab.kind)
    }

    /// Simulates one slab on all threads; the result does not depend on their number.
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

    /// Steps of [`Quality::assemble`] that `tick` counts.
    pub fn assembly_steps(&self) -> usize {
        3 * self.sweeps
    }

    /// Compresses the simulated slabs, in the order of [`Quality::slabs`].
    pub fn assemble(&self, slabs: &[Vec<f32>], tick: &(dyn Fn() + Sync)) -> TableData {
        let (azimuthal, longitudinal) = slabs.split_at(self.nodes[0]);
        let azimuthal = azimuthal.concat();
        let longitudinal = longitudinal.concat();
        let run = |(problem, rank, seed): (Problem, usize, u64)| {
            compress(&problem, rank, self.sweeps, self.seed.wrapping_add(seed), &|| tick())
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

    /// Half 0 lies over θᵢ; half 1 over δ = θᵢ + θ_o, on a longer axis of the same step, of which
    /// each profile fills a part.
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
        // Where θ_o is not a whole number of steps, profiles are moved by linear interpolation.
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
                // In units of the largest, so that weights are of order 1. Not quite 0 at the poles, where a
                // component would otherwise be free to take any value; more would cost accuracy elsewhere.
                let floor = [0.03, 0.1][half];
                ((borders[k + 1] - borders[k]) / step).max(floor) as f32
            }),
        }
    }
}

/// One piece of the simulation: all profiles of one τ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slab {
    /// Which table.
    pub kind: SlabKind,
    /// Node of τ.
    pub tau: usize,
}

/// Which table a slab belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlabKind {
    /// C^N and ⟨L⟩.
    Azimuthal,
    /// C^M, both halves.
    Longitudinal,
}

/// Repeats the first azimuth after the last, and scales every component to integral 1, its weight
/// going to the factor over τ.
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
