//! What the tests of the bindings need, compiled together with the test programs.

use crate::tests;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The files by the names of their targets.
pub struct Built {
    /// Programs and examples.
    pub programs: BTreeMap<String, PathBuf>,
    /// The module of the Python package.
    pub module: PathBuf,
}

/// Compiles all libraries and programs of the workspace.
pub fn build(root: &Path) -> Result<Built, String> {
    let (mut programs, mut module) = (BTreeMap::new(), None);
    for message in tests::compile(root)?.iter().filter(|message| message["profile"]["test"] == false) {
        let name = message["target"]["name"].as_str().unwrap_or_default();
        if let Some(file) = message["executable"].as_str() {
            programs.insert(name.to_owned(), PathBuf::from(file));
        }
        if name == "_vellus" {
            module = message["filenames"][0].as_str().map(PathBuf::from);
        }
    }
    let module = module.ok_or("cargo built no Python module _vellus")?;
    Ok(Built { programs, module })
}

impl Built {
    /// A program of the workspace.
    pub fn program(&self, name: &str) -> Result<&Path, String> {
        self.programs.get(name).map(PathBuf::as_path).ok_or_else(|| format!("cargo built no program {name}"))
    }
}
