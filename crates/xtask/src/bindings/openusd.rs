//! Written USD files in Pixar's own library: the tests of `vellus-usd` that need its Python package.

use super::venv::{python, venv};
use crate::NO_PYTHON;
use crate::run::{Outcome, run};
use std::path::Path;
use std::process::Command;

/// The versions of Python that the package has wheels for.
const VERSIONS: [&str; 5] = ["3.11", "3.13", "3.12", "3.10", "3.14"];

/// Runs the tests whose names begin with `usd_core`, with the package.
pub fn test(root: &Path) -> Result<Outcome, String> {
    let Some(interpreter) = VERSIONS.iter().find_map(|version| python(version)) else {
        return Ok(Outcome::Skipped(format!("no Python {}", VERSIONS.join(", "))));
    };
    let python = match venv(root, "openusd", &interpreter, &["usd-core==26.11"]) {
        Ok(python) => python,
        Err(reason) => return Ok(Outcome::Skipped(reason)),
    };
    // The tests call `python3`, which is in the folder of the environment's interpreter.
    let folder = python.parent().unwrap_or(root).to_owned();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths([folder].into_iter().chain(std::env::split_paths(&path)))
        .map_err(|e| format!("PATH: {e}"))?;
    run(Command::new("cargo")
        .args(["test", "--quiet", "--workspace", NO_PYTHON, "--all-features", "--test", "round_trip"])
        .args(["--test", "features", "--", "usd_core"])
        .current_dir(root)
        .env("PATH", path))?;
    Ok(Outcome::Passed)
}
