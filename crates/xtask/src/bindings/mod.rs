//! The bindings: C, Python, Blender, Mitsuba, OpenUSD, and the fibre explorer. Each part builds and tests what the
//! machine can run, and names what it skips.

mod blender;
pub mod c;
mod explorer;
mod mitsuba;
mod mitsuba_native;
mod openusd;
mod python;
pub mod venv;

use crate::run::Report;
use std::path::Path;

/// Builds and tests all bindings.
pub fn all(root: &Path, report: &mut Report) -> Result<(), String> {
    report.step("C bindings", || c::fast(root))?;
    fast(root, report)?;
    report.attempt("C bindings, installed", || c::test(root))?;
    report.attempt("notebooks", || python::notebooks(root))?;
    report.attempt("Blender", || blender::test(root))?;
    report.attempt("Mitsuba", || mitsuba::test(root))?;
    report.attempt("native plugin of Mitsuba", || mitsuba_native::test(root))?;
    explorer_test(root, report)
}

/// The parts that take less than a minute each. `cargo xtask test` runs them, and the tests of the C interface with
/// those of all crates.
pub fn fast(root: &Path, report: &mut Report) -> Result<(), String> {
    report.attempt("Python bindings", || python::test(root))?;
    report.attempt("USD files in OpenUSD", || openusd::test(root))
}

/// Builds the fibre explorer and tries it in a browser.
pub fn explorer_test(root: &Path, report: &mut Report) -> Result<(), String> {
    report.attempt("fibre explorer in a browser", || explorer::test(root))
}
