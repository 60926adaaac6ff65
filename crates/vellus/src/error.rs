//! Errors of fibres, queries and table files.

/// Bad input. The message names it, with its value and the values allowed.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A parameter of a fibre, or a coordinate of a query, outside its range.
    #[error("{name} = {value} is out of range: {range}")]
    OutOfRange {
        /// The name of the parameter or coordinate, with the channel of a colour: `sigma_ca.r`.
        name: String,
        /// The value; angles in degrees.
        value: f64,
        /// The allowed values in words: `it must be in [0, 0.99]`.
        range: String,
    },
    /// An unknown name of a parameter.
    #[error("unknown parameter '{name}': known are {known}")]
    UnknownParameter {
        /// The name.
        name: String,
        /// All known names.
        known: String,
    },
    /// A value with the wrong number of channels.
    #[error("{name} takes {expected}, not {found}")]
    Channels {
        /// The name of the parameter.
        name: String,
        /// The allowed numbers in words: `one number or three`.
        expected: &'static str,
        /// The number of values.
        found: usize,
    },
    /// More than one way to give the colour of a fibre.
    #[error("colour is given more than once, by {first} and by {second}: only one may give it")]
    ColorTwice {
        /// The parameter that was given first.
        first: &'static str,
        /// The other parameter.
        second: &'static str,
    },
    /// A species without a preset.
    #[error("unknown preset '{name}': known are {known}")]
    UnknownPreset {
        /// The name.
        name: String,
        /// All known names.
        known: String,
    },
    /// An unknown way for scattered light to leave a fibre.
    #[error("unknown exit '{name}': known are {known}")]
    UnknownExit {
        /// The name.
        name: String,
        /// All known names.
        known: String,
    },
    /// A broken table file, or tables that contradict each other. The text states the problem.
    #[error("broken medulla table: {0}")]
    Table(String),
}

/// The f64 with the decimal digits of the f32: 1.2, not 1.2000000476837158.
pub(crate) fn shortest(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}
