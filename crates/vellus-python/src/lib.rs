//! The native part of the Python package `vellus`.
//!
//! `_vellus.pyi` documents what Python sees.

mod arrays;
mod bcsdf;
mod checks;
mod error;
mod fiber;
mod fit;
mod models;
mod numbers;
mod output;
mod plots;
mod query;
mod render;
mod simulate;
mod tables;
mod threads;

use pyo3::exceptions::PyImportError;
use pyo3::prelude::*;

#[pymodule]
fn _vellus(module: &Bound<'_, PyModule>) -> PyResult<()> {
    if let Some(missing) = vellus::missing_instructions() {
        return Err(PyImportError::new_err(format!("this build of vellus needs a processor with {missing}")));
    }
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<bcsdf::Bcsdf>()?;
    fiber::register(module)?;
    models::register(module)?;
    numbers::register(module)?;
    fit::register(module)?;
    plots::register(module)?;
    simulate::register(module)?;
    tables::register(module)?;
    render::register(module)
}
