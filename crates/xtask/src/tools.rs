//! Tools that are not part of the Rust toolchain: typos, cargo-deny, mdBook.
//!
//! A tool in the search path is used. A missing tool is installed into `target/tools`. If that fails, the step is
//! skipped, and the report names it. An installation takes 61 (mdBook), 118 (typos) and 101 seconds (cargo-deny) of
//! processor time.

use crate::explorer;
use crate::run::{Outcome, run, succeeds};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Checks the spelling of code and documents with the settings in `typos.toml`.
pub fn typos(root: &Path) -> Result<Outcome, String> {
    with(root, "typos", &["typos-cli@1.52.0"], |tool| run(Command::new(tool).current_dir(root)))
}

/// Checks dependencies with the settings in `deny.toml`.
pub fn deny(root: &Path) -> Result<Outcome, String> {
    with(root, "cargo-deny", &["cargo-deny@0.20.2"], |tool| {
        let checks = ["--all-features", "check", "licenses", "bans", "sources"];
        run(Command::new(tool).args(checks).current_dir(root))
    })
}

/// Builds the book into `target/book`, with the fibre explorer if it has been built. A warning is an error.
pub fn book(root: &Path) -> Result<Outcome, String> {
    if !root.join("docs/book/book.toml").exists() {
        return Ok(Outcome::Skipped("docs/book/book.toml does not exist".to_owned()));
    }
    with(root, "mdbook", &["mdbook@0.5.4", "--no-default-features"], |tool| {
        let mut command = Command::new(tool);
        command.args(["build", "--dest-dir"]).arg(root.join("target/book")).arg(root.join("docs/book"));
        let output = command.output().map_err(|e| format!("cannot run mdbook: {e}"))?;
        let messages = String::from_utf8_lossy(&output.stderr);
        if output.status.success() && !messages.contains("WARN") && !messages.contains("ERROR") {
            explorer::copy_into_book(root)
        } else {
            Err(format!("mdbook build, {}:\n{messages}", output.status))
        }
    })
}

/// Runs `work` with the path of a tool.
fn with(
    root: &Path,
    name: &str,
    package: &[&str],
    work: impl FnOnce(&Path) -> Result<(), String>,
) -> Result<Outcome, String> {
    match find(root, name, package) {
        Ok(tool) => work(&tool).map(|()| Outcome::Passed),
        Err(reason) => Ok(Outcome::Skipped(reason)),
    }
}

fn find(root: &Path, name: &str, package: &[&str]) -> Result<PathBuf, String> {
    let tools = root.join("target/tools");
    let own = tools.join("bin").join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    let runs = |tool: &Path| succeeds(Command::new(tool).arg("--version"));
    if let Some(tool) = [PathBuf::from(name), own.clone()].into_iter().find(|tool| runs(tool)) {
        return Ok(tool);
    }
    // Without optimization the installation takes a third of the time, and the tools are still fast enough.
    let build = tools.join("build");
    let mut install = Command::new("cargo");
    install.args(["install", "--quiet", "--locked", "--debug"]).args(package);
    install.arg("--root").arg(&tools).arg("--target-dir").arg(&build).env("CARGO_PROFILE_DEV_DEBUG", "0");
    let result = run(&mut install);
    std::fs::remove_dir_all(build).ok();
    result.map_err(|e| format!("it cannot be installed: {e}")).map(|()| own)
}
