//! Errors of fibres, queries and table files.

use std::fmt;

/// Bad input. The message names it, with its value and the values allowed.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq)]
pub enum Error {
    /// A parameter of a fibre, or a coordinate of a query, outside its range.
    OutOfRange {
        /// The name of the parameter or coordinate, with the channel of a colour: `sigma_ca.r`.
        name: String,
        /// The value; angles in degrees.
        value: f64,
        /// The allowed values in words: `it must be in [0, 0.99]`.
        range: String,
    },
    /// An unknown name of a parameter.
    UnknownParameter {
        /// The name.
        name: String,
        /// All known names.
        known: String,
    },
    /// A value with the wrong number of channels.
    Channels {
        /// The name of the parameter.
        name: String,
        /// The allowed numbers in words: `one number or three`.
        expected: &'static str,
        /// The number of values.
        found: usize,
    },
    /// A word where a parameter takes numbers.
    NoWord {
        /// The name of the parameter.
        name: String,
        /// The allowed numbers in words: `one number or three`.
        expected: &'static str,
    },
    /// More than one way to give the colour of a fibre.
    ColorTwice {
        /// The parameter that was given first.
        first: &'static str,
        /// The other parameter.
        second: &'static str,
    },
    /// An unknown name of a preset, of a lobe, or of a choice of a parameter.
    UnknownName {
        /// What it should be: `preset`, `lobe` or the name of the parameter.
        what: &'static str,
        /// The name.
        name: String,
        /// All known names.
        known: String,
    },
    /// A broken table file, or tables that contradict each other. The text states the problem.
    Table(String),
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::OutOfRange { name, value, range } => write!(f, "{name} = {value} is out of range: {range}"),
            Error::UnknownParameter { name, known } => write!(f, "unknown parameter '{name}': known are {known}"),
            Error::Channels { name, expected, found } => write!(f, "{name} takes {expected}, not {found}"),
            Error::NoWord { name, expected } => write!(f, "{name} takes {expected}, not a word"),
            Error::ColorTwice { first, second } => {
                write!(f, "colour is given more than once, by {first} and by {second}: only one may give it")
            }
            Error::UnknownName { what, name, known } => write!(f, "unknown {what} '{name}': known are {known}"),
            Error::Table(problem) => write!(f, "broken medulla table: {problem}"),
        }
    }
}

impl std::error::Error for Error {}

/// The f64 with the decimal digits of the f32: 1.2, not 1.2000000476837158.
pub(crate) fn shortest(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}
