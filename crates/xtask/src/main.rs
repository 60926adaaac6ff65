//! `cargo xtask test`: all that CI checks, in the order in which it fails fastest. `cargo xtask torture`: attacks on
//! the command.

mod paper;

use std::path::Path;
use std::process::{Command, ExitCode};

const USAGE: &str = "usage: cargo xtask test | lint | paper | torture

  test     formatting, clippy, docs, PAPER.md, all tests, a minute of torture: what CI runs
  lint     formatting, clippy, docs, PAPER.md only
  paper    PAPER.md only: every symbol it names exists, every departure in the code is listed
  torture  kills, full disks, damaged files and nonsense against the release build; --help lists its options";

/// The torture of `cargo xtask test`: the same inputs each time.
const TORTURE: [&str; 4] = ["--time", "60s", "--seed", "1"];

fn main() -> ExitCode {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let result = match std::env::args().nth(1).as_deref() {
        Some("test") => lint(&root).and_then(|()| test(&root)),
        Some("lint") => lint(&root),
        Some("paper") => paper::check(&root),
        Some("torture") => torture(&root, &std::env::args().skip(2).collect::<Vec<_>>()),
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
    doc(root)
}

/// Checks the documentation, of private items too, and leaves that of public items in `target/doc`.
fn doc(root: &Path) -> Result<(), String> {
    let doc = |more: &[&str]| {
        run(Command::new("cargo")
            .args(["doc", "--quiet", "--workspace", "--no-deps"])
            .args(more)
            .env("RUSTDOCFLAGS", "-D warnings")
            .current_dir(root))
    };
    doc(&["--document-private-items"])?;
    // Pages of private items would stay and mislead readers.
    std::fs::remove_dir_all(root.join("target/doc")).ok();
    doc(&[])
}

fn test(root: &Path) -> Result<(), String> {
    // Benchmarks as tests only compile and run once; they are built by clippy above.
    cargo(root, &["test", "--workspace", "--lib", "--bins", "--tests", "--examples"])?;
    cargo(root, &["test", "--workspace", "--doc"])?;
    torture(root, &TORTURE)
}

/// Attacks the release build of the command.
fn torture(root: &Path, args: &[impl AsRef<str>]) -> Result<(), String> {
    if !cfg!(unix) {
        eprintln!("torture is left out: signals and limits of processes are those of Unix");
        return Ok(());
    }
    cargo(root, &["build", "--release", "--quiet", "--package", "vellus-cli", "--package", "vellus-torture"])?;
    let mut line = vec!["run", "--release", "--quiet", "--package", "vellus-torture", "--"];
    line.extend(args.iter().map(AsRef::as_ref));
    cargo(root, &line)
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
