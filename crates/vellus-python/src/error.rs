//! Errors of the crates as Python's exceptions.

use pyo3::PyErr;
use pyo3::exceptions::PyValueError;
use std::error::Error;
use std::fmt::Display;

/// A `ValueError` with the text of an error, which names the argument, its value and its range.
pub fn value(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// The same for an error with causes, each after a colon.
pub fn with_causes(error: &dyn Error) -> PyErr {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text += &format!(": {error}");
        cause = error.source();
    }
    PyValueError::new_err(text)
}
