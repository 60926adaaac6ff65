//! `cargo xtask release --dry-run`: the part of RELEASING.md that a machine can check. It publishes nothing.

use super::{VERSION, checksums, sbom, sbom_name};
use crate::manifests;
use crate::run::{Report, output};
use std::path::Path;
use std::process::Command;

/// Checks versions, placeholders and the state of git, builds all packages and files, and prints what is left.
pub fn dry_run(root: &Path, report: &mut Report) -> Result<(), String> {
    let mut missing = versions(root)?;
    missing.extend(placeholders(root)?);
    missing.extend(git(root));
    manifests::package(root, report)?;
    match fresh(root) {
        Ok(()) => println!("dist has the files of this commit"),
        Err(reason) => {
            println!("dist is built: {reason}");
            super::all(root, report, &[])?;
        }
    }
    println!("\nFor a person (RELEASING.md):");
    read(root, "RELEASING.md")?.lines().filter(|line| line.starts_with("- [ ] ")).for_each(|line| println!("{line}"));
    if missing.is_empty() {
        println!("\nVersion {VERSION} is ready for them.");
        return Ok(());
    }
    Err(format!("version {VERSION} is not ready:\n- {}", missing.join("\n- ")))
}

/// Where a file has another version than the others, or no date.
fn versions(root: &Path) -> Result<Vec<String>, String> {
    let mut missing = Vec::new();
    let manifest = read(root, "Cargo.toml")?;
    for line in manifest.lines().filter(|line| line.contains("path = \"crates/") && line.contains("version = ")) {
        if !line.contains(&format!("version = \"={VERSION}\"")) {
            missing.push(format!("Cargo.toml: {line}: another version than {VERSION}"));
        }
    }
    for (file, line) in [
        ("CITATION.cff", format!("version: {VERSION}")),
        ("integrations/blender/vellus_blender/blender_manifest.toml", format!("version = \"{VERSION}\"")),
        // maturin takes the version from Cargo.toml.
        ("crates/vellus-python/pyproject.toml", "dynamic = [\"version\"]".to_owned()),
    ] {
        if !read(root, file)?.lines().any(|found| found == line) {
            missing.push(format!("{file}: no line {line}"));
        }
    }
    let released = read(root, "CHANGELOG.md")?.lines().find_map(released);
    let citation = read(root, "CITATION.cff")?;
    match released {
        None => missing.push(format!("CHANGELOG.md: no heading ## [{VERSION}] - YYYY-MM-DD")),
        Some(date) if citation.contains(&format!("date-released: {date}")) => {}
        Some(date) => missing.push(format!("CITATION.cff: no line date-released: {date}, as in CHANGELOG.md")),
    }
    Ok(missing)
}

/// The date in the changelog's heading of this version.
fn released(line: &str) -> Option<String> {
    let date = line.strip_prefix(&format!("## [{VERSION}] - "))?.trim();
    let is_date = date.len() == 10 && date.split('-').map(str::len).eq([4, 2, 2]);
    is_date.then(|| date.to_owned())
}

/// What nobody has filled in yet.
fn placeholders(root: &Path) -> Result<Vec<String>, String> {
    let mut missing = Vec::new();
    for (file, text, what) in [
        ("Cargo.toml", manifests::PLACEHOLDER, "`repository` is a placeholder"),
        ("CITATION.cff", manifests::PLACEHOLDER, "`repository-code` is a placeholder"),
        ("CITATION.cff", "name: The Vellus authors", "the authors have no names"),
    ] {
        if read(root, file)?.contains(text) {
            missing.push(format!("{file}: {what}"));
        }
    }
    Ok(missing)
}

/// Files that are not committed, and a tag of this version on another commit.
fn git(root: &Path) -> Vec<String> {
    let git = |args: &[&str]| output(Command::new("git").args(args).current_dir(root));
    let mut missing = Vec::new();
    match git(&["status", "--porcelain"]) {
        Ok(changes) if changes.is_empty() => {}
        Ok(changes) => missing.push(format!("{} files are not committed", changes.lines().count())),
        Err(reason) => missing.push(format!("git: {reason}")),
    }
    let tag = git(&["rev-parse", "--verify", "--quiet", &format!("v{VERSION}^{{commit}}")]);
    if tag.is_ok_and(|tag| Ok(tag) != git(&["rev-parse", "HEAD"])) {
        missing.push(format!("the tag v{VERSION} exists and is another commit"));
    }
    missing
}

/// Whether `dist` has all files of this commit, as they were built.
fn fresh(root: &Path) -> Result<(), String> {
    let out = root.join("dist");
    let sums = std::fs::read_to_string(out.join(checksums::FILE)).map_err(|_| format!("no {}", checksums::FILE))?;
    let list = std::fs::read_to_string(out.join(sbom_name())).map_err(|_| format!("no {}", sbom_name()))?;
    let (built, now) = (sbom::commit(&list).unwrap_or_default(), super::commit(root));
    if built != now || !now.chars().all(|c| c.is_ascii_hexdigit()) {
        return Err(format!("it is from commit {built}, and this is {now}"));
    }
    if checksums::of(&out)? != sums { Err(format!("{} is not that of its files", checksums::FILE)) } else { Ok(()) }
}

fn read(root: &Path, name: &str) -> Result<String, String> {
    std::fs::read_to_string(root.join(name)).map_err(|e| format!("{name}: {e}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_heading_of_a_release_has_a_date() {
        assert_eq!(released(&format!("## [{VERSION}] - 2026-11-25")).as_deref(), Some("2026-11-25"));
        for line in [format!("## [{VERSION}]"), format!("## [{VERSION}] - soon"), "## [Unreleased]".to_owned()] {
            assert_eq!(released(&line), None, "{line}");
        }
    }

    #[test]
    fn all_files_of_the_repository_have_one_version() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let disagreeing = versions(&root).unwrap();
        // Before a release, only the changelog and the date are missing.
        assert!(
            disagreeing.iter().all(|line| line.starts_with("CHANGELOG") || line.contains("date")),
            "{disagreeing:?}"
        );
    }
}
