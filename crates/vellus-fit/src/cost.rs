//! The residuals of a fit: log-ratios of predicted to measured values (Yan17 Sec. 5.1, Validation).

use crate::forward::{Forward, Recent};
use crate::parameters::assemble;
use crate::profile::{Profile, Quantity};
use crate::space::Space;
use std::sync::atomic::{AtomicU64, Ordering};
use vellus_models::Directions;

/// The least value of a model. It keeps logarithms finite.
const FLOOR: f32 = 1e-30;

/// A profile or a part of it, prepared for comparisons with a model.
pub struct Cost<'a> {
    space: &'a Space,
    forward: Forward,
    recent: Recent,
    directions: Directions,
    /// For each point and channel, the number to add to ln(f·cos θ) to get a residual.
    offsets: Vec<f64>,
    channels: usize,
    /// How many values of the model were computed.
    pub evaluations: AtomicU64,
}

impl<'a> Cost<'a> {
    /// Compares with the points of a profile whose indices are `chosen`.
    pub fn new(profile: &Profile, chosen: &[usize], space: &'a Space, forward: Forward) -> Self {
        let points = || chosen.iter().map(|&i| &profile.points[i]);
        let offset = |p: &crate::profile::Point, c: usize| {
            let cosine = match profile.quantity {
                Quantity::FCos => 1.0,
                Quantity::F => p.theta.to_radians().cos(),
            };
            -(cosine * p.value[c]).ln()
        };
        Cost {
            space,
            forward,
            recent: Recent::default(),
            directions: Directions::new(&points().map(|p| [p.theta, p.phi]).collect::<Vec<_>>()),
            offsets: points().flat_map(|p| (0..profile.channels).map(|c| offset(p, c)).collect::<Vec<_>>()).collect(),
            channels: profile.channels,
            evaluations: AtomicU64::new(0),
        }
    }

    /// ln(fitted/measured) of each value, point by point and channel by channel, for the variables `u`. All are
    /// infinite if the model refuses the fibre, which does not happen within the bounds.
    pub fn residuals(&self, u: &[f64]) -> Vec<f64> {
        self.evaluations.fetch_add(self.directions.len() as u64, Ordering::Relaxed);
        let (specimen, theta_o, scale) = assemble(&self.space.parameters, &self.space.values(u));
        let mut values = vec![[0.0; 3]; self.directions.len()];
        if self.forward.values_with(&self.recent, &specimen, theta_o, &self.directions, &mut values).is_err() {
            return vec![f64::INFINITY; self.offsets.len()];
        }
        let log_scale = scale.ln();
        let fitted = values.iter().flat_map(|rgb| &rgb[..self.channels]);
        fitted.zip(&self.offsets).map(|(f, o)| f64::from(f.max(FLOOR)).ln() + log_scale + o).collect()
    }
}
