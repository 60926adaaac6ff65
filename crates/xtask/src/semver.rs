//! `cargo semver-checks`: whether the version tells users of breaking changes.

use crate::run::{Outcome, cargo, output, succeeds};
use std::path::Path;
use std::process::Command;

/// Compares the published crates with the last release, which the tag before the current commit names. The feature
/// `unstable` and crates that are not published are left out: cargo-semver-checks does so by itself.
pub fn check(root: &Path) -> Result<Outcome, String> {
    if !succeeds(Command::new("cargo").args(["semver-checks", "--version"])) {
        return Ok(Outcome::Skipped("cargo-semver-checks is not installed".to_owned()));
    }
    let describe = ["describe", "--tags", "--abbrev=0", "--match", "v[0-9]*", "HEAD^"];
    let Ok(tag) = output(Command::new("git").args(describe).current_dir(root)) else {
        return Ok(Outcome::Skipped("git finds no tag of an earlier release".to_owned()));
    };
    cargo(root, &["semver-checks", "--workspace", "--baseline-rev", tag.trim()])?;
    Ok(Outcome::Passed)
}
