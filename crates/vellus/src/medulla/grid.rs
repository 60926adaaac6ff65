//! The positions of the nodes of the medulla tables. The simulation and the query share them.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Largest optical radius τ of the tables. Above it the scattered lobes keep their shape, because all light leaves
/// within a few mean free paths of its entry.
pub const TAU_MAX: f64 = 20.0;

/// Largest anisotropy of the tables.
pub const G_MAX: f64 = 0.95;

/// Largest inclination of a node. Beyond it the forward lobe only shifts.
pub const THETA_MAX: f64 = 85.0 * PI / 180.0;

/// Nodes of the half angle of the cone of light that leaves (D18), from that of the largest η to 90°: 1.5° apart.
pub const CONES: usize = 48;

/// Nodes of the shift in the cone, θ_t over its half angle: 0.3° to 1.4° apart.
pub const SHIFTS: usize = 65;

/// The largest η of a cone.
pub const MOST_ETA: f32 = 3.0;

/// Exponential spacing in τ: with 24 nodes the first step is 0.015 and the last 4.6.
pub const TAU_GROWTH: f64 = 6.0;

/// The k of position(τ) = ln(1 + kτ)/growth.
pub const TAU_SCALE: f64 = 402.428_793_492_735_1 / TAU_MAX;

/// Position of τ in [0, 1] along its axis, dense near 0.
pub fn tau_position(tau: f64) -> f64 {
    (tau * TAU_SCALE).ln_1p() / TAU_GROWTH
}

/// Inverse of [`tau_position`].
pub fn tau_at(position: f64) -> f64 {
    (position * TAU_GROWTH).exp_m1() / TAU_SCALE
}

/// Position of g in [0, 1]: logarithmic in 1 − g, the width of the forward peak.
pub fn g_position(g: f64) -> f64 {
    (-g).ln_1p() / (-G_MAX).ln_1p()
}

/// Inverse of [`g_position`].
pub fn g_at(position: f64) -> f64 {
    -(position * (-G_MAX).ln_1p()).exp_m1()
}

/// Position of the offset h″ ≥ 0 in [0, 1]: linear in its angle.
pub fn offset_position(h: f64) -> f64 {
    h.clamp(0.0, 1.0).asin() / FRAC_PI_2
}

/// Inverse of [`offset_position`].
pub fn offset_at(position: f64) -> f64 {
    (position * FRAC_PI_2).sin()
}

/// Below this angle asin h″ a part of C^N is mirrored, see [`mirrored_share`]. The second constant is its inverse in
/// single precision.
pub(crate) const MIRROR_REACH: f64 = PI / 360.0;
pub(crate) const MIRROR_REACH_INVERSE: f32 = (1.0 / MIRROR_REACH) as f32;

/// The share of C^N that is mirrored, φ → −φ, at an offset h″ ≥ 0.
///
/// C^N is symmetric at h″ = 0, but the compressed tables are symmetric only to a few hundredths. Half of the profile
/// is mirrored at h″ = 0, and less up to 0.5°. C^N is then symmetric and continuous where h″ changes its sign.
pub fn mirrored_share(h: f64) -> f64 {
    let x = (h.clamp(0.0, 1.0).asin() / MIRROR_REACH).min(1.0);
    0.5 * (1.0 - x) * (1.0 - x)
}

/// Position of an inclination θ ≥ 0 in [0, 1].
pub fn theta_position(theta: f64) -> f64 {
    theta / THETA_MAX
}

/// Inverse of [`theta_position`].
pub fn theta_at(position: f64) -> f64 {
    position * THETA_MAX
}

/// An axis of outgoing angle: `nodes` equidistant nodes from `first`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutgoingAxis {
    /// Angle of the first node, radians.
    pub first: f64,
    /// Angle of the last node, radians.
    pub last: f64,
}

impl OutgoingAxis {
    /// The exit azimuth over the whole circle. The first and the last node are the same direction.
    pub const AZIMUTH: OutgoingAxis = OutgoingAxis { first: 0.0, last: TAU };
    /// θᵢ of the backward half.
    pub const BACKWARD: OutgoingAxis = OutgoingAxis { first: -FRAC_PI_2, last: FRAC_PI_2 };
    /// D13: δ = θᵢ + θ_o of the forward half. Its peak is at δ = 0 for every θ_o, so the table has a low rank.
    pub const FORWARD: OutgoingAxis = OutgoingAxis { first: -FRAC_PI_2, last: PI };

    /// The distance between neighbouring nodes, for `nodes` nodes.
    pub fn step(&self, nodes: usize) -> f64 {
        (self.last - self.first) / (nodes - 1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_and_values_are_inverse() {
        for i in 0..=20 {
            let p = f64::from(i) / 20.0;
            assert!((tau_position(tau_at(p)) - p).abs() < 1e-12);
            assert!((g_position(g_at(p)) - p).abs() < 1e-12);
            assert!((offset_position(offset_at(p)) - p).abs() < 1e-7);
            assert!((theta_position(theta_at(p)) - p).abs() < 1e-12);
        }
        assert!((tau_at(1.0) - TAU_MAX).abs() < 1e-12 && (g_at(1.0) - G_MAX).abs() < 1e-12);
    }
}
