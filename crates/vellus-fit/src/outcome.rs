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
    /// Tied to the parameter with this name, and equal to it.
    Tied(String),
}

/// The value of one parameter, with its standard error.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// The name in files. In brackets, the channel and the number of the measurement to which it belongs, if others
    /// have values of their own: `sigma_ca[550]`, `scale[2]`.
    pub name: String,
    /// The index of the first profile to which it belongs.
    pub profile: usize,
    /// `°` for an angle, or nothing.
    pub unit: &'static str,
    /// The value, angles in degrees.
    pub value: f64,
    /// The standard error. It is one-sided at an end of the range. `None` for a parameter that was not fitted, or that
    /// the data do not constrain.
    pub error: Option<f64>,
    /// The 95 % interval of the profile likelihood, within the range of the parameter. `None` for a parameter that was
    /// not fitted.
    pub interval: Option<[f64; 2]>,
    /// How it was treated.
    pub state: State,
    /// Whether the data determine the value. False at an end of the range, and if the standard error exceeds a tenth
    /// of the usual range of fibres. Both are measured in the variable of the fit, such as the logarithm of a
    /// roughness.
    pub determined: bool,
}

/// A minimum other than the best.
#[derive(Clone, Debug)]
pub struct Rival {
    /// The values of all parameters, in the order of [`Fit::estimates`].
    pub values: Vec<f64>,
    /// The χ² of its log-ratios minus that of the best minimum. Below 9 (three standard errors), the data cannot
    /// distinguish the two.
    pub chi2: f64,
}

/// The numbers of descents of a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Starts {
    /// Descents that were started.
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
    /// The correlation matrix, row by row. It has one row and one column for each name. Elements are in [−1, 1], and
    /// the diagonal is 1.
    pub matrix: Vec<Vec<f64>>,
}

/// A linear combination of parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Combination {
    /// Names of parameters and their shares, the largest share first. The shares are the components of a unit vector,
    /// in units of the usual ranges. Small ones are omitted.
    pub shares: Vec<(String, f64)>,
    /// The standard error along that vector, in units of the usual ranges. 0.01 is one percent of them.
    pub standard_error: f64,
}

/// The result of a fit for one of its profiles.
#[derive(Clone, Debug)]
pub struct Part {
    /// The fitted fibre. It only differs between profiles in what [`Requests::separate`](crate::Requests::separate)
    /// names.
    pub specimen: Specimen,
    /// Inclination of the fixed direction, degrees.
    pub theta_o: f64,
    /// The factor on the values of the model.
    pub scale: f64,
    /// What is added to them.
    pub background: f64,
    /// The value of the model for each point, in the unit of the profile.
    pub fitted: Vec<[f64; 3]>,
    /// RMS error divided by the range of the measured values (Yan17 footnote 3).
    pub nrmse: f64,
    /// The same for the logarithms, which the fit minimises.
    pub log_nrmse: f64,
}

/// The result of a fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The model that was fitted.
    pub model: ModelKind,
    /// The fitted fibre, that of the first profile.
    pub specimen: Specimen,
    /// The result for each profile.
    pub parts: Vec<Part>,
    /// All parameters of the model, in the order of files.
    pub estimates: Vec<Estimate>,
    /// The correlations of the fitted parameters.
    pub correlations: Correlations,
    /// The combination of parameters that the data constrain least.
    pub weakest: Combination,
    /// RMS error divided by the range of the measured values (Yan17 footnote 3): the RMS over all values of all
    /// profiles.
    pub nrmse: f64,
    /// The same for the logarithms, which the fit minimises.
    pub log_nrmse: f64,
    /// Comparison of the fit with a constant.
    pub explained: Explained,
    /// The reason why the fit says nothing about the fibre, or `None` if it does.
    pub no_fit: Option<NoFit>,
    /// Robust standard deviation of the log-ratios.
    pub noise: f64,
    /// The number of values whose residual exceeds Huber's k times the noise.
    pub outliers: usize,
    /// Correlation of neighbouring residuals, over φ and over θ.
    pub neighbours: [f64; 2],
    /// The factor by which that correlation widens the standard errors.
    pub widened: f64,
    /// The numbers of descents.
    pub starts: Starts,
    /// The second-best distinct minimum, if one was found.
    pub rival: Option<Rival>,
    /// The number of model values that were computed.
    pub evaluations: u64,
    /// Whether the fit was cancelled. The result is then the best one found until then.
    pub interrupted: bool,
}
