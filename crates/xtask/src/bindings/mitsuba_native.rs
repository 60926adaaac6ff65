//! The native Mitsuba plugin: builds it against the wheel of Mitsuba and compares pictures with `vellus render`.

use super::c;
use super::python;
use super::venv::{python, venv};
use crate::run::{Outcome, cargo, run, succeeds};
use std::path::Path;
use std::process::Command;

/// The plugin is tested with this version of Mitsuba.
const PACKAGES: [&str; 5] = ["mitsuba==3.9.1", "nanobind==3.1.0", "numpy", "pytest", python::MATURIN];

/// Interpreters for which there is a wheel.
const VERSIONS: [&str; 5] = ["3.11", "3.12", "3.13", "3.10", "3.14"];

/// Builds the plugin and runs its tests.
pub fn test(root: &Path) -> Result<Outcome, String> {
    if !cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        return Ok(Outcome::Skipped("the plugin is for Linux on x86-64".to_owned()));
    }
    if !succeeds(Command::new("c++").arg("--version")) {
        return Ok(Outcome::Skipped("no c++".to_owned()));
    }
    let Some(interpreter) = VERSIONS.iter().find_map(|version| python(version)) else {
        return Ok(Outcome::Skipped(format!("no Python {}", VERSIONS.join(", "))));
    };
    let python = match venv(root, "mitsuba-native", &interpreter, &PACKAGES) {
        Ok(python) => python,
        Err(reason) => return Ok(Outcome::Skipped(reason)),
    };
    // The package and the plugin have a BSDF of the same name.
    python::install(root, &python)?;
    c::install(root, &c::prefix(root))?;
    let (source, plugin) = (root.join("integrations/mitsuba/native"), root.join("target/bindings/mitsuba-plugin"));
    run(Command::new(&python)
        .arg(source.join("build.py"))
        .arg("--vellus")
        .arg(c::prefix(root))
        .arg("--out")
        .arg(&plugin))?;
    cargo(root, &["build", "--release", "--quiet", "--package", "vellus-cli"])?;
    run(Command::new(&python)
        .args(["-m", "pytest", "--quiet", "-s", "-p", "no:cacheprovider"])
        .arg(source.join("test_native.py"))
        .env("VELLUS", root.join("target/release/vellus"))
        .env("VELLUS_MITSUBA", plugin))?;
    Ok(Outcome::Passed)
}
