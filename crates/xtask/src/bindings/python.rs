//! The Python package: its tests, its wheel, and the notebooks.

use super::build::build;
use super::venv::{python, venv};
use crate::run::{Outcome, output, run};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The oldest and the newest supported version. The first one that exists runs the tests.
const VERSIONS: [&str; 5] = ["3.11", "3.13", "3.12", "3.10", "3.14"];

/// What the tests need.
const TESTS: [&str; 4] = ["numpy", "pytest", "hypothesis", "mypy"];

/// What builds the wheel.
pub const MATURIN: &str = "maturin==1.16.0";

/// What the notebooks need besides the wheel.
const NOTEBOOKS: [&str; 5] = [MATURIN, "numpy", "nbconvert", "ipykernel", "matplotlib"];

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

/// Runs the tests of the package, without a wheel: with the module as the test programs are compiled.
pub fn test(root: &Path) -> Result<Outcome, String> {
    let Some(interpreter) = VERSIONS.iter().find_map(|version| python(version)) else {
        return Ok(Outcome::Skipped(format!("no Python {}", VERSIONS.join(", "))));
    };
    let python = match venv(root, "package", &interpreter, &TESTS) {
        Ok(python) => python,
        Err(reason) => return Ok(Outcome::Skipped(reason)),
    };
    let built = build(root)?;
    place(root, &python, &built.module)?;
    let values = output(Command::new(built.program("batch")?).arg("values"))?;
    let reference = root.join("target/bindings/reference.json");
    std::fs::write(&reference, values).map_err(|e| format!("{}: {e}", reference.display()))?;
    let tests = root.join("crates/vellus-python/tests");
    // Those of Mitsuba need its package.
    let others = format!("--ignore={}", tests.join("mitsuba").display());
    run(Command::new(&python)
        .args(["-m", "pytest", "--quiet", "-rs", "-p", "no:cacheprovider", &others])
        .arg(tests)
        .env("VELLUS_REFERENCE", reference))?;
    Ok(Outcome::Passed)
}

/// Copies the Python files and the module to where an installed package has them.
fn place(root: &Path, python: &Path, module: &Path) -> Result<(), String> {
    let packages = output(Command::new(python).args(["-c", "import sysconfig; print(sysconfig.get_path('platlib'))"]))?;
    let folder = Path::new(packages.trim()).join("vellus");
    std::fs::remove_dir_all(&folder).ok();
    copy(&root.join("crates/vellus-python/python/vellus"), &folder)?;
    let name = if cfg!(windows) { "_vellus.pyd" } else { "_vellus.abi3.so" };
    std::fs::copy(module, folder.join(name)).map_err(|e| format!("{}: {e}", module.display()))?;
    Ok(())
}

/// Copies a folder with all that is in it, except compiled Python.
fn copy(from: &Path, to: &Path) -> Result<(), String> {
    let copied = std::fs::create_dir_all(to).and_then(|()| from.read_dir());
    for entry in copied.map_err(|e| format!("{}: {e}", from.display()))?.flatten() {
        let (path, name) = (entry.path(), entry.file_name());
        if path.is_dir() && name != "__pycache__" {
            copy(&path, &to.join(name))?;
        } else if path.is_file() {
            std::fs::copy(&path, to.join(name)).map_err(|e| format!("{}: {e}", path.display()))?;
        }
    }
    Ok(())
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
