//! The requirements of crates.io for every package.

use crate::run::{Outcome, Report, cargo, output};
use crate::semver;
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// The most crates that are published. Each is a promise to its users.
const MOST: usize = 10;

/// The largest package that crates.io accepts, in bytes.
const LARGEST: u64 = 10 << 20;

/// The domain of the placeholder for the repository's address.
pub const PLACEHOLDER: &str = "example.org";

/// Checks the manifests of all packages that are published. The message lists every problem.
pub fn check(root: &Path) -> Result<(), String> {
    let packages = packages(root)?;
    let (public, private): (Vec<_>, Vec<_>) = packages.iter().partition(|package| published(package));
    let mut problems = Vec::new();
    if public.len() > MOST {
        problems.push(format!("{} crates are published, expected at most {MOST}", public.len()));
    }
    for package in public {
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
            if let Some(problem) = problem(dependency, &private, &exactly(package)) {
                problems.push(format!("{name}: the dependency {}{problem}", self::name(dependency)));
            }
        }
    }
    if problems.is_empty() { Ok(()) } else { Err(problems.join("\n")) }
}

/// The problem of a dependency of a published package, if it has one. `exactly` requires the package's own version.
fn problem(dependency: &Value, private: &[&Value], exactly: &str) -> Option<&'static str> {
    let unversioned = dependency["path"].is_string() && dependency["req"] == "*";
    // Cargo leaves development dependencies without a version out of the published manifest.
    if unversioned && dependency["kind"] == "dev" {
        return None;
    }
    if private.iter().any(|package| name(package) == name(dependency)) {
        return Some(" is not published");
    }
    if unversioned {
        return Some(" has no version");
    }
    // The feature is exempt from semantic versioning, so another version may not compile.
    let unstable = dependency["features"].as_array().is_some_and(|features| features.iter().any(|f| f == "unstable"));
    (name(dependency) == "vellus" && unstable && dependency["req"] != exactly)
        .then_some(" has the feature `unstable`, and must require exactly this version, as in `=0.1.0`")
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
    report.attempt("semantic versions", 10.0, || semver::check(root))?;
    report.attempt("address of the repository", 10.0, || {
        let missing = public.iter().any(|p| p["repository"].as_str().is_some_and(|url| url.contains(PLACEHOLDER)));
        let reason = "`repository` in Cargo.toml is a placeholder: replace it before a release";
        Ok(if missing { Outcome::Skipped(reason.to_owned()) } else { Outcome::Passed })
    })
}

/// The packages of the workspace, as `cargo metadata` describes them.
pub fn packages(root: &Path) -> Result<Vec<Value>, String> {
    let mut command = Command::new("cargo");
    command.args(["metadata", "--no-deps", "--format-version", "1"]).current_dir(root);
    let mut metadata: Value = serde_json::from_str(&output(&mut command)?).map_err(|e| e.to_string())?;
    serde_json::from_value(metadata["packages"].take()).map_err(|e| e.to_string())
}

/// The requirement of exactly the version of a package.
fn exactly(package: &Value) -> String {
    format!("={}", package["version"].as_str().unwrap_or_default())
}

/// The name of a package or a dependency.
fn name(package: &Value) -> &str {
    package["name"].as_str().unwrap_or_default()
}

/// `publish = false` is an empty list of registries.
fn published(package: &Value) -> bool {
    package["publish"].as_array().is_none_or(|registries| !registries.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn dependencies_are_published_with_their_versions() {
        let private = json!({ "name": "vellus-cli" });
        let problem = |name: &str, kind: Value, req: &str, features: &[&str]| {
            let dependency = json!({ "name": name, "kind": kind, "req": req, "path": "/", "features": features });
            problem(&dependency, &[&private], "=0.1.0").unwrap_or_default().to_owned()
        };
        assert_eq!(problem("vellus", Value::Null, "=0.1.0", &["unstable"]), "");
        assert_eq!(problem("vellus-io", Value::Null, "^0.1.0", &[]), "");
        assert_eq!(problem("vellus-cli", json!("dev"), "*", &[]), "");
        assert!(problem("vellus", Value::Null, "^0.1.0", &["unstable"]).contains("exactly this version"));
        assert!(problem("vellus-io", Value::Null, "*", &[]).contains("no version"));
        assert!(problem("vellus-cli", Value::Null, "*", &[]).contains("not published"));
        assert!(problem("vellus-cli", json!("dev"), "^0.1.0", &[]).contains("not published"));
    }
}
