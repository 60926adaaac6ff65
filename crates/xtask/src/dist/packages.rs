//! The packages that a file of the release was compiled from.

use crate::run::output;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A package.
#[derive(Clone, Default)]
pub struct Package {
    pub name: String,
    pub version: String,
    pub licence: String,
    /// Its SHA-256 in Cargo.lock. Ours have none.
    pub checksum: Option<String>,
    pub folder: PathBuf,
    /// The identifiers of what it is compiled from.
    pub dependencies: Vec<String>,
}

impl Package {
    /// Its package URL.
    pub fn purl(&self) -> String {
        format!("pkg:cargo/{}@{}", self.name, self.version)
    }
}

/// These packages of ours and everything that they are compiled from for a platform, by identifier. Dependencies of
/// tests and build scripts are left out.
pub fn compiled_into(root: &Path, ours: &[&str], triple: &str) -> Result<BTreeMap<String, Package>, String> {
    let mut command = Command::new("cargo");
    command.args(["metadata", "--format-version", "1", "--locked", "--filter-platform", triple]).current_dir(root);
    let metadata: Value = serde_json::from_str(&output(&mut command)?).map_err(|e| e.to_string())?;
    let lock = std::fs::read_to_string(root.join("Cargo.lock")).map_err(|e| format!("Cargo.lock: {e}"))?;
    let checksums = checksums(&lock);
    let mut all: BTreeMap<String, Package> = BTreeMap::new();
    for package in elements(&metadata["packages"]) {
        let (name, version) = (text(&package["name"]), text(&package["version"]));
        let checksum = checksums.get(&(name.clone(), version.clone())).cloned();
        let folder = Path::new(&text(&package["manifest_path"])).parent().unwrap_or(root).to_owned();
        // Old manifests have a slash between two licences.
        let licence = text(&package["license"]).replace('/', " OR ");
        let id = text(&package["id"]);
        all.insert(id, Package { name, version, licence, checksum, folder, dependencies: Vec::new() });
    }
    for node in elements(&metadata["resolve"]["nodes"]) {
        let normal = |dependency: &&Value| elements(&dependency["dep_kinds"]).any(|kind| kind["kind"].is_null());
        let dependencies = elements(&node["deps"]).filter(normal).map(|dependency| text(&dependency["pkg"]));
        if let Some(package) = all.get_mut(&text(&node["id"])) {
            package.dependencies = dependencies.collect();
        }
    }
    let mut found = BTreeSet::new();
    let is_ours = |package: &Package| ours.contains(&package.name.as_str()) && package.checksum.is_none();
    let mut next: Vec<String> = all.iter().filter(|(_, package)| is_ours(package)).map(|(id, _)| id.clone()).collect();
    while let Some(id) = next.pop() {
        if let Some(package) = all.get(&id).filter(|_| found.insert(id.clone())) {
            next.extend(package.dependencies.iter().cloned());
        }
    }
    all.retain(|id, _| found.contains(id));
    Ok(all)
}

/// The checksums in the text of Cargo.lock, by name and version.
fn checksums(lock: &str) -> BTreeMap<(String, String), String> {
    let field = |block: &str, name: &str| {
        let start = format!("{name} = \"");
        block.lines().find_map(|line| Some(line.strip_prefix(&start)?.trim_end_matches('"').to_owned()))
    };
    let blocks = lock.split("[[package]]");
    blocks.filter_map(|b| Some(((field(b, "name")?, field(b, "version")?), field(b, "checksum")?))).collect()
}

fn elements(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

fn text(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_contains_what_it_is_compiled_from_and_no_tools_of_tests() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let packages = compiled_into(&root, &["vellus-cli"], "x86_64-unknown-linux-gnu").unwrap();
        let has = |name: &str| packages.values().find(|package| package.name == name);
        assert!(has("vellus").unwrap().checksum.is_none());
        assert_eq!(has("clap").unwrap().checksum.as_ref().unwrap().len(), 64);
        assert!(has("clap_mangen").is_none() && has("pyo3").is_none() && has("xtask").is_none());
        assert!(has("clap").unwrap().licence.contains("MIT OR Apache-2.0"));
    }
}
