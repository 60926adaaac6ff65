//! The C interface: installs the library with cargo-c, builds the programs in C and C++ against it and compares their
//! results with Rust's.
//!
//! `cargo xtask check` tests the same programs with the static library of a test build, without cargo-c.

use crate::run::{Outcome, run};
use crate::tools;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Where [`install`] puts the library.
pub fn prefix(root: &Path) -> PathBuf {
    root.join("target/bindings/c")
}

/// Installs the libraries, the header and `vellus.pc` into [`prefix`].
///
/// # Errors
/// The reason, if cargo-c is not installed and cannot be.
pub fn install(root: &Path) -> Result<Result<(), String>, String> {
    let tool = match tools::cargo_c() {
        Ok(tool) => tool,
        Err(reason) => return Ok(Err(reason)),
    };
    run(Command::new(tool)
        .args(["cinstall", "--release", "--package", "vellus-c", "--libdir", "lib", "--prefix"])
        .arg(prefix(root))
        .current_dir(root))?;
    Ok(Ok(()))
}

/// Installs the library and runs the programs, also under valgrind.
pub fn test(root: &Path) -> Result<Outcome, String> {
    if let Err(reason) = install(root)? {
        return Ok(Outcome::Skipped(reason));
    }
    for program in ["cc", "c++", "pkg-config", "valgrind"] {
        if !crate::run::succeeds(Command::new(program).arg("--version")) {
            return Ok(Outcome::Skipped(format!("no {program}")));
        }
    }
    run(Command::new("cargo")
        .args(["test", "--quiet", "--package", "vellus-c", "--test", "it", "--", "programs", "--include-ignored"])
        .env("VELLUS_C_PREFIX", prefix(root))
        .current_dir(root))?;
    Ok(Outcome::Passed)
}
