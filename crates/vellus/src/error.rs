//! Errors of fibres, queries and table files.

/// Bad input. The message names it, with its value and the values allowed.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A parameter of a fibre, or a coordinate of a query, outside its range.
    #[error("{name} = {value} is out of range: {range}")]
    OutOfRange {
        /// The parameter's name as in Table 1, with the channel if it is a colour: `sigma_ca.r`.
        name: String,
        /// The value given. Angles are in degrees.
        value: f64,
        /// The allowed values.
        range: &'static str,
    },
    /// A species without a preset.
    #[error("unknown preset '{name}': known are {known}")]
    UnknownPreset {
        /// The name given.
        name: String,
        /// All known names.
        known: String,
    },
    /// A broken table file, or tables that contradict themselves. The text says how.
    #[error("broken medulla table: {0}")]
    Table(String),
}

/// Checks lo ≤ value ≤ hi; NaN fails. `range` says the same in words.
pub(crate) fn check(name: &str, value: f32, lo: f32, hi: f32, range: &'static str) -> Result<(), Error> {
    if (lo..=hi).contains(&value) {
        Ok(())
    } else {
        Err(Error::OutOfRange { name: name.to_owned(), value: shortest(value), range })
    }
}

/// The f64 that prints as the f32 does: 1.2, not 1.2000000476837158.
fn shortest(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}
