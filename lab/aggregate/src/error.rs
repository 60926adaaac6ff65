//! Errors of bunches and aggregates.

/// Why a bunch or an aggregate cannot be made.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A number outside its range.
    #[error("{name} = {value} is out of range: {range}")]
    OutOfRange {
        /// What the number is.
        name: &'static str,
        /// The number.
        value: f64,
        /// The allowed values in words: `it must be in [0, 16]`.
        range: String,
    },
    /// A parameter of the member fibre is out of range.
    #[error("the member fibre: {0}")]
    Fiber(#[from] vellus::Error),
    /// The table of this crate is damaged. The text states the problem.
    #[error("broken table of aggregates: {0}")]
    Table(String),
}

/// The number, if it is in the range.
pub(crate) fn checked(name: &'static str, value: f64, low: f64, high: f64) -> Result<f64, Error> {
    if (low..=high).contains(&value) {
        return Ok(value);
    }
    Err(Error::OutOfRange { name, value, range: format!("it must be in [{low}, {high}]") })
}
