//! The three tiers: `check` before each commit, `test` before each merge, `full` at night and before a release.

use crate::bindings::{self, openusd};
use crate::run::{Outcome, Report, cargo, run};
use crate::tests::{self, Tier};
use crate::{lab, lint, portability};
use std::path::Path;
use std::process::Command;

/// The torture run of `test` has the same inputs each time.
const SHORT: [&str; 4] = ["--time", "30s", "--seed", "1"];

/// That of `full` has others each time. It prints the seed.
const LONG: [&str; 2] = ["--time", "10m"];

/// Format, text, clippy and the fast tests.
pub fn check(root: &Path, report: &mut Report) -> Result<(), String> {
    lint::fast(root, report)?;
    programs(root, report, Tier::Check)
}

/// What CI runs.
pub fn test(root: &Path, report: &mut Report) -> Result<(), String> {
    lint::text(root, report)?;
    programs(root, report, Tier::Test)?;
    bindings::fast(root, report)?;
    report.attempt("torture", 2.0, || torture(root, &SHORT))
}

/// Everything. What cannot run is an error, unless the variables say otherwise.
pub fn full(root: &Path, report: &mut Report) -> Result<(), String> {
    for required in report.required.iter_mut().filter(|list| list.is_empty()) {
        "all".clone_into(required);
    }
    lint::fast(root, report)?;
    lint::more(root, report)?;
    programs(root, report, Tier::Full)?;
    bindings::all(root, report)?;
    portability::all(root, report)?;
    lab::check(root, report, true)?;
    report.attempt("torture", 15.0, || torture(root, &LONG))
}

/// Compiles and runs the tests of a tier, and the examples in the documentation.
fn programs(root: &Path, report: &mut Report, tier: Tier) -> Result<(), String> {
    let mut found = Vec::new();
    report.step("test programs", 10.0, || {
        found = tests::build(root)?;
        Ok(())
    })?;
    let mut environment =
        vec![("VELLUS_SKIPPED", report.skipped.display().to_string()), ("VELLUS_REQUIRE", report.required[0].clone())];
    if tier > Tier::Check {
        report.attempt("Python with OpenUSD", 1.0, || match openusd::path(root) {
            Ok(path) => {
                environment.push(("PATH", path));
                Ok(Outcome::Passed)
            }
            Err(reason) => Ok(Outcome::Skipped(reason)),
        })?;
    }
    let minutes = match tier {
        Tier::Check => 5.0,
        Tier::Test => 10.0,
        Tier::Full => 90.0,
    };
    let mut times = Vec::new();
    report.step("tests", minutes, || {
        let summary = tests::run(&found, tier, &root.join("target/tests"), &environment)?;
        eprintln!("{} tests passed", summary.count);
        times = summary.times;
        Ok(())
    })?;
    report.times.append(&mut times);
    report.step("examples in the documentation", 4.0, || {
        // The comments of the command are help texts.
        cargo(root, &["test", "--quiet", "--workspace", "--exclude=vellus-cli", "--all-features", "--doc"])
    })
}

/// Runs the stress tests against the command, as the tests were compiled.
pub fn torture(root: &Path, options: &[&str]) -> Result<Outcome, String> {
    if !cfg!(unix) {
        return Ok(Outcome::Skipped("it needs Unix signals and process limits".to_owned()));
    }
    let built = bindings::build(root)?;
    run(Command::new(built.program("vellus-torture")?).args(options).current_dir(root))?;
    Ok(Outcome::Passed)
}
