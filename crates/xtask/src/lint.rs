//! All checks that do not run the code.

use crate::run::{Outcome, Report, cargo, run, succeeds};
use crate::{manifests, paper, text, tools};
use std::path::Path;
use std::process::Command;

/// All checks, the quickest first.
pub fn all(root: &Path, report: &mut Report) -> Result<(), String> {
    component("rustfmt", "fmt");
    component("clippy", "clippy");
    report.step("format", || cargo(root, &["fmt", "--all", "--check"]))?;
    report.step("text", || text::check(root))?;
    report.step("PAPER.md", || paper::check(root))?;
    report.step("manifests", || manifests::check(root))?;
    report.step("clippy", || {
        let all = ["clippy", "--quiet", "--workspace", "--all-targets", "--all-features"];
        cargo(root, &[&all[..], &["--", "-D", "warnings"]].concat())
    })?;
    // Other renderers use the core without features, and see its warnings.
    report.step("clippy of the core without features", || {
        cargo(root, &["clippy", "--quiet", "--package", "vellus", "--", "-D", "warnings"])
    })?;
    report.step("rustdoc", || doc(root))?;
    report.attempt("spelling", || tools::typos(root))?;
    report.attempt("licences, bans and sources of dependencies", || tools::deny(root))?;
    report.attempt("advisories of dependencies", || {
        Ok(Outcome::Skipped("the hosted workflow checks them, because the database is on the network".to_owned()))
    })?;
    report.attempt("book", || tools::book(root))
}

/// Checks the documentation, including that of private items. Leaves that of public items in `target/doc`.
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
