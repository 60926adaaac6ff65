//! The places of the nodes of all tables.

use crate::member::{OUTGOING, inclination};
use crate::{once, orders};
use std::f32::consts::{FRAC_PI_2, PI};

/// Nodes, ascending.
#[derive(Clone, Debug)]
pub(crate) struct Grid {
    /// Azimuths of single scattering, from 0 to π.
    pub fine: Vec<f32>,
    /// Azimuths of multiple scattering, from 0 to π.
    pub coarse: Vec<f32>,
    /// sin θᵢ from −1 to 1.
    pub along: Vec<f32>,
}

impl Grid {
    /// All nodes.
    pub fn new() -> Self {
        let azimuths = |count: usize| (0..count).map(|k| k as f32 / (count - 1) as f32 * PI).collect();
        Grid {
            fine: azimuths(once::AZIMUTHS),
            coarse: azimuths(orders::AZIMUTHS),
            along: (0..OUTGOING).map(|k| inclination(k).sin() as f32).collect(),
        }
    }

    /// The node before sin θᵢ and the share of the next one.
    #[inline(always)]
    pub fn along(&self, sin: f32, theta: f32) -> (usize, f32) {
        let x = (theta + FRAC_PI_2) * ((OUTGOING - 1) as f32 / PI);
        let k = (x.max(0.0) as usize).min(OUTGOING - 2);
        let (low, high) = (self.along[k], self.along[k + 1]);
        (k, ((sin - low) / (high - low)).clamp(0.0, 1.0))
    }
}

/// The node before `x`, one of `count` equidistant nodes from 0 to `end`, and the share of the next one.
#[inline(always)]
pub(crate) fn position(x: f32, end: f32, count: usize) -> (usize, f32) {
    let x = x * ((count - 1) as f32 / end);
    let k = (x.max(0.0) as usize).min(count - 2);
    (k, (x - k as f32).clamp(0.0, 1.0))
}
