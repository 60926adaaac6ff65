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
        /// The value given; angles in degrees.
        value: f64,
        /// The values allowed, in words: `it must be in [0, 0.99]`.
        range: String,
    },
    /// A name that no parameter has.
    #[error("unknown parameter '{name}': known are {known}")]
    UnknownParameter {
        /// The name given.
        name: String,
        /// All names known.
        known: String,
    },
    /// A value with another number of channels than its parameter has.
    #[error("{name} takes {expected}, not {found}")]
    Channels {
        /// The name of the parameter.
        name: String,
        /// The numbers allowed, in words: `one number or three`.
        expected: &'static str,
        /// How many numbers were given.
        found: usize,
    },
    /// More than one way to give the colour of a fibre.
    #[error("colour is given more than once, by {first} and by {second}: only one may give it")]
    ColorTwice {
        /// The parameter that was given first.
        first: &'static str,
        /// The other one.
        second: &'static str,
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

/// The f64 that prints as the f32 does: 1.2, not 1.2000000476837158.
pub(crate) fn shortest(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}
