//! Numbers that tests prove and documents show. They are in `docs/numbers.toml`.
//!
//! A document has a number between `<!-- number NAME -->` and the next `<!--`. A test compares what it measures with
//! [`documented`]. So a document cannot have another number than the one that is proved.

use std::path::Path;

fn table() -> Vec<(String, String)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/numbers.toml");
    let text = std::fs::read_to_string(path).expect("the numbers are in the repository");
    let rows = text.lines().filter_map(|line| line.split_once(" = \""));
    rows.map(|(name, value)| (name.to_owned(), value.trim_end_matches('"').to_owned())).collect()
}

/// The number with this name. A percentage is a share: 0.017 for `1.7 %`.
///
/// # Panics
/// If there is no such number.
pub fn documented(name: &str) -> f64 {
    let table = table();
    let (_, text) = table.iter().find(|(known, _)| known == name).unwrap_or_else(|| panic!("no number {name}"));
    let number = |text: &str| text.parse::<f64>().unwrap_or_else(|_| panic!("{name} = {text} is no number"));
    match text.strip_suffix(" %") {
        Some(percent) => number(percent) / 100.0,
        None => number(text),
    }
}

/// A document with the numbers of the table.
///
/// # Panics
/// If it names a number that the table does not have.
pub fn fill(document: &str) -> String {
    const BEGIN: &str = "<!-- number ";
    let (table, mut rest, mut filled) = (table(), document, String::new());
    while let Some(start) = rest.find(BEGIN) {
        let (before, tagged) = rest.split_at(start + BEGIN.len());
        let (name, after) = tagged.split_once(" -->").expect("a number has a name");
        let value = table.iter().find(|(known, _)| known == name).unwrap_or_else(|| panic!("no number {name}"));
        let end = after.find("<!--").expect("a number has an end");
        filled += &format!("{before}{name} -->{}", value.1);
        rest = &after[end..];
    }
    filled + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_filled_in_between_their_marks() {
        let (name, value) = table().remove(0);
        let text = format!("up to <!-- number {name} -->old<!-- --> of it, <!-- a comment -->");
        assert_eq!(fill(&text), text.replace("old", &value));
        assert_eq!(fill("none"), "none");
        assert!(documented(&name) > 0.0);
    }
}
