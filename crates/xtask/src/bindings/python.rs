//! The Python package: builds the wheel, installs it into an empty environment and runs its tests.

use super::venv::{python, venv};
use crate::run::{Outcome, run};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The oldest and the newest supported version. The first one that exists runs the tests.
const VERSIONS: [&str; 5] = ["3.11", "3.13", "3.12", "3.10", "3.14"];

const PACKAGES: [&str; 5] = ["maturin==1.16.0", "numpy", "pytest", "hypothesis", "mypy"];

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
    run(Command::new(&python).args(["-m", "pytest", "--quiet", &others]).arg(tests))?;
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
fn wheel(root: &Path, python: &Path) -> Result<PathBuf, String> {
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
