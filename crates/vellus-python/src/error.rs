//! Errors of the crates as Python's exceptions.

use pyo3::PyErr;
use pyo3::exceptions::PyValueError;
use std::fmt::Display;

/// A `ValueError` with the text of an error, which names the argument, its value and its range.
pub fn value(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}
