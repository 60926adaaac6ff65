//! Tools that are not part of the Rust toolchain: typos, cargo-deny, mdBook.
//!
//! Compiling one of them takes minutes, so this program does not. typos comes from its wheel in seconds. A step whose
//! tool is not in the search path is skipped, and the report says how to install it.

use crate::bindings::venv::{python, venv};
use crate::explorer;
use crate::run::{Outcome, run, succeeds};
use std::path::Path;
use std::process::Command;

/// Checks the spelling of code and documents with the settings in `typos.toml`.
pub fn typos(root: &Path) -> Result<Outcome, String> {
    let check = |tool: &Path| run(Command::new(tool).current_dir(root)).map(|()| Outcome::Passed);
    if exists("typos") {
        return check(Path::new("typos"));
    }
    let Some(interpreter) = ["3.13", "3.12", "3.11", "3.10"].iter().find_map(|version| python(version)) else {
        return Ok(missing("typos", "typos-cli@1.52.0"));
    };
    match venv(root, "typos", &interpreter, &["typos==1.52.0"]) {
        Ok(python) => check(&python.with_file_name("typos")),
        Err(reason) => Ok(Outcome::Skipped(reason)),
    }
}

/// Checks dependencies with the settings in `deny.toml`.
pub fn deny(root: &Path) -> Result<Outcome, String> {
    if !exists("cargo-deny") {
        return Ok(missing("cargo-deny", "cargo-deny@0.20.2"));
    }
    run(Command::new("cargo-deny").args(["--all-features", "check", "licenses", "bans", "sources"]).current_dir(root))?;
    Ok(Outcome::Passed)
}

/// Builds the book into `target/book`, with the fibre explorer if it has been built. A warning is an error.
pub fn book(root: &Path) -> Result<Outcome, String> {
    if !exists("mdbook") {
        return Ok(missing("mdbook", "mdbook@0.5.4 --no-default-features"));
    }
    let mut command = Command::new("mdbook");
    command.args(["build", "--dest-dir"]).arg(root.join("target/book")).arg(root.join("docs/book"));
    let output = command.output().map_err(|e| format!("cannot run mdbook: {e}"))?;
    let messages = String::from_utf8_lossy(&output.stderr);
    if output.status.success() && !messages.contains("WARN") && !messages.contains("ERROR") {
        explorer::copy_into_book(root).map(|()| Outcome::Passed)
    } else {
        Err(format!("mdbook build, {}:\n{messages}", output.status))
    }
}

/// Whether a program is in the search path.
pub fn exists(program: &str) -> bool {
    succeeds(Command::new(program).arg("--version"))
}

/// A skipped step.
pub fn missing(program: &str, package: &str) -> Outcome {
    Outcome::Skipped(format!("no {program}: cargo install --locked {package}"))
}
