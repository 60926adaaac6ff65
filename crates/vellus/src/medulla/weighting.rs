//! The share of the medulla's scattered light that remains after a weight w that depends on the inclination, such as
//! the transmittance of an interface: ∫ C^M(θᵢ) w(θᵢ) cos θᵢ dθᵢ, for a fixed w.

use crate::medulla::grid::OutgoingAxis;
use crate::medulla::mixture::{Between, Rows, Weights};
use crate::medulla::tables::{AZIMUTHAL, BACKWARD, FORWARD, Tables};
use crate::medulla::{Azimuth, Inclination};
use std::f32::consts::{FRAC_PI_2, PI};
use wide::f32x8;

/// Nodes of |θ_o|, half a degree apart. The sharpest component, 0.04 wide, is then interpolated within 0.2 %.
const SHIFTS: usize = 181;
/// Azimuths over which the components of C^N are averaged.
const AZIMUTHS: usize = 720;

/// The integrals of the components under one weight w, computed once. The integral of a mixture is then a short sum.
#[derive(Clone, Debug)]
pub struct Weighting {
    backward: Weights<BACKWARD>,
    forward: Rows<FORWARD>,
    /// Mean of |φ|/π over each component of C^N: the share of the forward half.
    turn: Weights<AZIMUTHAL>,
}

impl Weighting {
    /// Computes the integrals by a quadrature rule: pairs of a node θᵢ (radians) and a weight w(θᵢ) cos θᵢ dθᵢ,
    /// symmetric about 0.
    pub fn new(tables: &Tables, rule: &[(f32, f32)]) -> Self {
        let mut backward = [f32x8::ZERO; BACKWARD];
        for &(theta, weight) in rule {
            let row = tables.backward.densities.row(theta);
            (0..BACKWARD).for_each(|c| backward[c] = row[c].mul_add(f32x8::splat(weight), backward[c]));
        }
        let forward = (0..SHIFTS).map(|k| {
            let shift = k as f32 / (SHIFTS - 1) as f32 * FRAC_PI_2;
            let mut sum = [f32x8::ZERO; FORWARD];
            for &(theta, weight) in rule {
                let row = tables.forward.densities.row(theta + shift);
                (0..FORWARD).for_each(|c| sum[c] = row[c].mul_add(f32x8::splat(weight), sum[c]));
            }
            sum
        });
        let mut turn = [f32x8::ZERO; AZIMUTHAL];
        let step = OutgoingAxis::AZIMUTH.last as f32 / AZIMUTHS as f32;
        for k in 0..AZIMUTHS {
            let phi = (k as f32 + 0.5) * step;
            let row = tables.azimuthal.densities.row(phi);
            let weight = f32x8::splat((1.0 - (phi - PI).abs() / PI) * step);
            (0..AZIMUTHAL).for_each(|c| turn[c] = row[c].mul_add(weight, turn[c]));
        }
        Weighting { backward, forward: Rows::from_rows(forward.collect()), turn }
    }

    /// The integrals over the backward and the forward half of C^M.
    #[inline]
    pub fn halves(&self, s: &Inclination) -> [f32; 2] {
        let position = s.theta * ((SHIFTS - 1) as f32 / FRAC_PI_2);
        let mut sum = f32x8::ZERO;
        (0..BACKWARD).for_each(|c| sum = s.backward[c].mul_add(self.backward[c], sum));
        let forward = self.forward.dot(&s.forward, Between::new(position, SHIFTS));
        [s.scale[0] * sum.reduce_add(), s.scale[1] * forward]
    }

    /// The mean of |φ|/π under C^N: the share of the light in the forward half of C^M.
    #[inline]
    pub fn forward_share(&self, s: &Azimuth) -> f32 {
        let mut sum = f32x8::ZERO;
        (0..AZIMUTHAL).for_each(|c| sum = s.weights[c].mul_add(self.turn[c], sum));
        s.scale * sum.reduce_add()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fiber::Fiber;
    use crate::medulla::Medulla;

    /// Compared with quadrature of the medulla's lookups, for a cone and a smooth weight inside it.
    #[test]
    fn weightings_match_quadrature() {
        let fiber = Fiber { kappa: 0.7, sigma_ms: 1.9, g: 0.8, ..Fiber::hair() };
        let tables = Tables::shipped();
        let medulla = Medulla::new(&fiber, tables);
        let weight = |theta: f32| (1.0 - (theta / 0.7).powi(2)).max(0.0);
        let n = 400;
        let rule: Vec<_> = (0..n)
            .map(|k| ((k as f32 + 0.5) / n as f32 - 0.5) * 1.4)
            .map(|theta| (theta, weight(theta) * theta.cos() * 1.4 / n as f32))
            .collect();
        let weighting = Weighting::new(tables, &rule);
        for theta_o in [-0.61f32, 0.02, 0.33] {
            let inclination = medulla.inclination(theta_o);
            let mut exact = [0.0f32; 2];
            let m = 20_000;
            for k in 0..m {
                let theta = ((k as f32 + 0.5) / m as f32 - 0.5) * PI;
                let value = medulla.longitudinal(&inclination, theta);
                (0..2).for_each(|i| exact[i] += value[i] * weight(theta) * theta.cos() * PI / m as f32);
            }
            let ours = weighting.halves(&inclination);
            // Interpolation over θ_o has an error of 0.2 % for the sharpest component. The half-degree nodes and the
            // 400 points differ too.
            (0..2).for_each(|i| assert!((ours[i] - exact[i]).abs() < 2e-3, "{theta_o}: {ours:?} {exact:?}"));
        }
        let azimuth = medulla.azimuth(&medulla.pass(medulla.tau_position(1.1f32)), 0.5);
        let mean: f32 = (0..3600)
            .map(|k| ((k as f32 + 0.5) / 3600.0 - 0.5) * 2.0 * PI)
            .map(|phi| medulla.azimuthal(&azimuth, phi) * phi.abs() / PI * 2.0 * PI / 3600.0)
            .sum();
        assert!((weighting.forward_share(&azimuth) - mean).abs() < 1e-4);
    }
}
