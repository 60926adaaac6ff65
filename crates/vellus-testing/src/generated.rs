//! Texts that tests write: parts of documents, and files of data. One fact is then in one place.
//!
//! A test whose name begins with `generated_` compares the text with the file. `cargo xtask generate` runs these tests
//! with `VELLUS_WRITE`, which writes it.

use std::path::Path;

/// Whether tests write what they generate.
pub fn writes() -> bool {
    std::env::var_os("VELLUS_WRITE").is_some()
}

/// Compares a file of the repository with a text, or writes it.
///
/// # Panics
/// If they differ, or the file cannot be read or written.
pub fn file(path: &str, text: &str) {
    let place = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path);
    if std::fs::read_to_string(&place).is_ok_and(|found| found == text) {
        return;
    }
    assert!(writes(), "{path} is stale: run `cargo xtask generate`");
    std::fs::write(&place, text).unwrap_or_else(|error| panic!("{path}: {error}"));
}

/// The same for a part of a document, between the lines `<!-- generated: NAME -->` and `<!-- end -->`.
///
/// # Panics
/// As [`file()`], and if the document has no such part.
pub fn part(path: &str, name: &str, text: &str) {
    let place = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path);
    let found = std::fs::read_to_string(&place).unwrap_or_else(|error| panic!("{path}: {error}"));
    let begin = format!("<!-- generated: {name} -->\n");
    let start = found.find(&begin).unwrap_or_else(|| panic!("{path} has no line {begin}")) + begin.len();
    let length = found[start..].find("<!-- end -->").unwrap_or_else(|| panic!("{path}: {name} has no end"));
    file(path, &format!("{}{text}{}", &found[..start], &found[start + length..]));
}
