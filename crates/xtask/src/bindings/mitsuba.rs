//! The Python package in Mitsuba 3: installs both into an environment and runs the tests of `vellus.mitsuba`.

use super::python;
use super::venv::{python, venv};
use crate::run::{Outcome, run};
use std::path::{Path, PathBuf};
use std::process::Command;

const MITSUBA: &str = "mitsuba==3.9.1";

/// Versions of Python for which Mitsuba has wheels. The first one that exists runs the tests.
const VERSIONS: [&str; 4] = ["3.11", "3.12", "3.13", "3.10"];

/// The oldest LLVM that has all instructions in double precision.
const OLDEST_LLVM: u32 = 16;

/// Runs the tests. They take some minutes, because LLVM compiles each kernel.
pub fn test(root: &Path) -> Result<Outcome, String> {
    let Some(interpreter) = VERSIONS.iter().find_map(|version| python(version)) else {
        return Ok(Outcome::Skipped(format!("no Python {}", VERSIONS.join(", "))));
    };
    let Some(llvm) = llvm() else {
        return Ok(Outcome::Skipped(format!(
            "no LLVM library from version {OLDEST_LLVM}: install libllvm19, or set DRJIT_LIBLLVM_PATH"
        )));
    };
    let python = match venv(root, "mitsuba", &interpreter, &["maturin==1.16.0", "numpy", "pytest", MITSUBA]) {
        Ok(python) => python,
        Err(reason) => return Ok(Outcome::Skipped(reason)),
    };
    python::install(root, &python)?;
    run(Command::new(&python)
        .args(["-m", "pytest", "--quiet"])
        .arg(root.join("crates/vellus-python/tests/mitsuba"))
        .env("DRJIT_LIBLLVM_PATH", llvm))?;
    Ok(Outcome::Passed)
}

/// The newest LLVM library: the one in `DRJIT_LIBLLVM_PATH`, or one in the folders of Debian and Fedora.
fn llvm() -> Option<PathBuf> {
    if let Some(path) = std::env::var_os("DRJIT_LIBLLVM_PATH").map(PathBuf::from).filter(|path| path.is_file()) {
        return Some(path);
    }
    let folders = ["/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib64"];
    let files = folders.iter().filter_map(|folder| Path::new(folder).read_dir().ok()).flatten().flatten();
    let versions = files.filter_map(|file| Some((version(file.file_name().to_str()?)?, file.path())));
    versions.filter(|(version, _)| *version >= OLDEST_LLVM).max().map(|(_, path)| path)
}

/// The version in the name of a library: `libLLVM-19.so`, `libLLVM.so.19.1`.
fn version(name: &str) -> Option<u32> {
    let rest = name.strip_prefix("libLLVM-").or_else(|| name.strip_prefix("libLLVM.so."))?;
    if !name.contains(".so") {
        return None;
    }
    rest.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_read_from_names() {
        for (name, expected) in [
            ("libLLVM-19.so", Some(19)),
            ("libLLVM-15.so.1", Some(15)),
            ("libLLVM.so.19.1", Some(19)),
            ("libLLVM.so", None),
            ("libLLVM-19.txt", None),
            ("libLLVMCore.a", None),
        ] {
            assert_eq!(version(name), expected, "{name}");
        }
    }
}
