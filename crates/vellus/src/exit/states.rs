//! The states of light that leaves the medulla: cells of inclination and offset.
//!
//! Light that the medulla scattered meets the cuticle at sin γ = κ h″ ≤ κ, so it meets the medulla again after a
//! reflection. It is described by |θ′| and |h″|, its offset in radii of the medulla.

use crate::exit::table::{ENTRIES, MAX_SIN2, monomials};
use std::f64::consts::FRAC_PI_2;
use wide::f32x8;

/// Cells of |θ′|, of 15° each.
pub const INCLINATIONS: usize = 6;
/// Cells of |h″|, of 1/4 each.
pub const OFFSETS: usize = 4;
/// All cells; the offset is the faster index.
pub const STATES: usize = INCLINATIONS * OFFSETS;
/// Registers of eight states.
pub(crate) const REGISTERS: usize = STATES / 8;

/// One number for each state.
pub(crate) type Vector = [f32x8; REGISTERS];

/// The state of light at the inclination θ′, radians, and the offset h″ in radii of the medulla. Signs are ignored.
#[cfg(any(test, feature = "unstable"))]
pub fn state(theta: f64, h: f64) -> usize {
    let cell = |x: f64, n: usize| ((x * n as f64) as usize).min(n - 1);
    cell(theta.abs() / FRAC_PI_2, INCLINATIONS) * OFFSETS + cell(h.abs(), OFFSETS)
}

/// The cell of a state: the ends of |θ′| in radians, and of |h″|.
pub fn cell(state: usize) -> [[f64; 2]; 2] {
    let ends = |i: usize, n: usize| [i as f64 / n as f64, (i + 1) as f64 / n as f64];
    [ends(state / OFFSETS, INCLINATIONS).map(|x| x * FRAC_PI_2), ends(state % OFFSETS, OFFSETS)]
}

/// Means over each cell, weighted by cos²θ′: the distribution of diffuse light that leaves a cylinder.
#[derive(Clone, Debug)]
pub(crate) struct Geometry {
    /// The share of diffuse light.
    pub weight: Vector,
    /// 1/cos θ′.
    pub elongation: Vector,
    /// √(1 − h″²): half of the chord through the medulla, in the normal plane.
    pub half_chord: Vector,
    /// The length of the chord, in radii of the medulla.
    pub chord: Vector,
    /// h″² in the middle of the cell.
    pub square: Vector,
    /// [`monomials`] of the entry in this state.
    pub monomials: [Vector; ENTRIES],
}

impl Geometry {
    pub fn new() -> Self {
        let all: [[f64; 4]; STATES] = std::array::from_fn(|state| {
            let [[a, b], [low, high]] = cell(state);
            let squared = |x: f64| 0.5 * x + 0.25 * (2.0 * x).sin();
            let weight = squared(b) - squared(a);
            let segment = |h: f64| 0.5 * (h.asin() + h * (1.0 - h * h).sqrt());
            let half_chord = (segment(high) - segment(low)) / (high - low);
            // The squares of cosines over a quarter of the circle integrate to π/4.
            let share = weight / (0.25 * std::f64::consts::PI * OFFSETS as f64);
            [share, (b.sin() - a.sin()) / weight, half_chord, (0.5 * (low + high)).powi(2)]
        });
        let entries: [[f64; ENTRIES]; STATES] = std::array::from_fn(mean_monomials);
        let vector = |f: &dyn Fn(&[f64; 4]) -> f64| pack(|state| f(&all[state]) as f32);
        Geometry {
            weight: vector(&|x| x[0]),
            elongation: vector(&|x| x[1]),
            half_chord: vector(&|x| x[2]),
            chord: vector(&|x| 2.0 * x[1] * x[2]),
            square: vector(&|x| x[3]),
            monomials: std::array::from_fn(|m| pack(|state| entries[state][m] as f32)),
        }
    }
}

/// The means of [`monomials`] over a state.
fn mean_monomials(state: usize) -> [f64; ENTRIES] {
    const POINTS: usize = 16;
    let [theta, h] = cell(state);
    let at = |[a, b]: [f64; 2], k: usize| a + (b - a) * (k as f64 + 0.5) / POINTS as f64;
    let (mut sums, mut weights) = ([0.0; ENTRIES], 0.0);
    for k in 0..POINTS * POINTS {
        let (theta, h) = (at(theta, k / POINTS), at(h, k % POINTS));
        let weight = theta.cos().powi(2);
        let values = monomials((1.0 - h * h).sqrt(), theta.sin().powi(2) / MAX_SIN2);
        sums.iter_mut().zip(values).for_each(|(sum, x)| *sum += weight * x);
        weights += weight;
    }
    sums.map(|sum| sum / weights)
}

/// A number for each state.
pub(crate) fn pack(f: impl Fn(usize) -> f32) -> Vector {
    std::array::from_fn(|r| f32x8::new(std::array::from_fn(|i| f(8 * r + i))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_contain_their_states_and_weights_sum_to_one() {
        for i in 0..STATES {
            let [theta, h] = cell(i).map(|[a, b]| 0.5 * (a + b));
            assert_eq!(state(-theta, h), i);
        }
        assert_eq!(state(FRAC_PI_2, 1.0), STATES - 1);
        let geometry = Geometry::new();
        let sum: f32 = geometry.weight.iter().map(|w| w.reduce_add()).sum();
        assert!((sum - 1.0).abs() < 1e-6);
        // The mean chord of diffuse light is 4 V/S = 2. The mean of a product differs from the product of means, but
        // inclination and offset are independent.
        let chord: f32 = (0..REGISTERS).map(|r| (geometry.weight[r] * geometry.chord[r]).reduce_add()).sum();
        assert!((chord - 2.0).abs() < 1e-5, "{chord}");
    }
}
