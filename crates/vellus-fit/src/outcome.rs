//! The result of a fit.

use crate::specimen::Specimen;
use crate::verdict::{Explained, NoFit};
use vellus_models::ModelKind;

/// How a parameter was treated.
#[derive(Clone, Debug, PartialEq)]
pub enum State {
    /// Fitted, and inside its range.
    Fitted,
    /// Fitted, and at an end of its range.
    AtBound,
    /// Fixed at a given value.
    Fixed,
    /// Has the value of the parameter named.
    Tied(String),
}

/// The value of one parameter, with its standard error.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// The name in files.
    pub name: String,
    /// `°` for an angle, or nothing.
    pub unit: &'static str,
    /// The value, angles in degrees.
    pub value: f64,
    /// The standard error, one-sided at an end of the range. `None` for a parameter that was not fitted, or that the
    /// data says nothing about.
    pub error: Option<f64>,
    /// How it was treated.
    pub state: State,
    /// Does the data determine the value? Not at an end of the range, and not if the standard error is above a tenth
    /// of the range in which fibres usually are (in the variable that is fitted).
    pub determined: bool,
}

/// A minimum other than the best.
#[derive(Clone, Debug)]
pub struct Rival {
    /// The values of its parameters, as many as [`Fit::estimates`].
    pub values: Vec<f64>,
    /// How much larger its χ² of the log-ratios is. Below 9 (three standard errors) the data cannot tell them apart.
    pub chi2: f64,
}

/// How many descents a fit began, and what became of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Starts {
    /// Descents begun.
    pub begun: usize,
    /// Descents that converged.
    pub finished: usize,
    /// Descents that ended in the best minimum.
    pub ended_here: usize,
}

/// Correlations of the fitted parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Correlations {
    /// The name of each fitted parameter. Tied parameters have one name.
    pub names: Vec<String>,
    /// The correlation of each two, in [−1, 1], row by row: as many rows and columns as there are names. The diagonal
    /// is 1.
    pub matrix: Vec<Vec<f64>>,
}

/// A linear combination of parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Combination {
    /// Names of parameters and their shares, the largest share first. The shares are a unit vector in units of the
    /// usual ranges; small ones are left out.
    pub shares: Vec<(String, f64)>,
    /// The standard error along that vector, in units of the usual ranges: 0.01 is one percent of them.
    pub standard_error: f64,
}

/// The result of a fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The model that was fitted.
    pub model: ModelKind,
    /// The fitted fibre.
    pub specimen: Specimen,
    /// Inclination of the fixed direction, degrees.
    pub theta_o: f64,
    /// The factor on the values of the model.
    pub scale: f64,
    /// All parameters of the model, in the order of files.
    pub estimates: Vec<Estimate>,
    /// The correlations of the fitted parameters.
    pub correlations: Correlations,
    /// The combination of parameters that the data determines least.
    pub weakest: Combination,
    /// The value of the model for each point, in the unit of the profile.
    pub fitted: Vec<[f64; 3]>,
    /// RMS error over the range of the measured values (Yan17 footnote 3).
    pub nrmse: f64,
    /// The same for the logarithms, which the fit minimises.
    pub log_nrmse: f64,
    /// How much better the fit is than a constant.
    pub explained: Explained,
    /// Why the fit says nothing about the fibre, if it does not.
    pub no_fit: Option<NoFit>,
    /// Robust standard deviation of the log-ratios.
    pub noise: f64,
    /// How many values are off by more than Huber's k times the noise.
    pub outliers: usize,
    /// Correlation of neighbouring residuals, over φ and over θ.
    pub neighbours: [f64; 2],
    /// The factor by which that correlation widens the standard errors.
    pub widened: f64,
    /// How many descents there were.
    pub starts: Starts,
    /// The next best minimum found.
    pub rival: Option<Rival>,
    /// How many values of the model were computed.
    pub evaluations: u64,
    /// The fit was cancelled: this is the best result so far.
    pub interrupted: bool,
}
