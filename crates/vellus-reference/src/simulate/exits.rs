//! The table of first exits: in which state light that the medulla scattered leaves it, and how much of it absorption
//! leaves, by τ, g, and the entry.
//!
//! For each τ and g, photons enter at random offsets and inclinations. A least-squares fit over the entry then gives
//! the probability of each state as a polynomial. The probabilities sum to exactly 1, because the polynomials contain
//! the constant.

use crate::simulate::medulla::{SimRng, stream, trace, uniform2};
use rayon::prelude::*;
use vellus::grid;
use vellus::parts::{
    ABSORPTIONS, ENTRIES, ExitData, MAX_SIN2, NODES, REACHES, ROWS, STATES, TAU_STEP, absorption_at, monomials, state,
};
use vellus_io::{Progress, Steps};

/// Resolution and effort of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct ExitQuality {
    /// Nodes of τ, [`TAU_STEP`] apart in [`grid::tau_position`], and of g, equidistant in [`grid::g_position`].
    pub nodes: [usize; 2],
    /// Photons for each τ and g.
    pub photons: u64,
}

impl ExitQuality {
    /// The quality of the table that `vellus` contains.
    pub fn shipping() -> Self {
        ExitQuality { nodes: [17, 8], photons: 1_000_000 }
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
        let nodes = (0..taus * gs).into_par_iter().map(|i| {
            let tau = grid::tau_at((i / gs) as f64 * TAU_STEP);
            let g = grid::g_at(position(i % gs, gs));
            let rows = first_exits(tau, g, self.photons, &mut stream(seed, (7 << 32) + i as u64));
            let turns = turns(tau, g, self.photons, &mut stream(seed, (8 << 32) + i as u64));
            steps.advance(1);
            (rows, turns)
        });
        let (rows, turns): (Vec<_>, Vec<_>) = nodes.unzip();
        let values = rows.into_iter().flatten().flatten().map(|x| x as f32).collect();
        let turns = turns.into_iter().flatten().flatten().map(|x| x as f32).collect();
        ExitData { nodes: self.nodes, values, turns }
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

/// The least-squares fit to the offset at which light leaves, for each of [`REACHES`]: see [`ExitData::turns`]. Light
/// enters in the normal plane at random offsets.
///
/// `tau` is the optical radius of the medulla, at least 0, and `g` the anisotropy in (−1, 1).
pub fn turns(tau: f64, g: f64, photons: u64, rng: &mut SimRng) -> [[f64; 3]; REACHES.len()] {
    let mut systems = [([[0.0; 3]; 3], [0.0; 3]); REACHES.len()];
    for k in 0..photons {
        let h = (k as f64 + f64::from(uniform2(rng).0)) / photons as f64;
        let (exit, _) = trace(tau as f32, g as f32, h as f32, (0.0, 1.0), rng);
        // Straight on is azimuth π, and light that goes straight on has h‴ = h″.
        let ([_, y, z], offset) = (exit.direction.map(f64::from), exit.signed_offset());
        let length = y.hypot(z).max(1e-20);
        let basis = [h, -h * y / length, -(1.0 - h * h) * z / length];
        for ((matrix, side), reach) in systems.iter_mut().zip(REACHES) {
            if offset.abs() <= reach {
                for i in 0..3 {
                    (0..3).for_each(|j| matrix[i][j] += basis[i] * basis[j]);
                    side[i] += basis[i] * offset;
                }
            }
        }
    }
    systems.map(|(matrix, side)| solve(matrix, side))
}

/// Solves a symmetric, positive definite system by Gaussian elimination.
fn solve<const N: usize>(mut a: [[f64; N]; N], mut b: [f64; N]) -> [f64; N] {
    for i in 0..N {
        for k in i + 1..N {
            let factor = a[k][i] / a[i][i];
            for j in i..N {
                a[k][j] -= factor * a[i][j];
            }
            b[k] -= factor * b[i];
        }
    }
    for i in (0..N).rev() {
        let known: f64 = (i + 1..N).map(|j| a[i][j] * b[j]).sum();
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
