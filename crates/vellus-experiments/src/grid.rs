//! Profiles of a fibre over cells of θ and φ, by simulation and by a model.

use anyhow::Result;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};
use vellus::Fiber;
use vellus_models::{Directions, ModelKind};
use vellus_plot::sheet::DECADES;
use vellus_reference::simulate::profile::{Cells, profile};

/// θ_o, degrees.
pub const THETA_O: f64 = -30.0;

/// Errors of a profile relative to another one.
pub struct Errors {
    /// Root mean square divided by the range (Yan17 footnote 3).
    pub nrmse: f64,
    /// The same for the logarithms, in cells with light.
    pub log: f64,
}

/// Errors of `values` relative to `exact`.
pub fn errors(values: &[f64], exact: &[f64]) -> Errors {
    let largest = exact.iter().fold(0.0f64, |a, &x| a.max(x));
    let floor = largest * 10f64.powf(-DECADES);
    let pairs = || values.iter().zip(exact);
    let least = exact.iter().fold(f64::INFINITY, |a: f64, &x| a.min(x));
    let root_mean = |squares: Vec<f64>| (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt();
    let squares = pairs().map(|(a, b)| (a - b).powi(2)).collect();
    let seen: Vec<(f64, f64)> =
        pairs().filter(|(_, b)| **b > floor).map(|(a, b)| (a.max(1e-3 * floor).ln(), b.ln())).collect();
    let (low, high) = seen.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (_, x)| (a.min(*x), b.max(*x)));
    let logs = seen.iter().map(|(a, b)| (a - b).powi(2)).collect();
    Errors { nrmse: root_mean(squares) / (largest - least), log: root_mean(logs) / (high - low) }
}

/// Cells over φ from 0° to 180° and over all θ. A model is averaged over `within`² points of each cell.
#[derive(Clone, Copy)]
pub struct Grid {
    pub columns: usize,
    pub rows: usize,
    pub within: usize,
}

impl Grid {
    /// The profile of the simulated fibre.
    pub fn traced(&self, fiber: &Fiber, photons: u64, seed: u64) -> Result<Vec<f64>> {
        let middles = |n: usize, low: f64| (0..n).map(|i| low + PI * (i as f64 + 0.5) / n as f64).collect();
        let cells = Cells {
            theta: middles(self.rows, -FRAC_PI_2),
            phi: middles(self.columns, 0.0),
            size: [PI / self.rows as f64, PI / self.columns as f64],
        };
        let traced = profile(fiber, THETA_O.to_radians(), &cells, photons, seed, &())?;
        Ok(traced.into_iter().map(|rgb| rgb[0]).collect())
    }

    /// The profile of a model, averaged over the whole width.
    pub fn model(&self, fiber: &Fiber, kind: ModelKind) -> Result<Vec<f64>> {
        let middle = |i: usize, n: usize| 180.0 * (i as f64 + 0.5) / n as f64;
        let (rows, columns) = (self.rows * self.within, self.columns * self.within);
        let angles: Vec<[f64; 2]> = (0..rows)
            .flat_map(|row| (0..columns).map(move |column| [middle(row, rows) - 90.0, middle(column, columns)]))
            .collect();
        let mut values = vec![[0.0; 3]; angles.len()];
        kind.model(fiber)?.far_field(THETA_O, &Directions::new(&angles), &mut values);
        let row = |theta: f64| ((theta / PI + 0.5) * rows as f64) as usize;
        let column = |phi: f64| (phi / PI * columns as f64) as usize;
        Ok(self.mean(|theta, phi| f64::from(values[row(theta) * columns + column(phi)][0])))
    }

    /// Means over the cells, weighted by solid angle.
    pub fn mean(&self, value: impl Fn(f64, f64) -> f64 + Sync) -> Vec<f64> {
        let n = self.within;
        (0..self.rows * self.columns)
            .into_par_iter()
            .map(|i| {
                let (row, column) = (i / self.columns, i % self.columns);
                let (mut sum, mut weight) = (0.0, 0.0);
                for a in 0..n {
                    let theta = ((row * n + a) as f64 + 0.5) / (self.rows * n) as f64 * PI - FRAC_PI_2;
                    for b in 0..n {
                        let phi = ((column * n + b) as f64 + 0.5) / (self.columns * n) as f64 * PI;
                        sum += theta.cos() * value(theta, phi);
                        weight += theta.cos();
                    }
                }
                sum / weight
            })
            .collect()
    }
}
