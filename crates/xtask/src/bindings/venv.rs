//! Python interpreters and virtual environments, in `target/bindings`.

use crate::run::{output, run, succeeds};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A Python interpreter of exactly this version, such as "3.11": in the search path, or one of pyenv.
pub fn python(version: &str) -> Option<PathBuf> {
    let test = format!("import sys; assert '%d.%d' % sys.version_info[:2] == '{version}'");
    let works = |program: &PathBuf| succeeds(Command::new(program).args(["-c", &test]));
    let named = [format!("python{version}"), "python3".to_owned()].map(PathBuf::from);
    named.into_iter().chain(pyenv(version)).find(works)
}

/// An interpreter of any version that the Python package supports. The package is tried with 3.11 first.
///
/// # Errors
/// The reason, for a step that is skipped.
pub fn supported() -> Result<PathBuf, String> {
    let versions = ["3.11", "3.13", "3.12", "3.14", "3.10"];
    versions.iter().find_map(|version| python(version)).ok_or_else(|| format!("no Python {}", versions.join(", ")))
}

/// The interpreters that pyenv has of this version.
fn pyenv(version: &str) -> Vec<PathBuf> {
    let Ok(root) = output(Command::new("pyenv").arg("root")) else { return Vec::new() };
    let Ok(folders) = Path::new(root.trim()).join("versions").read_dir() else { return Vec::new() };
    let start = format!("{version}.");
    let matching = folders.flatten().filter(|folder| folder.file_name().to_string_lossy().starts_with(&start));
    matching.map(|folder| folder.path().join("bin/python3")).collect()
}

/// The interpreter of the virtual environment `target/bindings/NAME` that has these packages. It makes the environment
/// and installs what is missing.
///
/// # Errors
/// The reason why it cannot be made, for a step that is skipped.
pub fn venv(root: &Path, name: &str, interpreter: &Path, packages: &[&str]) -> Result<PathBuf, String> {
    let folder = root.join("target/bindings").join(name);
    let python = folder.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    if !succeeds(Command::new(&python).arg("--version")) {
        run(Command::new(interpreter).args(["-m", "venv", "--clear"]).arg(&folder))?;
    }
    // The list of what is installed tells whether pip has anything to do, without the network.
    let list = folder.join("packages.txt");
    let wanted = packages.join("\n");
    if std::fs::read_to_string(&list).ok().as_deref() != Some(&wanted) {
        run(Command::new(&python)
            .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"])
            .args(packages))?;
        std::fs::write(&list, wanted).map_err(|e| format!("{}: {e}", list.display()))?;
    }
    Ok(python)
}
