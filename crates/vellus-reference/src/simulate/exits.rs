//! The table of first exits: in which state light that the medulla scattered leaves it, and how much of it absorption
//! leaves, by τ, g, and the entry.
//!
//! For each τ and g, photons enter at random offsets and inclinations. A least-squares fit over the entry then gives
//! the probability of each state as a polynomial. The probabilities sum to exactly 1, because the polynomials contain
//! the constant.

use crate::simulate::medulla::{SimRng, stream, trace, uniform2};
use rayon::prelude::*;
use vellus::grid;
use vellus::parts::{ABSORPTIONS, ENTRIES, ExitData, MAX_SIN2, NODES, ROWS, STATES, absorption_at, monomials, state};
use vellus_io::{Progress, Steps};

/// Resolution and effort of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct ExitQuality {
    /// Nodes of τ and of g, equidistant in [`grid::tau_position`] and [`grid::g_position`].
    pub nodes: [usize; 2],
    /// Photons for each τ and g.
    pub photons: u64,
}

impl ExitQuality {
    /// The quality of the table that `vellus` contains.
    pub fn shipping() -> Self {
        ExitQuality { nodes: [13, 8], photons: 1_000_000 }
    }

    /// A coarse quality, fast enough for tests.
    pub fn smoke() -> Self {
        ExitQuality { nodes: [5, 4], photons: 20_000 }
    }

    /// Simulates the table on all threads. The result depends on the seed, but not on the number of threads. `progress`
    /// gets reports, but does not stop the work.
    pub fn build(&self, seed: u64, progress: &dyn Progress) -> ExitData {
        let [taus, gs] = self.nodes;
        let steps = Steps::new(progress, (taus * gs) as u64, "simulating first exits");
        let position = |i: usize, n: usize| i as f64 / (n - 1) as f64;
        let values = (0..taus * gs).into_par_iter().flat_map_iter(|i| {
            let tau = grid::tau_at(position(i / gs, taus));
            let g = grid::g_at(position(i % gs, gs));
            let rows = first_exits(tau, g, self.photons, &mut stream(seed, (7 << 32) + i as u64));
            steps.advance(1);
            rows.into_iter().flatten().map(|x| x as f32)
        });
        ExitData { nodes: self.nodes, values: values.collect() }
    }
}

/// At each node of the entry: the probability of each state, and the effective path at each absorption, in radii of
/// the medulla.
///
/// `tau` is the optical radius of the medulla, at least 0, and `g` the anisotropy in (−1, 1).
pub fn first_exits(tau: f64, g: f64, photons: u64, rng: &mut SimRng) -> [[f64; ENTRIES]; ROWS] {
    // Normal equations: the matrix of the basis, and one right side for each row.
    let mut matrix = [[0.0; ENTRIES]; ENTRIES];
    let mut sides = [[0.0; ENTRIES]; STATES];
    for k in 0..photons {
        let (u, v) = uniform2(rng);
        // Offsets are stratified. Small inclinations are more frequent, because light enters a fibre at θ_t ≤ asin 1/η.
        let h = (k as f64 + f64::from(u)) / photons as f64;
        let y = f64::from(v).powi(2);
        let (c, sin2) = ((1.0 - h * h).sqrt(), MAX_SIN2 * y);
        let inclination = (sin2.sqrt() as f32, (1.0 - sin2).sqrt() as f32);
        let (exit, _) = trace(tau as f32, g as f32, h as f32, inclination, rng);
        let theta = f64::from(exit.direction[0].clamp(-1.0, 1.0)).asin();
        let basis = monomials(c, y);
        for i in 0..ENTRIES {
            (0..ENTRIES).for_each(|j| matrix[i][j] += basis[i] * basis[j]);
            sides[state(theta, f64::from(exit.offset()))][i] += basis[i];
        }
    }
    let mut rows = [[0.0; ENTRIES]; ROWS];
    for (row, side) in rows.iter_mut().zip(sides) {
        let coefficients = solve(matrix, side);
        *row = NODES.map(|[c, y]| monomials(c, y).iter().zip(coefficients).map(|(b, k)| b * k).sum());
    }
    // Polynomials cannot follow the effective path. It is simulated at the nodes themselves.
    for (node, [c, y]) in NODES.into_iter().enumerate() {
        let sin2 = MAX_SIN2 * y;
        let inclination = (sin2.sqrt() as f32, (1.0 - sin2).sqrt() as f32);
        let mut sums = [0.0; ABSORPTIONS];
        for _ in 0..photons / ENTRIES as u64 {
            let (exit, _) = trace(tau as f32, g as f32, (1.0 - c * c).sqrt() as f32, inclination, rng);
            let path = f64::from(exit.path);
            sums[0] += path;
            (1..ABSORPTIONS).for_each(|k| sums[k] += (-absorption_at(k) * path).exp());
        }
        let count = (photons / ENTRIES as u64) as f64;
        for (k, sum) in sums.into_iter().enumerate() {
            let mean = sum / count;
            rows[STATES + k][node] = if k == 0 { mean } else { -mean.max(1e-30).ln() / absorption_at(k) };
        }
    }
    rows
}

/// Solves a symmetric, positive definite system by Gaussian elimination.
fn solve(mut a: [[f64; ENTRIES]; ENTRIES], mut b: [f64; ENTRIES]) -> [f64; ENTRIES] {
    for i in 0..ENTRIES {
        for k in i + 1..ENTRIES {
            let factor = a[k][i] / a[i][i];
            for j in i..ENTRIES {
                a[k][j] -= factor * a[i][j];
            }
            b[k] -= factor * b[i];
        }
    }
    for i in (0..ENTRIES).rev() {
        let known: f64 = (i + 1..ENTRIES).map(|j| a[i][j] * b[j]).sum();
        b[i] = (b[i] - known) / a[i][i];
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light that is scattered once in a thin medulla, at h″ = 0 and θ = 0, isotropically: the share of the state is
    /// the solid angle of its inclinations, summed over offsets. The polynomial over the entry is off by a few
    /// hundredths, and the noise of a share of 0.25 in 200,000 photons near one node by 1/100.
    #[test]
    fn thin_medullas_scatter_once() {
        let rows = first_exits(1e-6, 0.0, 200_000, &mut stream(3, 1));
        for cell in 0..STATES / 4 {
            let share: f64 = rows[4 * cell..4 * cell + 4].iter().map(|row| row[2]).sum();
            let ends = [cell, cell + 1].map(|i| (i as f64 * 15f64.to_radians()).sin());
            assert!((share - (ends[1] - ends[0])).abs() < 0.04, "{cell}: {share}");
        }
        let sum: f64 = rows[..STATES].iter().map(|row| row[5]).sum();
        assert!((sum - 1.0).abs() < 1e-9);
    }
}
