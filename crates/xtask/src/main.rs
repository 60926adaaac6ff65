//! `cargo xtask`: the project's checks and tests in three tiers, and packaging.

mod bindings;
mod claims;
mod dist;
mod explorer;
mod lab;
mod lint;
mod manifests;
mod paper;
mod portability;
mod run;
mod semver;
mod tests;
mod text;
mod tiers;
mod tools;

use run::Report;
use std::path::Path;
use std::process::ExitCode;

const USAGE: &str = "\
usage: cargo xtask check [--all] | test | full | tests | lint | bindings | package | paper | claims | explorer | torture
                   generate | dist [PART …] | release --dry-run | c FOLDER | lab [--slow]

  check    before each commit: format, text, clippy, fast tests; --all adds rustdoc, spelling, licences, the book
  test     before each merge, and what CI runs: all of `check` but clippy, longer tests, the Python package, OpenUSD,
           and half a minute of torture
  full     at night and before a release: everything. Hours. A part that cannot run here is an error, unless
           VELLUS_REQUIRE=all,-gpu or VELLUS_REQUIRE_STEPS=all,-Blender excuse it
  tests    lists the tests that are not in `check`, with their tiers and the reasons
  lint     what `check --all` does, without tests
  bindings builds and tests the bindings for C, Python, Blender and Mitsuba, and the explorer; it names what it skips
  package  builds every package as crates.io would get it, and compares its interface with that of the last release
  dist     builds the files of a release into dist/, and tries each; with names (dist command c), these parts only
  release  --dry-run checks whether a release is ready, with package and dist; it publishes nothing
  c        FOLDER: installs the library for C and C++ into a prefix such as /usr/local
  paper    PAPER.md only: every symbol that it names exists, and it lists every departure that the code cites
  generate writes what tests compare: code and tables in documents, and the golden vectors
  claims   lists the numbers in README and the book with what proves each, and fails for those without proof
  explorer builds the fibre explorer, a page with the model as WebAssembly: target/explorer/index.html; --try tests it
  torture  kills, full disks, damaged files and nonsense against the command; --help lists its options
  lab      format, clippy and fast tests of lab/; --slow adds its slow tests

VELLUS_REQUIRE lists kinds of tests that must not be skipped, such as gpu,openusd, and VELLUS_REQUIRE_STEPS steps.";

fn main() -> ExitCode {
    // `cargo` leaves `..` in the path, which would be in every message.
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
    let root = manifest.ancestors().nth(2).unwrap_or(manifest).to_owned();
    let mut report = Report::new(&root);
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let result = match words.as_slice() {
        ["check"] => tiers::check(&root, &mut report),
        ["check", "--all"] => tiers::check(&root, &mut report).and_then(|()| lint::more(&root, &mut report)),
        ["test"] => tiers::test(&root, &mut report),
        ["full"] => tiers::full(&root, &mut report),
        ["tests"] => tests::build(&root).map(|programs| tests::print(&programs)),
        ["lint"] => lint::fast(&root, &mut report).and_then(|()| lint::more(&root, &mut report)),
        ["bindings"] => bindings::all(&root, &mut report),
        ["package"] => manifests::package(&root, &mut report),
        ["dist", parts @ ..] => dist::all(&root, &mut report, parts),
        ["release", "--dry-run"] => dist::release::dry_run(&root, &mut report),
        ["c", folder] => install_c(&root, &mut report, folder),
        ["paper"] => report.step("PAPER.md", 1.0, || paper::check(&root)),
        ["generate"] => tests::build(&root).and_then(|programs| tests::generate(&programs)),
        ["claims"] => claims::print(&root).and_then(|()| report.step("claims", 1.0, || claims::check(&root))),
        ["explorer", "--try"] => bindings::explorer_test(&root, &mut report),
        ["lab"] => lab::check(&root, &mut report, false),
        ["lab", "--slow"] => lab::check(&root, &mut report, true),
        ["explorer"] => report.step("fibre explorer", 15.0, || explorer::build(&root)),
        ["torture", options @ ..] => tiers::torture(&root, options).map(|_| ()),
        _ => Err(USAGE.to_owned()),
    };
    let result = result.and(report.print());
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

/// Installs the library for C into a folder.
fn install_c(root: &Path, report: &mut Report, folder: &str) -> Result<(), String> {
    let folder = std::path::absolute(folder).map_err(|e| format!("{folder}: {e}"))?;
    report.step("library for C", 8.0, || bindings::c::install(root, &folder))
}
