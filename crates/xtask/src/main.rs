//! `cargo xtask test`: all that CI checks, in the order in which it fails fastest.

mod paper;

use std::path::Path;
use std::process::{Command, ExitCode};

const USAGE: &str = "usage: cargo xtask test | lint | paper

  test   formatting, clippy, docs, PAPER.md, all tests: what CI runs
  lint   formatting, clippy, docs, PAPER.md only
  paper  PAPER.md only: every symbol it names exists, every departure in the code is listed";

fn main() -> ExitCode {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let result = match std::env::args().nth(1).as_deref() {
        Some("test") => lint(&root).and_then(|()| test(&root)),
        Some("lint") => lint(&root),
        Some("paper") => paper::check(&root),
        _ => Err(USAGE.to_owned()),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

fn lint(root: &Path) -> Result<(), String> {
    component(root, "rustfmt");
    component(root, "clippy");
    cargo(root, &["fmt", "--all", "--check"])?;
    paper::check(root)?;
    cargo(root, &["clippy", "--quiet", "--workspace", "--all-targets", "--", "-D", "warnings"])?;
    run(Command::new("cargo")
        .args(["doc", "--quiet", "--workspace", "--no-deps", "--document-private-items"])
        .env("RUSTDOCFLAGS", "-D warnings")
        .current_dir(root))
}

fn test(root: &Path) -> Result<(), String> {
    // Benchmarks as tests only compile and run once; they are built by clippy above.
    cargo(root, &["test", "--workspace", "--lib", "--bins", "--tests", "--examples"])?;
    cargo(root, &["test", "--workspace", "--doc"])
}

/// Installs a toolchain component where rustup manages the toolchain and lacks it; elsewhere it is
/// the distribution's to bring, and the command that needs it says so.
fn component(root: &Path, name: &str) {
    let command = if name == "rustfmt" { "fmt" } else { name };
    let there = Command::new("cargo").args([command, "--version"]).current_dir(root).output();
    if !there.is_ok_and(|o| o.status.success()) {
        run(Command::new("rustup").args(["component", "add", name]).current_dir(root)).ok();
    }
}

fn cargo(root: &Path, args: &[&str]) -> Result<(), String> {
    run(Command::new("cargo").args(args).current_dir(root))
}

fn run(command: &mut Command) -> Result<(), String> {
    let words: Vec<_> = std::iter::once(command.get_program()).chain(command.get_args()).collect();
    let line = words.iter().map(|w| w.to_string_lossy()).collect::<Vec<_>>().join(" ");
    eprintln!("> {line}");
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("failed ({status}): {line}")),
        Err(e) => Err(format!("cannot run {line}: {e}")),
    }
}
