//! Does a fit follow the measurements, or would a constant do as well?

use crate::least_squares::Problem;
use crate::outcome::{Estimate, State};
use crate::profile::Profile;
use std::fmt;

/// A constant is fitted to pure noise as well as the model is. The chance that the test takes such data for a profile.
pub const FALSE_ALARM: f64 = 1e-3;

/// The normal distribution exceeds this with the probability [`FALSE_ALARM`].
const QUANTILE: f64 = 3.0902;

/// Why a fit says nothing about the fibre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoFit {
    /// A constant follows the measurements as well as the model does.
    Noise,
    /// The model follows less than half of the variation, and what it leaves is not noise.
    NotFollowed,
    /// The measurements determine no parameter of the fibre.
    Undetermined,
}

impl fmt::Display for NoFit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            NoFit::Noise => "the model follows the measurements no better than a constant does: they are noise to it",
            NoFit::NotFollowed => {
                "the model follows less than half of the variation of the measurements, and what it leaves is not noise"
            }
            NoFit::Undetermined => "the measurements determine no parameter of the fibre",
        })
    }
}

/// A model that follows less than this share of the variation is not a model of it.
const LEAST: f64 = 0.5;

/// Standard errors widened by more than this are of residuals that are not noise: of 1000 fits of a model to its own measurements none is.
const NOISE_LIKE: f64 = 1.3;

/// Judges a fit; `estimates` are those of the fibre's parameters.
pub(crate) fn judge<'a>(
    explained: &Explained,
    widened: f64,
    estimates: impl Iterator<Item = &'a Estimate> + Clone,
) -> Option<NoFit> {
    let mut fitted = estimates.filter(|e| matches!(e.state, State::Fitted | State::AtBound)).peekable();
    if explained.significance.is_nan() || explained.significance < QUANTILE {
        Some(NoFit::Noise)
    } else if explained.share < LEAST && widened > NOISE_LIKE {
        Some(NoFit::NotFollowed)
    } else if fitted.peek().is_some() && !fitted.any(|e| e.determined || e.state == State::AtBound) {
        Some(NoFit::Undetermined)
    } else {
        None
    }
}

/// How much better a fit is than a constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Explained {
    /// Share of the constant's loss that the model removes: 1 for a perfect fit, 0 for one that is as bad as a constant. Without
    /// outliers it is R² of the logarithms.
    pub share: f64,
    /// The F-test of the model against a constant as a normal deviate. It is below 3.09 in all but one of 1000 profiles
    /// of pure noise.
    pub significance: f64,
}

/// Compares residuals with those of the best constant of each channel. `variables` were fitted.
pub fn explained(problem: &Problem, profile: &Profile, residuals: &[f64], noise: f64, variables: usize) -> Explained {
    let constant: f64 = (0..profile.channels)
        .map(|c| constant_loss(problem, profile.points.iter().map(|p| p.value[c].ln()).collect(), noise))
        .sum();
    let fitted = problem.loss(residuals, noise);
    let more = variables.saturating_sub(profile.channels).max(1) as f64;
    let left = residuals.len().saturating_sub(variables).max(1) as f64;
    let ratio = (constant - fitted) / more / (fitted / left);
    Explained { share: 1.0 - fitted / constant, significance: deviate(ratio, more, left) }
}

/// The least loss of values that one constant is fitted to. The loss is convex: the weighted mean converges to its minimum.
fn constant_loss(problem: &Problem, mut values: Vec<f64>, noise: f64) -> f64 {
    for _ in 0..50 {
        let weights = values.iter().map(|&x| problem.weight(x, noise));
        let (sum, weight) = values.iter().zip(weights).fold((0.0, 0.0), |(s, t), (x, w)| (s + w * x, t + w));
        let mean = sum / weight;
        values.iter_mut().for_each(|x| *x -= mean);
    }
    problem.loss(&values, noise)
}

/// The normal deviate of the same probability as a value of the F distribution (Paulson 1942).
fn deviate(ratio: f64, more: f64, left: f64) -> f64 {
    let root = ratio.max(0.0).cbrt();
    let [a, b] = [more, left].map(|degrees| 2.0 / (9.0 * degrees));
    ((1.0 - b) * root - (1.0 - a)) / (a + b * root * root).sqrt()
}
