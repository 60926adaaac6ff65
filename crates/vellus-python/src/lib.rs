//! The native part of the Python package `vellus`.

use pyo3::prelude::*;

#[pymodule]
fn _vellus(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))
}
