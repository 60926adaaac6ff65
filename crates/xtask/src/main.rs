//! `cargo xtask check`, `test`, `bindings`, `package`, `explorer`, `torture`: the steps of CI, also to run locally.

mod bindings;
mod explorer;
mod lint;
mod manifests;
mod paper;
mod portability;
mod run;
mod semver;
mod text;
mod tools;

use run::{Outcome, Report, cargo};
use std::path::Path;
use std::process::ExitCode;

const USAGE: &str = "\
usage: cargo xtask check | lint | test | bindings | package | paper | explorer | torture

  check    lint, then the fast tests and the documentation's examples
  lint     format, clippy, rustdoc, spelling, licences, manifests, the book, PAPER.md
  test     check, then the slow tests, the bindings' fast tests, other platforms, and a minute of torture
  bindings builds and tests the bindings for C, Python, Blender and Mitsuba, and the explorer; it names what it skips
  package  builds every package as crates.io would get it, and compares its interface with that of the last release
  paper    PAPER.md only: every symbol that it names exists, and it lists every departure that the code cites
  explorer builds the fibre explorer, a page with the model as WebAssembly: target/explorer/index.html; --try tests it
  torture  kills, full disks, damaged files and nonsense against the release build; --help lists its options";

/// A module for Python cannot be linked into a test program. [`bindings`] tests it.
const NO_PYTHON: &str = "--exclude=vellus-python";

/// The torture run of `cargo xtask test` has the same inputs each time.
const TORTURE: [&str; 4] = ["--time", "60s", "--seed", "1"];

fn main() -> ExitCode {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut report = Report::default();
    let result = match std::env::args().nth(1).as_deref() {
        Some("check") => check(&root, &mut report),
        Some("lint") => lint::all(&root, &mut report),
        Some("test") => test(&root, &mut report),
        Some("bindings") => bindings::all(&root, &mut report),
        Some("package") => manifests::package(&root, &mut report),
        Some("paper") => report.step("PAPER.md", || paper::check(&root)),
        Some("explorer") if std::env::args().nth(2).as_deref() == Some("--try") => {
            bindings::explorer_test(&root, &mut report)
        }
        Some("explorer") => report.step("fibre explorer", || explorer::build(&root)),
        Some("torture") => torture(&root, &std::env::args().skip(2).collect::<Vec<_>>()).map(|_| ()),
        _ => Err(USAGE.to_owned()),
    };
    report.print();
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

fn check(root: &Path, report: &mut Report) -> Result<(), String> {
    lint::all(root, report)?;
    // Benchmarks are compiled by clippy.
    report.step("fast tests", || {
        cargo(
            root,
            &[
                "test",
                "--quiet",
                "--workspace",
                NO_PYTHON,
                "--all-features",
                "--lib",
                "--bins",
                "--tests",
                "--examples",
            ],
        )
    })?;
    report
        .step("documentation examples", || cargo(root, &["test", "--quiet", "--workspace", "--all-features", "--doc"]))
}

fn test(root: &Path, report: &mut Report) -> Result<(), String> {
    check(root, report)?;
    report.step("slow tests", || {
        let tests = ["test", "--workspace", NO_PYTHON, "--all-features", "--lib", "--bins", "--tests"];
        cargo(root, &[&tests[..], &["--", "--ignored"]].concat())
    })?;
    bindings::fast(root, report)?;
    portability::all(root, report)?;
    report.attempt("torture", || torture(root, &TORTURE))
}

/// Runs the stress tests against the release build of the command.
fn torture(root: &Path, args: &[impl AsRef<str>]) -> Result<Outcome, String> {
    if !cfg!(unix) {
        return Ok(Outcome::Skipped("it needs Unix signals and process limits".to_owned()));
    }
    cargo(root, &["build", "--release", "--quiet", "--package", "vellus-cli", "--package", "vellus-torture"])?;
    let mut line = vec!["run", "--release", "--quiet", "--package", "vellus-torture", "--"];
    line.extend(args.iter().map(AsRef::as_ref));
    cargo(root, &line)?;
    Ok(Outcome::Passed)
}
