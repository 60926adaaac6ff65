//! Whether a fit follows the measurements better than a constant does.

use crate::cost::weights;
use crate::least_squares::Problem;
use crate::profile::Profile;
use std::fmt;

/// The probability that pure noise passes for a profile.
pub const FALSE_ALARM: f64 = 1e-3;

/// A normal variable exceeds this value with the probability [`FALSE_ALARM`].
const QUANTILE: f64 = 3.0902;

/// Why a fit says nothing about the fibre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoFit {
    /// A constant follows the measurements as well as the model does.
    Noise,
    /// The model explains less than a quarter of the constant's loss, and the residuals are not noise.
    NotFollowed,
    /// The measurements determine no parameter of the fibre.
    Undetermined,
}

impl fmt::Display for NoFit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            NoFit::Noise => {
                "the model follows the measurements no better than a constant does: the measurements look like noise"
            }
            NoFit::NotFollowed => {
                "the model explains less than a quarter of the loss of a constant, and the residuals are not noise"
            }
            NoFit::Undetermined => "the measurements determine no parameter of the fibre",
        })
    }
}

/// A model that removes less than this share of the constant's loss does not follow the measurements.
const LEAST: f64 = 0.25;

/// Residuals are not noise if they widen the standard errors by more than this factor. A correlation ρ widens them by
/// √((1 + ρ)/(1 − ρ)), over φ and over θ. By chance, ρ of 554 residuals has a standard deviation of 1/√554. 1.3 is the
/// factor for three standard deviations in both.
pub const NOISE_LIKE: f64 = 1.3;

/// Judges a fit. `known` states for each fitted parameter of the fibre whether it would be determined if the
/// residuals were noise.
pub(crate) fn judge(explained: &Explained, widened: f64, known: &[bool]) -> Option<NoFit> {
    if explained.significance.is_nan() || explained.significance < QUANTILE {
        Some(NoFit::Noise)
    } else if explained.share < LEAST && widened > NOISE_LIKE {
        Some(NoFit::NotFollowed)
    } else if !known.is_empty() && !known.contains(&true) {
        Some(NoFit::Undetermined)
    } else {
        None
    }
}

/// How much better a fit is than a constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Explained {
    /// The share of the constant's loss that the model removes: 1 for a perfect fit, 0 for a fit as bad as a
    /// constant. Without outliers it is R² of the logarithms.
    pub share: f64,
    /// The F-test of the model against a constant, as a normal deviate. It is below 3.09 in all but one of 1000
    /// profiles of pure noise.
    pub significance: f64,
}

/// Compares the residuals with those of the best constant of each channel of each profile. `variables` is the number
/// of fitted variables.
pub fn explained(
    problem: &Problem,
    profiles: &[Profile],
    residuals: &[f64],
    noise: f64,
    variables: usize,
) -> Explained {
    let (mut constant, mut constants) = (0.0, 0);
    for profile in profiles {
        let weights = weights(profile);
        for c in 0..profile.channels {
            let logs = profile.points.iter().map(|p| p.value[c].ln());
            let weights = weights.iter().skip(c).step_by(profile.channels);
            constant += constant_loss(problem, logs.zip(weights.copied()).collect(), noise);
            constants += 1;
        }
    }
    let fitted = problem.loss(residuals, noise);
    let more = variables.saturating_sub(constants).max(1) as f64;
    let left = residuals.len().saturating_sub(variables).max(1) as f64;
    let ratio = (constant - fitted) / more / (fitted / left);
    Explained { share: 1.0 - fitted / constant, significance: deviate(ratio, more, left) }
}

/// The smallest loss that a fitted constant leaves for values and factors on their residuals. The loss is convex, so
/// the weighted mean converges to its minimum.
fn constant_loss(problem: &Problem, mut values: Vec<(f64, f64)>, noise: f64) -> f64 {
    for _ in 0..50 {
        let add = |[sum, weight]: [f64; 2], &(x, factor): &(f64, f64)| {
            let w = factor * factor * problem.weight(factor * x, noise);
            [sum + w * x, weight + w]
        };
        let [sum, weight] = values.iter().fold([0.0; 2], add);
        values.iter_mut().for_each(|(x, _)| *x -= sum / weight);
    }
    let residuals: Vec<f64> = values.into_iter().map(|(x, factor)| factor * x).collect();
    problem.loss(&residuals, noise)
}

/// Converts a value of the F distribution to the normal deviate of the same probability (Paulson 1942).
fn deviate(ratio: f64, more: f64, left: f64) -> f64 {
    let root = ratio.max(0.0).cbrt();
    let [a, b] = [more, left].map(|degrees| 2.0 / (9.0 * degrees));
    ((1.0 - b) * root - (1.0 - a)) / (a + b * root * root).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Upper quantiles of the F distribution, and of the normal distribution at the same probability.
    #[test]
    fn f_test_matches_published_quantiles() {
        for (ratio, more, left, normal) in
            [(5.075, 10.0, 20.0, 3.0902), (2.959, 10.0, 1e9, 3.0902), (2.305, 5.0, 100.0, 1.6449)]
        {
            let found = deviate(ratio, more, left);
            assert!((found - normal).abs() < 0.03, "F = {ratio}: {found}, not {normal}");
        }
    }
}
