//! Other processors, the fuzz targets, and the oldest supported compilers.

use crate::manifests::packages;
use crate::run::{Outcome, Report, cargo, output, run, succeeds};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

const AARCH64: &str = "aarch64-unknown-linux-gnu";

/// Runs all of these checks.
pub fn all(root: &Path, report: &mut Report) -> Result<(), String> {
    report.attempt("vellus without AVX2", 10.0, || without_avx2(root))?;
    report.attempt("vellus on aarch64", 10.0, || aarch64(root))?;
    report.step("fuzz targets", 10.0, || {
        run(Command::new("cargo")
            .args(["check", "--quiet", "--locked", "--bins"])
            .env("CARGO_TARGET_DIR", root.join("target/fuzz"))
            .current_dir(root.join("fuzz")))
    })?;
    for (oldest, packages) in oldest_compilers(root)? {
        report.attempt(&format!("packages for Rust {oldest}"), 10.0, || compiles(root, &oldest, &packages))?;
    }
    Ok(())
}

/// Tests the core on any x86-64 processor. `RUSTFLAGS` replaces the flags in `.cargo/config.toml`.
fn without_avx2(root: &Path) -> Result<Outcome, String> {
    if !cfg!(target_arch = "x86_64") {
        return Ok(Outcome::Skipped("this processor is not x86-64".to_owned()));
    }
    run(Command::new("cargo")
        .args(["test", "--quiet", "--package", "vellus", "--all-features", "--lib", "--tests"])
        .env("RUSTFLAGS", "-C target-cpu=x86-64")
        .env("CARGO_TARGET_DIR", root.join("target/x86-64"))
        .current_dir(root))?;
    Ok(Outcome::Passed)
}

/// Compiles the core for 64-bit Arm.
fn aarch64(root: &Path) -> Result<Outcome, String> {
    if !succeeds(Command::new("rustup").args(["target", "add", AARCH64]).current_dir(root)) {
        return Ok(Outcome::Skipped(format!("rustup cannot install the target {AARCH64}")));
    }
    cargo(root, &["check", "--quiet", "--package", "vellus", "--all-features", "--target", AARCH64])?;
    Ok(Outcome::Passed)
}

/// Each `rust-version`, with the packages that state it.
fn oldest_compilers(root: &Path) -> Result<BTreeMap<String, Vec<String>>, String> {
    let mut compilers: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for package in packages(root)? {
        let text = |field: &str| package[field].as_str().map(ToOwned::to_owned);
        let name = text("name").unwrap_or_default();
        let oldest = text("rust_version").ok_or_else(|| format!("{name}: the manifest has no rust-version"))?;
        compilers.entry(oldest).or_default().push(name);
    }
    Ok(compilers)
}

/// Compiles packages with the compiler that their `rust-version` names. Passes at once if this is the compiler in use,
/// because every other step used it.
fn compiles(root: &Path, oldest: &str, packages: &[String]) -> Result<Outcome, String> {
    let current = output(Command::new("rustc").arg("--version").current_dir(root))?;
    if current.split(' ').nth(1).is_some_and(|version| version.starts_with(&format!("{oldest}."))) {
        return Ok(Outcome::Passed);
    }
    let toolchain = format!("+{oldest}");
    if !succeeds(Command::new("cargo").args([&toolchain, "--version"])) {
        return Ok(Outcome::Skipped(format!("the toolchain {oldest} is not installed")));
    }
    run(Command::new("cargo")
        .args([&toolchain, "check", "--quiet", "--all-features"])
        .args(packages.iter().flat_map(|package| ["--package", package]))
        .env("CARGO_TARGET_DIR", root.join("target/oldest"))
        .current_dir(root))?;
    Ok(Outcome::Passed)
}
