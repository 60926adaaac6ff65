//! What can be wrong with a fibre or a table file.

/// Bad input, named with its value and the values allowed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A fibre parameter, or a query's coordinate, outside its range.
    #[error("{name} = {value} is out of range: {range}")]
    OutOfRange {
        /// The parameter's name as in Table 1, with the channel where it is a colour.
        name: String,
        /// The value given.
        value: f64,
        /// The values allowed.
        range: &'static str,
    },
    /// A species without a preset.
    #[error("unknown preset '{name}': known are {known}")]
    UnknownPreset {
        /// The name given.
        name: String,
        /// All names known.
        known: String,
    },
    /// Bytes that are not a table file of ours.
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
