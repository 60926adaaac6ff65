//! Light of all directions in cells of azimuth and of inclination.

use std::f64::consts::{FRAC_PI_2, PI};
use vellus::glam::Vec3;
use vellus::{Scattering, direction};

/// Cells of |φ| from 0 to π, and of θᵢ from −90° to 90°: 5° each.
pub const CELLS: usize = 36;

/// Energies in cells, RGB.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// For each cell of the azimuth |φ_i − φ_o|: the light of all inclinations.
    pub azimuth: [[f64; 3]; CELLS],
    /// For each cell of the inclination θᵢ: the light of all azimuths.
    pub inclination: [[f64; 3]; CELLS],
}

impl Default for Profile {
    fn default() -> Self {
        Profile { azimuth: [[0.0; 3]; CELLS], inclination: [[0.0; 3]; CELLS] }
    }
}

impl Profile {
    /// The integrals of f·cos θᵢ over the cells, for ω_o at the azimuth 0: 4 × 4 midpoints in each.
    pub fn of(hit: &impl Scattering) -> Self {
        let mut profile = Profile::default();
        let fine = 4 * CELLS;
        let weight = |theta: f64| theta.cos() * PI / fine as f64 * 2.0 * PI / fine as f64;
        for i in 0..fine {
            let theta = (i as f64 + 0.5) / fine as f64 * PI - FRAC_PI_2;
            for j in 0..fine {
                let f = hit.eval(direction(theta, (j as f64 + 0.5) / fine as f64 * PI)).total();
                for c in 0..3 {
                    let energy = f64::from(f[c]) * weight(theta);
                    profile.azimuth[j / 4][c] += energy;
                    profile.inclination[i / 4][c] += energy;
                }
            }
        }
        profile
    }

    /// Adds light in the direction `wi`, relative to ω_o at the azimuth 0.
    pub(super) fn add(&mut self, wi: Vec3, energy: [f64; 3]) {
        let [x, y, z] = wi.to_array().map(f64::from);
        let cell = |share: f64| ((share * CELLS as f64) as usize).min(CELLS - 1);
        let azimuth = &mut self.azimuth[cell(z.abs().atan2(y) / PI)];
        azimuth.iter_mut().zip(energy).for_each(|(sum, x)| *sum += x);
        let inclination = &mut self.inclination[cell(x.atan2(y.hypot(z)) / PI + 0.5)];
        inclination.iter_mut().zip(energy).for_each(|(sum, x)| *sum += x);
    }

    /// All cells with their scale changed.
    #[must_use]
    pub(super) fn scaled(mut self, scale: f64) -> Self {
        self.azimuth.iter_mut().chain(&mut self.inclination).flatten().for_each(|x| *x *= scale);
        self
    }

    pub(super) fn sum(&mut self, other: &Profile) {
        let cells = self.azimuth.iter_mut().chain(&mut self.inclination).flatten();
        cells.zip(other.azimuth.iter().chain(&other.inclination).flatten()).for_each(|(sum, x)| *sum += x);
    }

    /// The energy of all cells, RGB.
    pub fn energy(&self) -> [f64; 3] {
        [0, 1, 2].map(|c| self.azimuth.iter().map(|rgb| rgb[c]).sum())
    }

    /// Σ |a − b| / Σ b over the cells of azimuth, and the same over those of inclination: the mean of the channels.
    pub fn difference(&self, from: &Profile) -> [f64; 2] {
        let relative = |a: &[[f64; 3]; CELLS], b: &[[f64; 3]; CELLS]| {
            let pairs = || a.iter().flatten().zip(b.iter().flatten());
            pairs().map(|(a, b)| (a - b).abs()).sum::<f64>() / pairs().map(|(_, b)| b).sum::<f64>()
        };
        [relative(&self.azimuth, &from.azimuth), relative(&self.inclination, &from.inclination)]
    }
}
