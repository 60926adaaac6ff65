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
mod profile;
mod query;
mod render;
mod shaders;
mod simulate;
mod tables;
mod threads;
mod varying;

use pyo3::prelude::*;
use std::ffi::c_char;

/// The instructions that this module was compiled for and the processor lacks, or null. `_processor.py` asks before
/// Python initializes the module: that, and even raising an error, may need them.
#[allow(unsafe_code, reason = "a function with a name for ctypes; no other library has this name")]
#[unsafe(no_mangle)]
pub extern "C" fn vellus_missing_instructions() -> *const c_char {
    vellus::missing_instructions().map_or(std::ptr::null(), |_| c"AVX2 and FMA".as_ptr())
}

#[pymodule]
fn _vellus(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<bcsdf::Bcsdf>()?;
    fiber::register(module)?;
    models::register(module)?;
    numbers::register(module)?;
    module.add_class::<profile::Profile>()?;
    fit::register(module)?;
    plots::register(module)?;
    shaders::register(module)?;
    simulate::register(module)?;
    tables::register(module)?;
    render::register(module)
}
