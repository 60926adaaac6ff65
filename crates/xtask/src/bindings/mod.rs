//! The bindings: C, Python, Blender, Mitsuba. Each part builds and tests what the machine can run, and names what it
//! skips.

mod python;
mod venv;

use crate::run::Report;
use std::path::Path;

/// Builds and tests all bindings.
pub fn all(root: &Path, report: &mut Report) -> Result<(), String> {
    fast(root, report)
}

/// The parts that take less than a minute each. `cargo xtask test` runs them.
pub fn fast(root: &Path, report: &mut Report) -> Result<(), String> {
    report.attempt("Python bindings", || python::test(root))
}
