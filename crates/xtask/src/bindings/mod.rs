//! The bindings: C, Python, Blender, Mitsuba, OpenUSD, and the fibre explorer. Each part builds and tests what the
//! machine can run, and names what it skips.

mod blender;
mod build;
pub mod c;
mod explorer;
mod mitsuba;
mod mitsuba_native;
pub mod openusd;
mod python;
pub mod venv;

pub use build::build;

use crate::run::Report;
use std::path::Path;

/// Builds and tests all bindings.
pub fn all(root: &Path, report: &mut Report) -> Result<(), String> {
    fast(root, report)?;
    report.attempt("C library", 8.0, || c::test(root))?;
    report.attempt("notebooks", 15.0, || python::notebooks(root))?;
    report.attempt("Blender", 20.0, || blender::test(root))?;
    report.attempt("Mitsuba", 15.0, || mitsuba::test(root))?;
    report.attempt("native plugin of Mitsuba", 10.0, || mitsuba_native::test(root))?;
    explorer_test(root, report)
}

/// The part that takes less than a minute. The tests of the C interface run with those of all crates.
pub fn fast(root: &Path, report: &mut Report) -> Result<(), String> {
    report.attempt("Python package", 4.0, || python::test(root))
}

/// Tries the model as WebAssembly, and the fibre explorer in a browser.
pub fn explorer_test(root: &Path, report: &mut Report) -> Result<(), String> {
    report.attempt("golden vectors in WebAssembly", 15.0, || explorer::vectors(root))?;
    report.attempt("fibre explorer in a browser", 15.0, || explorer::test(root))
}
