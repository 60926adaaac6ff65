//! `cargo xtask dist`: what a release uploads, in the folder `dist`. Each file is built once and tried as its users
//! would.

mod archive;
mod blender;
mod c_library;
mod checksums;
mod command;
mod licences;
mod old_processor;
mod packages;
mod python;
pub mod release;
mod sandbox;
mod sbom;
mod shaders;
mod toolchain;
mod try_c;
mod try_command;

use crate::explorer;
use crate::run::{Outcome, Report, output};
pub use c_library::install as install_c_library;
use command::Build;
use sandbox::Sandbox;
use std::path::{Path, PathBuf};
use std::process::Command;
use toolchain::Toolchain;

/// All crates have one version.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The parts that can be named, to build nothing else.
const PARTS: [&str; 7] = ["command", "baseline", "python", "source", "c", "explorer", "shaders"];

/// The list of the packages in all files.
fn sbom_name() -> String {
    format!("vellus-{VERSION}.cdx.json")
}

/// What every part needs.
struct Dist {
    root: PathBuf,
    /// The folder of the files for a release.
    out: PathBuf,
    tools: Toolchain,
}

impl Dist {
    /// A folder in `target/dist`.
    fn folder(&self, name: &str) -> PathBuf {
        self.root.join("target/dist").join(name)
    }

    /// An empty folder in `target/dist`.
    fn empty(&self, name: &str) -> Result<PathBuf, String> {
        let folder = self.folder(name);
        std::fs::remove_dir_all(&folder).ok();
        std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        Ok(folder)
    }

    /// The file for a release whose name begins and ends like this.
    fn file(&self, start: &str, end: &str) -> Result<PathBuf, String> {
        let files = self.out.read_dir().map_err(|e| format!("{}: {e}", self.out.display()))?;
        let mut names = files.flatten().map(|file| file.file_name().to_string_lossy().into_owned());
        let name = names.find(|name| name.starts_with(start) && name.ends_with(end));
        name.map(|name| self.out.join(name)).ok_or_else(|| format!("dist has no {start}*{end}"))
    }
}

/// Builds and tries all files, or those of the named parts.
pub fn all(root: &Path, report: &mut Report, parts: &[&str]) -> Result<(), String> {
    if let Some(unknown) = parts.iter().find(|part| !PARTS.contains(part)) {
        return Err(format!("dist has no part {unknown}: name some of {}, or none for all", PARTS.join(", ")));
    }
    let wanted = |part: &str| parts.is_empty() || parts.contains(&part);
    let dist = Dist { root: root.to_owned(), out: root.join("dist"), tools: Toolchain::new(root)? };
    if parts.is_empty() {
        // Nothing of an earlier version is left.
        std::fs::remove_dir_all(&dist.out).ok();
    }
    std::fs::create_dir_all(&dist.out).map_err(|e| format!("{}: {e}", dist.out.display()))?;
    report.attempt(&format!("zig, for glibc {}", toolchain::GLIBC), 15.0, || Ok(dist.tools.outcome()))?;
    commands(&dist, report, wanted)?;
    if wanted("c") {
        let archive = step(report, "library for C", || c_library::build(&dist))?;
        try_c::all(&dist, report, &archive)?;
    }
    if wanted("python") {
        match &dist.tools.python {
            Ok(_) => python_and_blender(&dist, report)?,
            Err(reason) => {
                report.attempt("wheel and Blender's extension", 15.0, || Ok(Outcome::Skipped(reason.clone())))?
            }
        }
    }
    if wanted("source") {
        match &dist.tools.python {
            Ok(_) => {
                let source = step(report, "source for pip", || python::source(&dist))?;
                report.attempt("source for pip, installed", 15.0, || python::test(&dist, &source))?;
            }
            Err(reason) => report.attempt("source for pip", 15.0, || Ok(Outcome::Skipped(reason.clone())))?,
        }
    }
    if wanted("shaders") {
        step(report, "shaders", || shaders::build(&dist))?;
    }
    if wanted("explorer") {
        report.attempt("fibre explorer", 15.0, || page(&dist))?;
    }
    // With some parts only, the folder is of no single commit.
    let commit = if parts.is_empty() { commit(root) } else { "several".to_owned() };
    report.step("list of packages", 15.0, || list(&dist, &commit))?;
    report.step("checksums", 15.0, || checksums::write(&dist.out))
}

/// The archives of the command.
fn commands(dist: &Dist, report: &mut Report, wanted: impl Fn(&str) -> bool) -> Result<(), String> {
    let x86 = dist.tools.triple.starts_with("x86_64");
    let builds = [("command", Build::Usual, true), ("baseline", Build::Baseline, x86)];
    let mut archives = Vec::new();
    for (name, build, exists) in builds {
        if exists && wanted(name) {
            archives.push(step(report, &format!("command ({name})"), || command::build(dist, build))?);
        }
    }
    if archives.is_empty() {
        return Ok(());
    }
    let mut sandbox = Sandbox::Here(dist.folder("try/command"));
    report.attempt("empty Debian to try the command in", 15.0, || match Sandbox::debian(dist) {
        Ok(debian) => {
            sandbox = debian;
            Ok(Outcome::Passed)
        }
        Err(reason) => Ok(Outcome::Skipped(format!("{reason}; an empty folder and environment replace it"))),
    })?;
    archives.iter().try_for_each(|archive| try_command::all(report, &sandbox, archive))
}

/// The wheel, and Blender's extension with the wheel in it.
fn python_and_blender(dist: &Dist, report: &mut Report) -> Result<(), String> {
    let wheel = step(report, "wheel", || python::wheel(dist))?;
    report.step("licences in the wheel", 15.0, || python::has_licences(dist, &wheel))?;
    report.attempt("wheel, installed", 15.0, || python::test(dist, &wheel))?;
    report.attempt("wheel without AVX2", 15.0, || python::without_avx2(dist))?;
    let extension = step(report, "Blender's extension", || blender::build(dist, &wheel))?;
    report.step("contents of Blender's extension", 15.0, || blender::test(&extension, &wheel))
}

/// The page of the fibre explorer.
fn page(dist: &Dist) -> Result<Outcome, String> {
    if let Some(reason) = explorer::missing(&dist.root) {
        return Ok(Outcome::Skipped(reason));
    }
    explorer::build(&dist.root)?;
    let file = dist.out.join(format!("vellus-explorer-{VERSION}.html"));
    command::copy(&dist.root.join("target/explorer/index.html"), &file)?;
    Ok(Outcome::Passed)
}

/// Writes the list of the packages in all files, with the commit that they were built from.
fn list(dist: &Dist, commit: &str) -> Result<(), String> {
    let ours = ["vellus-cli", "vellus-python", "vellus-c", "vellus-views"];
    let packages = packages::compiled_into(&dist.root, &ours, &dist.tools.triple)?;
    let document = sbom::document(&packages, commit);
    let text = serde_json::to_string_pretty(&document).map_err(|e| e.to_string())?;
    let name = sbom_name();
    std::fs::write(dist.out.join(&name), text + "\n").map_err(|e| format!("{name}: {e}"))
}

/// The commit of the working folder, `unknown` without git, and marked if files were changed since.
fn commit(root: &Path) -> String {
    let git = |args: &[&str]| output(Command::new("git").args(args).current_dir(root));
    match (git(&["rev-parse", "HEAD"]), git(&["status", "--porcelain"])) {
        (Ok(commit), Ok(changes)) if changes.is_empty() => commit.trim().to_owned(),
        (Ok(commit), Ok(_)) => format!("{} and changes", commit.trim()),
        _ => "unknown".to_owned(),
    }
}

/// A step whose result is a file, which it prints with its size.
fn step(report: &mut Report, name: &str, work: impl FnOnce() -> Result<PathBuf, String>) -> Result<PathBuf, String> {
    let mut file = PathBuf::new();
    report.step(name, 15.0, || {
        file = work()?;
        let size = std::fs::metadata(&file).map_err(|e| format!("{}: {e}", file.display()))?.len();
        println!("dist/{}: {size} bytes", file.file_name().unwrap_or_default().to_string_lossy());
        Ok(())
    })?;
    Ok(file)
}
