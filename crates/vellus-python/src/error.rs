//! Errors of the crates as Python's exceptions.

use pyo3::PyErr;
use pyo3::exceptions::{PyMemoryError, PyValueError};
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

/// The same for an error of the renderer. Pictures that do not fit into memory are a `MemoryError`.
pub fn rendering(error: &vellus_render::Error) -> PyErr {
    match error {
        vellus_render::Error::Memory { .. } => PyMemoryError::new_err(error.to_string()),
        _ => with_causes(error),
    }
}
