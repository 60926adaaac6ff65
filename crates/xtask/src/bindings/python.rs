//! The Python package: builds the wheel, installs it into an empty environment and runs its tests.

use super::venv::{python, venv};
use crate::run::{Outcome, cargo, output, run};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The oldest and the newest supported version. The first one that exists runs the tests.
const VERSIONS: [&str; 5] = ["3.11", "3.13", "3.12", "3.10", "3.14"];

pub const PACKAGES: [&str; 5] = ["maturin==1.16.0", "numpy", "pytest", "hypothesis", "mypy"];

/// What the notebooks need besides the wheel.
const NOTEBOOKS: [&str; 5] = ["maturin==1.16.0", "numpy", "nbconvert", "ipykernel", "matplotlib"];

/// Executes the notebooks, with an environment of their own.
pub fn notebooks(root: &Path) -> Result<Outcome, String> {
    let Some(interpreter) = VERSIONS.iter().find_map(|version| python(version)) else {
        return Ok(Outcome::Skipped(format!("no Python {}", VERSIONS.join(", "))));
    };
    let python = match venv(root, "notebooks", &interpreter, &NOTEBOOKS) {
        Ok(python) => python,
        Err(reason) => return Ok(Outcome::Skipped(reason)),
    };
    install(root, &python)?;
    run(Command::new(&python).arg(root.join("docs/notebooks/publish.py")).arg("--check"))?;
    Ok(Outcome::Passed)
}

/// Results of queries in Rust, for the tests: a file in `target/bindings`.
fn reference(root: &Path) -> Result<PathBuf, String> {
    cargo(root, &["build", "--release", "--quiet", "--package", "vellus-python", "--example", "batch"])?;
    let program = root.join("target/release/examples").join(format!("batch{}", std::env::consts::EXE_SUFFIX));
    let values = output(Command::new(program).arg("values"))?;
    let file = root.join("target/bindings/reference.json");
    std::fs::write(&file, values).map_err(|e| format!("{}: {e}", file.display()))?;
    Ok(file)
}

/// Builds the wheel and runs the tests against it.
pub fn test(root: &Path) -> Result<Outcome, String> {
    let Some(interpreter) = VERSIONS.iter().find_map(|version| python(version)) else {
        return Ok(Outcome::Skipped(format!("no Python {}", VERSIONS.join(", "))));
    };
    let python = match venv(root, "python", &interpreter, &PACKAGES) {
        Ok(python) => python,
        Err(reason) => return Ok(Outcome::Skipped(reason)),
    };
    install(root, &python)?;
    let tests = root.join("crates/vellus-python/tests");
    // Those of Mitsuba need its package.
    let others = format!("--ignore={}", tests.join("mitsuba").display());
    let reference = reference(root)?;
    run(Command::new(&python)
        .args(["-m", "pytest", "--quiet", &others])
        .arg(tests)
        .env("VELLUS_REFERENCE", reference))?;
    Ok(Outcome::Passed)
}

/// Builds the wheel and installs it into the environment of `python`, which must have maturin.
pub fn install(root: &Path, python: &Path) -> Result<(), String> {
    let wheel = wheel(root, python)?;
    run(Command::new(python)
        .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps", "--force-reinstall"])
        .arg(wheel))
}

/// Builds the wheel into `target/wheels`. The folder then has this wheel only.
pub fn wheel(root: &Path, python: &Path) -> Result<PathBuf, String> {
    let folder = root.join("target/wheels");
    std::fs::remove_dir_all(&folder).ok();
    run(Command::new(python)
        .args(["-m", "maturin", "build", "--release", "--quiet", "--out"])
        .arg(&folder)
        .current_dir(root.join("crates/vellus-python")))?;
    let files = folder.read_dir().map_err(|e| format!("{}: {e}", folder.display()))?;
    let wheel = files.flatten().map(|file| file.path()).find(|path| path.extension().is_some_and(|e| e == "whl"));
    wheel.ok_or(format!("maturin left no wheel in {}", folder.display()))
}
