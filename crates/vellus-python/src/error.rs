//! Errors of the crates as Python's exceptions.

use pyo3::PyErr;
use pyo3::exceptions::{PyFileNotFoundError, PyMemoryError, PyPermissionError, PyValueError};
use std::error::Error;
use std::fmt::Display;
use std::io::{self, ErrorKind};

/// A `ValueError` with the text of an error, which names the argument, its value and its range.
pub fn value(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// The same for an error with causes, each after a colon. If one of them is that a file is missing or not permitted, it
/// is a `FileNotFoundError` or a `PermissionError`.
pub fn with_causes(error: &dyn Error) -> PyErr {
    let mut text = error.to_string();
    let (mut cause, mut kind) = (error.source(), None);
    while let Some(error) = cause {
        text += &format!(": {error}");
        kind = kind.or_else(|| error.downcast_ref::<io::Error>().map(io::Error::kind));
        cause = error.source();
    }
    match kind {
        Some(ErrorKind::NotFound) => PyFileNotFoundError::new_err(text),
        Some(ErrorKind::PermissionDenied) => PyPermissionError::new_err(text),
        _ => PyValueError::new_err(text),
    }
}

/// The same for an error of the renderer. Pictures that do not fit into memory are a `MemoryError`.
pub fn rendering(error: &vellus_render::Error) -> PyErr {
    match error {
        vellus_render::Error::Memory { .. } => PyMemoryError::new_err(error.to_string()),
        _ => with_causes(error),
    }
}
