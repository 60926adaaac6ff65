//! The options of a fit.

use crate::space::Requests;

/// The options of [`fit`](crate::fit()).
#[derive(Clone, Debug)]
pub struct Options {
    /// Parameters that are fixed, tied or freed.
    pub requests: Requests,
    /// How many descents to begin, at least 1: from the presets, and from the best points of a space-filling design.
    pub starts: usize,
    /// The seed of that design.
    pub seed: u64,
    /// Huber's k, at least 1: residuals above k times the noise count linearly instead of squared. Infinity is plain
    /// least squares.
    pub huber: f64,
}

impl Default for Options {
    /// 32 starts, the seed 1, and k = 4.
    fn default() -> Self {
        // Where the model cannot follow the data, the highlights have the largest residuals, and must keep some weight:
        // with k = 2.5 the NRMSE of whole fibres is up to 1.6 percentage points worse.
        Options { requests: Requests::default(), starts: 32, seed: 1, huber: 4.0 }
    }
}
