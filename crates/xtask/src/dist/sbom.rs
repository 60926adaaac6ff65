//! The list of all packages in the release's files, as CycloneDX 1.5 (a "software bill of materials").

use super::VERSION;
use super::packages::Package;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// The property with the commit that the release was built from.
pub const COMMIT: &str = "vellus:commit";

/// The document. It has no time and no serial number: the same packages give the same bytes.
pub fn document(packages: &BTreeMap<String, Package>, commit: &str) -> Value {
    let component = |package: &Package| {
        let mut component = json!({
            "type": "library",
            "bom-ref": package.purl(),
            "name": package.name,
            "version": package.version,
            "licenses": [{ "expression": package.licence }],
            "purl": package.purl(),
        });
        if let Some(checksum) = &package.checksum {
            component["hashes"] = json!([{ "alg": "SHA-256", "content": checksum }]);
        }
        component
    };
    let dependencies = packages.values().map(|package| {
        let on: Vec<_> = package.dependencies.iter().filter_map(|id| packages.get(id)).map(Package::purl).collect();
        json!({ "ref": package.purl(), "dependsOn": on })
    });
    json!({
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {
            "component": {
                "type": "application",
                "bom-ref": "vellus-release",
                "name": "vellus",
                "version": VERSION,
                "licenses": [{ "expression": "MIT OR Apache-2.0" }],
            },
            "properties": [{ "name": COMMIT, "value": commit }],
        },
        "components": packages.values().map(component).collect::<Vec<_>>(),
        "dependencies": dependencies.collect::<Vec<_>>(),
    })
}

/// The commit in a document.
pub fn commit(document: &str) -> Option<String> {
    let document: Value = serde_json::from_str(document).ok()?;
    let property = document["metadata"]["properties"].as_array()?.iter().find(|p| p["name"] == COMMIT)?;
    property["value"].as_str().map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_document_has_the_packages_their_hashes_and_the_commit() {
        let package = |name: &str, checksum: Option<&str>, dependencies: &[&str]| Package {
            name: name.to_owned(),
            version: "1.2.3".to_owned(),
            licence: "MIT OR Apache-2.0".to_owned(),
            checksum: checksum.map(str::to_owned),
            dependencies: dependencies.iter().map(|&id| id.to_owned()).collect(),
            ..Package::default()
        };
        let packages = BTreeMap::from([
            ("a".to_owned(), package("ours", None, &["b", "left out"])),
            ("b".to_owned(), package("theirs", Some("0123"), &[])),
        ]);
        let document = document(&packages, "4567");
        assert_eq!(document["components"][0]["hashes"], Value::Null);
        assert_eq!(document["components"][1]["hashes"][0]["content"], "0123");
        assert_eq!(document["components"][1]["purl"], "pkg:cargo/theirs@1.2.3");
        assert_eq!(document["dependencies"][0]["dependsOn"], json!(["pkg:cargo/theirs@1.2.3"]));
        assert_eq!(commit(&document.to_string()).as_deref(), Some("4567"));
    }
}
