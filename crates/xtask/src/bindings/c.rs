//! The C interface: installs the library, builds the programs in C and C++ against it and compares their results with
//! Rust's.
//!
//! `cargo xtask check` tests the same programs with the static library of a test build, which takes less time.

use crate::dist::install_c_library;
use crate::run::{Outcome, run};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Where the tests install the library.
pub fn prefix(root: &Path) -> PathBuf {
    root.join("target/bindings/c")
}

/// Installs the libraries, the header, `vellus.pc` and the files for CMake into a prefix.
pub fn install(root: &Path, prefix: &Path) -> Result<(), String> {
    let mut cargo = Command::new("cargo");
    cargo.args(["rustc", "--release"]).current_dir(root);
    install_c_library(root, &mut cargo, &root.join("target/release"), prefix)
}

/// Installs the library and runs the programs, also under valgrind.
pub fn test(root: &Path) -> Result<Outcome, String> {
    install(root, &prefix(root))?;
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
