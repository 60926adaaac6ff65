//! All checks that do not run the code.

use crate::run::{Outcome, Report, cargo, run, succeeds};
use crate::{claims, manifests, paper, text, tools};
use std::path::Path;
use std::process::Command;

/// The checks that take seconds.
pub fn text(root: &Path, report: &mut Report) -> Result<(), String> {
    component("rustfmt", "fmt");
    report.step("format", 0.5, || cargo(root, &["fmt", "--all", "--check"]))?;
    report.step("text", 0.5, || text::check(root))?;
    report.step("PAPER.md", 0.5, || paper::check(root))?;
    report.step("claims", 0.5, || claims::check(root))?;
    report.step("manifests", 0.5, || manifests::check(root))
}

/// These, and clippy.
pub fn fast(root: &Path, report: &mut Report) -> Result<(), String> {
    text(root, report)?;
    component("clippy", "clippy");
    report.step("clippy", 4.0, || {
        let all = ["clippy", "--quiet", "--workspace", "--all-targets", "--all-features"];
        cargo(root, &[&all[..], &["--", "-D", "warnings"]].concat())
    })
}

/// The checks that need other tools, or compile the documentation.
pub fn more(root: &Path, report: &mut Report) -> Result<(), String> {
    // Other renderers use the core without features, and see its warnings.
    report.step("clippy of the core without features", 1.0, || {
        cargo(root, &["clippy", "--quiet", "--package", "vellus", "--", "-D", "warnings"])
    })?;
    report.step("rustdoc", 3.0, || doc(root))?;
    report.attempt("spelling", 0.5, || tools::typos(root))?;
    report.attempt("licences, bans and sources of dependencies", 0.5, || tools::deny(root))?;
    report.attempt("advisories of dependencies", 0.5, || {
        Ok(Outcome::Skipped("the hosted workflow checks them, because the database is on the network".to_owned()))
    })?;
    report.attempt("book", 0.5, || tools::book(root))
}

/// Checks the documentation, including that of private items. The pages of public items are left in `target/doc`.
fn doc(root: &Path) -> Result<(), String> {
    let doc = |more: &[&str]| {
        run(Command::new("cargo")
            .args(["doc", "--quiet", "--workspace", "--all-features", "--no-deps"])
            .args(more)
            .env("RUSTDOCFLAGS", "-D warnings")
            .current_dir(root))
    };
    doc(&["--document-private-items"])?;
    // Pages of private items would remain and mislead readers.
    std::fs::remove_dir_all(root.join("target/doc")).ok();
    doc(&[])
}

/// Installs a toolchain component if rustup manages the toolchain and the component is missing. Without rustup, the
/// distribution provides it, and the command that needs it reports that it is missing.
fn component(name: &str, command: &str) {
    if !succeeds(Command::new("cargo").args([command, "--version"])) {
        run(Command::new("rustup").args(["component", "add", name])).ok();
    }
}
