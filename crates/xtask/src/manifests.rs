//! The requirements of crates.io for every package.

use crate::run::{Outcome, Report, cargo, output};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// The largest package that crates.io accepts, in bytes.
const LARGEST: u64 = 10 << 20;

/// The domain of the placeholder for the repository's address.
pub const PLACEHOLDER: &str = "example.org";

/// Checks the manifests of all packages that are published. The message lists every problem.
pub fn check(root: &Path) -> Result<(), String> {
    let packages = packages(root)?;
    let mut problems = Vec::new();
    for package in packages.iter().filter(|package| published(package)) {
        let name = name(package);
        for field in ["description", "license", "repository", "readme"] {
            if !package[field].is_string() {
                problems.push(format!("{name}: the manifest has no {field}"));
            }
        }
        for (field, most) in [("keywords", 5), ("categories", 5)] {
            let count = package[field].as_array().map_or(0, Vec::len);
            if !(1..=most).contains(&count) {
                problems.push(format!("{name}: {count} {field}, expected 1 to {most}"));
            }
        }
        let folder = Path::new(package["manifest_path"].as_str().unwrap_or_default()).parent().unwrap_or(root);
        for file in ["README.md", "LICENSE-MIT", "LICENSE-APACHE"] {
            if !folder.join(file).exists() {
                problems.push(format!("{name}: {file} is missing"));
            }
        }
        for dependency in package["dependencies"].as_array().into_iter().flatten() {
            // Cargo leaves development dependencies without a version out of the published manifest.
            if dependency["kind"] != "dev" && dependency["path"].is_string() && dependency["req"] == "*" {
                let dependency = dependency["name"].as_str().unwrap_or_default();
                problems.push(format!("{name}: the path dependency {dependency} has no version"));
            }
        }
    }
    if problems.is_empty() { Ok(()) } else { Err(problems.join("\n")) }
}

/// Builds every package as crates.io would get it, and checks its size.
pub fn package(root: &Path, report: &mut Report) -> Result<(), String> {
    report.step("manifests", 10.0, || check(root))?;
    let packages = packages(root)?;
    let (public, private): (Vec<_>, Vec<_>) = packages.iter().partition(|package| published(package));
    report.step("packages", 10.0, || {
        let mut line = vec!["package", "--workspace", "--quiet"];
        line.extend(private.iter().flat_map(|package| ["--exclude", name(package)]));
        cargo(root, &line)
    })?;
    report.step("sizes", 10.0, || {
        for package in &public {
            let version = package["version"].as_str().unwrap_or_default();
            let path = root.join(format!("target/package/{}-{version}.crate", name(package)));
            let size = std::fs::metadata(&path).map_err(|e| format!("{}: {e}", path.display()))?.len();
            if size > LARGEST {
                return Err(format!("{}: {size} bytes, crates.io accepts {LARGEST}", name(package)));
            }
        }
        Ok(())
    })?;
    report.attempt("address of the repository", 10.0, || {
        let missing = public.iter().any(|p| p["repository"].as_str().is_some_and(|url| url.contains(PLACEHOLDER)));
        let reason = "`repository` in Cargo.toml is a placeholder: replace it before a release";
        Ok(if missing { Outcome::Skipped(reason.to_owned()) } else { Outcome::Passed })
    })
}

fn packages(root: &Path) -> Result<Vec<Value>, String> {
    let mut command = Command::new("cargo");
    command.args(["metadata", "--no-deps", "--format-version", "1"]).current_dir(root);
    let mut metadata: Value = serde_json::from_str(&output(&mut command)?).map_err(|e| e.to_string())?;
    serde_json::from_value(metadata["packages"].take()).map_err(|e| e.to_string())
}

fn name(package: &Value) -> &str {
    package["name"].as_str().unwrap_or_default()
}

/// `publish = false` is an empty list of registries.
fn published(package: &Value) -> bool {
    package["publish"].as_array().is_none_or(|registries| !registries.is_empty())
}
