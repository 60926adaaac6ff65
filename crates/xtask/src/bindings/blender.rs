//! The extension of Blender: builds it, installs it as a user would, and runs its tests.

use super::python;
use super::venv::{python, venv};
use crate::run::{Outcome, cargo, run};
use std::path::Path;
use std::process::Command;

/// The version of Blender as a Python package, and the version of Python that it needs.
const BLENDER: (&str, &str) = ("bpy==5.2.3", "3.13");

/// Runs the tests. The package bpy takes 1 GB of disk.
pub fn test(root: &Path) -> Result<Outcome, String> {
    let (package, version) = BLENDER;
    let Some(interpreter) = python(version) else {
        return Ok(Outcome::Skipped(format!("no Python {version}, which {package} needs")));
    };
    let builder = match venv(root, "maturin", &interpreter, &[python::MATURIN]) {
        Ok(python) => python,
        Err(reason) => return Ok(Outcome::Skipped(reason)),
    };
    let blender = match venv(root, "blender", &interpreter, &[package]) {
        Ok(python) => python,
        Err(reason) => return Ok(Outcome::Skipped(reason)),
    };
    let wheel = python::wheel(root, &builder)?;
    cargo(root, &["build", "--release", "--quiet", "--package", "vellus-cli"])?;
    let (folder, out) = (root.join("integrations/blender"), root.join("target/blender"));
    std::fs::remove_dir_all(&out).ok();
    let script = |name: &str| {
        let mut command = Command::new(&blender);
        command.arg(folder.join(name));
        command
    };
    run(script("build.py").arg("--wheel").arg(wheel).arg("--out").arg(&out))?;
    run(&mut script("test_extract.py"))?;
    let files = out.read_dir().map_err(|e| format!("{}: {e}", out.display()))?;
    let extension = files.flatten().next().ok_or_else(|| format!("build.py left nothing in {}", out.display()))?.path();
    let command = root.join("target/release").join(format!("vellus{}", std::env::consts::EXE_SUFFIX));
    for test in ["test_engine.py", "test_scenes.py"] {
        run(script(test).arg(&extension).arg(&command))?;
    }
    Ok(Outcome::Passed)
}
