//! Compares PAPER.md with the code: every `file::symbol` that it names exists in one file, every departure D1, D2, …
//! that a comment cites has a row, and every row is cited.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Checks PAPER.md. The message lists all problems.
pub fn check(root: &Path) -> Result<(), String> {
    let paper = read(&root.join("PAPER.md"))?;
    let texts = sources(root)?;
    let mut problems: Vec<String> = references(&paper)
        .iter()
        .filter_map(|(file, symbol)| problem(&texts, file, symbol))
        .map(|what| format!("PAPER.md: {what}"))
        .collect();
    let listed: BTreeSet<u32> =
        paper.lines().filter_map(|line| line.strip_prefix("| D")).flat_map(leading_number).collect();
    let cited: BTreeSet<u32> = texts
        .iter()
        .filter(|(path, _)| !path.ends_with("xtask/src/paper.rs"))
        .flat_map(|(_, text)| departures(text))
        .collect();
    problems.extend(cited.difference(&listed).map(|d| format!("the code cites D{d}, which PAPER.md does not list")));
    problems.extend(listed.difference(&cited).map(|d| format!("PAPER.md lists D{d}, which no code cites")));
    if problems.is_empty() { Ok(()) } else { Err(problems.join("\n")) }
}

/// All source files with their texts.
pub fn sources(root: &Path) -> Result<Vec<(PathBuf, String)>, String> {
    let mut sources = Vec::new();
    for folder in ["crates", "lab"] {
        collect(&root.join(folder), &mut sources)?;
    }
    sources.into_iter().map(|path| read(&path).map(|text| (path, text))).collect()
}

/// The error in the name of a symbol in a file, if there is one.
pub fn problem(sources: &[(PathBuf, String)], file: &str, symbol: &str) -> Option<String> {
    let matching: Vec<_> = sources.iter().filter(|(path, _)| path.ends_with(file)).collect();
    match matching.as_slice() {
        [] => Some(format!("{file} does not exist")),
        [(_, text)] if defines(text, symbol) => None,
        [_] => Some(format!("{file} does not define {symbol}")),
        several => Some(format!("{file} is {} files: name its folder", several.len())),
    }
}

fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))
}

fn collect(folder: &Path, into: &mut Vec<PathBuf>) -> Result<(), String> {
    for entry in fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))? {
        let path = entry.map_err(|e| e.to_string())?.path();
        if path.ends_with("target") {
            // What was built in `lab/`.
        } else if path.is_dir() {
            collect(&path, into)?;
        } else if path.extension().is_some_and(|e| e == "rs") {
            into.push(path);
        }
    }
    Ok(())
}

/// `path.rs::symbol` between backquotes.
fn references(text: &str) -> Vec<(String, String)> {
    text.split('`')
        .skip(1)
        .step_by(2)
        .filter_map(|code| code.split_once(".rs::"))
        .map(|(file, symbol)| (format!("{file}.rs"), symbol.rsplit("::").next().unwrap_or(symbol).to_owned()))
        .collect()
}

/// Whether the source defines an item, field or variant of that name.
fn defines(text: &str, symbol: &str) -> bool {
    let keywords = ["fn ", "struct ", "enum ", "trait ", "const ", "mod ", "type "];
    keywords.iter().any(|k| word_after(text, k, symbol)) || word_after(text, "pub ", symbol)
}

fn word_after(text: &str, before: &str, symbol: &str) -> bool {
    text.match_indices(&format!("{before}{symbol}"))
        .any(|(at, found)| !text[at + found.len()..].starts_with(|c: char| c.is_alphanumeric() || c == '_'))
}

/// Numbers n of all standalone `Dn` in comments.
fn departures(text: &str) -> Vec<u32> {
    text.lines()
        .filter_map(|line| line.find("//").map(|at| &line[at..]))
        .flat_map(|comment| {
            comment.match_indices('D').filter_map(move |(at, _)| {
                let before = comment[..at].chars().next_back();
                let free = !before.is_some_and(|c| c.is_alphanumeric() || c == '_');
                if free { leading_number(&comment[at + 1..]) } else { None }
            })
        })
        .collect()
}

/// The number at the start, if the word ends with it.
fn leading_number(text: &str) -> Option<u32> {
    let end = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let word_ends = !text[end..].starts_with(|c: char| c.is_alphanumeric() || c == '_');
    if word_ends { text[..end].parse().ok() } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_and_departures_are_found() {
        assert_eq!(references("a `path.rs::Path::new` b `x` c `q.rs::f`").len(), 2);
        assert_eq!(references("`path.rs::Path::new`")[0], ("path.rs".to_owned(), "new".to_owned()));
        assert_eq!(departures("let D4 = 1; // D3: why, (D11), not 2D5 nor D6x"), [3, 11]);
        assert!(defines("pub(crate) fn exit(", "exit") && !defines("fn exit_azimuth(", "exit"));
    }
}
