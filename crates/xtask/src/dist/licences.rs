//! The licences of everything that a file was compiled from. Those of most packages ask for a copy in every binary.

use super::packages::Package;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// The name of the file that [`others`] writes.
pub const OTHERS: &str = "THIRD-PARTY-LICENSES.txt";

/// How the names of files with licences begin.
const FILES: [&str; 6] = ["license", "licence", "copying", "copyright", "notice", "unlicense"];

/// All licences of packages that are not ours, each text once, below the names of its packages.
pub fn others<'a>(packages: impl IntoIterator<Item = &'a Package>) -> Result<String, String> {
    let mut texts: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for package in packages.into_iter().filter(|package| package.checksum.is_some()) {
        let name = format!("{} {} ({})", package.name, package.version, package.licence);
        let found = in_folder(&package.folder).map_err(|e| format!("{}: {e}", package.folder.display()))?;
        let found = if found.is_empty() { vec!["The package has no file with its licence.".to_owned()] } else { found };
        for text in found {
            texts.entry(text).or_default().push(name.clone());
        }
    }
    let mut texts: Vec<(Vec<String>, String)> = texts.into_iter().map(|(text, names)| (names, text)).collect();
    texts.sort();
    let mut all =
        String::from("Vellus contains the following packages. Each text is below the names of its packages.\n");
    for (names, text) in texts {
        let line = "=".repeat(80);
        write!(all, "\n{line}\n{}\n{line}\n\n{text}\n", names.join("\n")).map_err(|e| e.to_string())?;
    }
    Ok(all)
}

/// The texts of the licences in a folder. Line ends and spaces around the text do not count.
fn in_folder(folder: &Path) -> std::io::Result<Vec<String>> {
    let mut texts = Vec::new();
    for entry in folder.read_dir()? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
        if path.is_file() && FILES.iter().any(|start| name.starts_with(start)) {
            let text = String::from_utf8_lossy(&std::fs::read(&path)?).replace("\r\n", "\n");
            texts.push(text.trim().to_owned());
        }
    }
    texts.sort();
    texts.dedup();
    Ok(texts)
}

/// Copies our licences into a folder, and writes those of others beside them.
pub fn copy<'a>(root: &Path, folder: &Path, packages: impl IntoIterator<Item = &'a Package>) -> Result<(), String> {
    for name in ["LICENSE-MIT", "LICENSE-APACHE"] {
        std::fs::copy(root.join(name), folder.join(name)).map_err(|e| format!("{name}: {e}"))?;
    }
    std::fs::write(folder.join(OTHERS), others(packages)?).map_err(|e| format!("{OTHERS}: {e}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_that_two_packages_share_is_there_once() {
        let folder = std::env::temp_dir().join(format!("vellus-licences-{}", std::process::id()));
        let package = |name: &str, text: &str| {
            let folder = folder.join(name);
            std::fs::create_dir_all(&folder).unwrap();
            std::fs::write(folder.join("License-MIT"), text).unwrap();
            Package { name: name.to_owned(), checksum: Some(String::new()), folder, ..Package::default() }
        };
        let packages = [package("one", "the same"), package("two", "the same\r\n"), package("three", "another")];
        let text = others(&packages).unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(text.matches("the same").count(), 1);
        assert!(text.contains("one  ()\ntwo  ()\n") && text.contains("another"), "{text}");
    }
}
