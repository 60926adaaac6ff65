//! The medulla's tables, interpolated in f64.

use std::f64::consts::{FRAC_PI_2, PI};
use vellus::grid::{self, OutgoingAxis};
use vellus::{FactorTable, TableData};

/// ⟨L⟩(τ, g, h″), the mean path of scattered light inside the medulla in units of its radius, by trilinear
/// interpolation of the table (D7). `tau` ≥ 0, `g` in [0, 0.95], `h` in [0, 1].
pub fn mean_path(tables: &TableData, tau: f64, g: f64, h: f64) -> f64 {
    let n = tables.mean_path_nodes;
    let [tau, g, h] = [grid::tau_position(tau), grid::g_position(g), grid::offset_position(h)];
    let corners = [between(tau, n[0]), between(g, n[1]), between(h, n[2])];
    let mut sum = 0.0;
    for corner in 0..8usize {
        let mut weight = 1.0;
        let mut index = 0;
        for axis in 0..3 {
            let (i, t) = corners[axis];
            let upper = corner >> axis & 1;
            weight *= if upper == 1 { t } else { 1.0 - t };
            index = index * n[axis] + i + upper;
        }
        sum += weight * f64::from(tables.mean_path[index]);
    }
    sum
}

fn between(position: f64, nodes: usize) -> (usize, f64) {
    let x = (position * (nodes - 1) as f64).clamp(0.0, (nodes - 1) as f64);
    let i = (x as usize).min(nodes - 2);
    (i, x - i as f64)
}

/// One scattering profile of the medulla, interpolated from the tables and normalised to integral 1.
#[derive(Clone, Debug)]
pub struct Profile {
    axis: OutgoingAxis,
    /// Added to the angle to find the position on the axis.
    shift: f64,
    values: Vec<f64>,
}

impl Profile {
    /// C^N(τ, g, h″, ·) for `h` = h″ in [0, 1]: a density per radian of the azimuth φ in [0, 2π] from straight back.
    pub fn azimuthal(tables: &TableData, tau: f64, g: f64, h: f64) -> Self {
        let position = [grid::tau_position(tau), grid::g_position(g), grid::offset_position(h)];
        let mut profile = Profile::new(&tables.azimuthal, position, OutgoingAxis::AZIMUTH, 0.0, |_| 1.0);
        let share = grid::mirrored_share(h);
        if share > 0.0 {
            let mirrored: Vec<f64> = profile.values.iter().rev().copied().collect();
            profile.values.iter_mut().zip(mirrored).for_each(|(x, m)| *x += share * (m - *x));
        }
        profile
    }

    /// C^M(τ, g, θ_o, ·) of the backward and the forward half, for `theta_o` in [0, π/2): densities in sin θᵢ, with
    /// the argument θᵢ in radians.
    pub fn longitudinal(tables: &TableData, tau: f64, g: f64, theta_o: f64) -> [Self; 2] {
        let position = [grid::tau_position(tau), grid::g_position(g), grid::theta_position(theta_o)];
        let measure = |theta: f64| {
            if theta.abs() < FRAC_PI_2 { theta.cos() } else { 0.0 }
        };
        [
            Profile::new(&tables.backward, position, OutgoingAxis::BACKWARD, 0.0, measure),
            Profile::new(&tables.forward, position, OutgoingAxis::FORWARD, theta_o, measure),
        ]
    }

    fn new(
        table: &FactorTable,
        position: [f64; 3],
        axis: OutgoingAxis,
        shift: f64,
        measure: impl Fn(f64) -> f64,
    ) -> Self {
        let rank = table.rank;
        let factor = |mode: usize, r: usize| {
            let values = &table.factors[mode];
            let (i, t) = between(position[mode], values.len() / rank);
            (1.0 - t) * f64::from(values[i * rank + r]) + t * f64::from(values[(i + 1) * rank + r])
        };
        let weights: Vec<f64> = (0..rank).map(|r| factor(0, r) * factor(1, r) * factor(2, r)).collect();
        let values: Vec<f64> = table.factors[3]
            .chunks_exact(rank)
            .map(|row| row.iter().zip(&weights).map(|(b, w)| f64::from(*b) * w).sum())
            .collect();
        let mut profile = Profile { axis, shift, values };
        let integral = profile.integral(measure);
        profile.values.iter_mut().for_each(|x| *x /= integral);
        profile
    }

    /// The integral with a weight, by the midpoint rule with 16 points an interval.
    fn integral(&self, weight: impl Fn(f64) -> f64) -> f64 {
        let intervals = 16 * (self.values.len() - 1);
        let step = (self.axis.last - self.axis.first) / intervals as f64;
        (0..intervals)
            .map(|k| self.axis.first + (k as f64 + 0.5) * step - self.shift)
            .map(|x| self.eval(x) * weight(x) * step)
            .sum()
    }

    /// C^N divided by the light that leaves. `leaving` are the shares of the backward and the forward half of C^M that
    /// leave the fibre. The weight of the forward half is |φ|/π, for φ in [−π, π] from straight back.
    pub(crate) fn over_leaving(mut self, [back, front]: [f64; 2]) -> Self {
        let all = self.integral(|phi| {
            let weight = 1.0 - (phi / PI - 1.0).abs();
            (1.0 - weight) * back + weight * front
        });
        self.values.iter_mut().for_each(|x| *x /= all.max(f64::MIN_POSITIVE));
        self
    }

    /// The density at an angle in radians, within the range of its axis.
    pub fn eval(&self, angle: f64) -> f64 {
        let x = angle + self.shift - self.axis.first;
        let (i, t) = between(x / (self.axis.last - self.axis.first), self.values.len());
        (1.0 - t) * self.values[i] + t * self.values[i + 1]
    }
}
