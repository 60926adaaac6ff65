//! What a fit found.

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
    /// Held at a given value.
    Fixed,
    /// Has the value of the parameter named.
    Tied(String),
}

/// One parameter's value and what is known of it.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// As in files.
    pub name: String,
    /// `°` or nothing.
    pub unit: &'static str,
    /// The value, angles in degrees.
    pub value: f64,
    /// Its standard error, one-sided at an end of its range; none where it was not fitted, or the data says nothing of it.
    pub error: Option<f64>,
    /// How it was treated.
    pub state: State,
    /// Does the data say what it is? False at an end of its range, and where the standard error is above a tenth of the range
    /// in which fibres usually are (in the variable it is fitted in).
    pub determined: bool,
}

/// A minimum other than the best.
#[derive(Clone, Debug)]
pub struct Rival {
    /// Its parameters.
    pub values: Vec<f64>,
    /// By how much the χ² of the log-ratios is worse. Below 9 (three standard errors) the data cannot tell them apart.
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
    /// The correlation of each two, in [−1, 1], row by row: as many rows and columns as there are names. The diagonal is 1.
    pub matrix: Vec<Vec<f64>>,
}

/// A linear combination of parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Combination {
    /// Names of parameters and their shares, the largest share first. The shares are a unit vector in units of the usual
    /// ranges; small ones are left out.
    pub shares: Vec<(String, f64)>,
    /// The standard error along that vector, in units of the usual ranges: 0.01 is one percent of them.
    pub standard_error: f64,
}

/// What came out.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The model that was fitted.
    pub model: ModelKind,
    /// The fibre.
    pub specimen: Specimen,
    /// Inclination of the fixed direction, degrees.
    pub theta_o: f64,
    /// What the model's values are multiplied with.
    pub scale: f64,
    /// All parameters.
    pub estimates: Vec<Estimate>,
    /// The correlations of the fitted parameters.
    pub correlations: Correlations,
    /// The combination of parameters that the data determines least.
    pub weakest: Combination,
    /// What the model says for each point, in the unit of the profile.
    pub fitted: Vec<[f64; 3]>,
    /// RMS error over the range of the measured values (Yan17 footnote 3).
    pub nrmse: f64,
    /// The same of the logarithms, which is what is minimised.
    pub log_nrmse: f64,
    /// How much better it is than a constant.
    pub explained: Explained,
    /// Why it says nothing about the fibre, if so.
    pub no_fit: Option<NoFit>,
    /// Standard deviation of the log-ratios, outliers left out.
    pub noise: f64,
    /// Values further off than Huber's k times the noise.
    pub outliers: usize,
    /// Correlation of neighbouring residuals, over φ and over θ.
    pub neighbours: [f64; 2],
    /// What the standard errors were widened by because of it.
    pub widened: f64,
    /// How many descents there were.
    pub starts: Starts,
    /// The next best minimum found.
    pub rival: Option<Rival>,
    /// Values of the model that were needed.
    pub evaluations: u64,
    /// Stopped before it was done: the best so far.
    pub interrupted: bool,
}
