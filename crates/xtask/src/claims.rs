//! `cargo xtask claims`: each measured number in README and the book names what proves it, and when.
//!
//! A comment in the Markdown covers the blocks above it, up to the heading or to the comment before:
//!
//! ```text
//! <!-- proof: 2026-11-26, test vellus/tests/it/window.rs::far_field_matches_quadrature -->
//! <!-- proof: 2026-11, command cargo bench -p vellus -->
//! <!-- proof: limits -->
//! ```
//!
//! `limits` are defaults, limits and definitions: the code has them, and nothing measures them. At the head of a page,
//! a comment covers the whole page.

use crate::paper;
use std::fs;
use std::path::{Path, PathBuf};

const START: &str = "<!-- proof: ";

/// Numbers with these units are measured, or limits.
const UNITS: [&str; 13] = ["%", "×", "ns", "µs", "ms", "s", "minutes", "hours", "kB", "KB", "MB", "GB", "times"];

/// A block of Markdown with numbers.
#[derive(Debug, PartialEq)]
struct Claim {
    /// From 1.
    line: usize,
    text: String,
    proof: Option<String>,
}

/// Checks all pages. The message lists what has no proof, and proofs that do not exist.
pub fn check(root: &Path) -> Result<(), String> {
    let sources = paper::sources(root)?;
    let mut problems = Vec::new();
    for (page, claims) in claims(root)? {
        for Claim { line, text, proof } in claims {
            let place = format!("{}:{line}", page.strip_prefix(root).unwrap_or(&page).display());
            match proof {
                None => problems.push(format!("{place}: no proof of '{}'", excerpt(&text))),
                Some(proof) => {
                    problems.extend(wrong(root, &sources, &proof).map(|what| format!("{place}: {what} ({proof})")));
                }
            }
        }
    }
    if problems.is_empty() { Ok(()) } else { Err(problems.join("\n")) }
}

/// Prints all claims with their proofs.
pub fn print(root: &Path) -> Result<(), String> {
    for (page, claims) in claims(root)? {
        println!("{}", page.strip_prefix(root).unwrap_or(&page).display());
        for Claim { line, text, proof } in claims {
            println!("{line:5}  {}\n       {}", excerpt(&text), proof.as_deref().unwrap_or("NO PROOF"));
        }
    }
    Ok(())
}

/// The start of a text.
fn excerpt(text: &str) -> String {
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    line.chars().take(90).collect()
}

/// The claims of README and of all pages of the book, by page.
fn claims(root: &Path) -> Result<Vec<(PathBuf, Vec<Claim>)>, String> {
    let book = root.join("docs/book/src");
    let mut pages = vec![root.join("README.md"), root.join("docs/energy.md")];
    let entries = fs::read_dir(&book).map_err(|e| format!("{}: {e}", book.display()))?;
    pages.extend(entries.filter_map(Result::ok).map(|e| e.path()).filter(|p| p.extension().is_some_and(|e| e == "md")));
    pages[2..].sort();
    let read = |page: PathBuf| {
        let text = fs::read_to_string(&page).map_err(|e| format!("{}: {e}", page.display()))?;
        let claims = claims_of(&text);
        Ok((page, claims))
    };
    pages.into_iter().map(read).collect()
}

fn claims_of(text: &str) -> Vec<Claim> {
    let (mut done, mut open): (Vec<Claim>, Vec<Claim>) = (Vec::new(), Vec::new());
    let (mut block, mut first) = (String::new(), 1);
    let (mut is_code, mut whole_page) = (false, None);
    for (i, line) in text.lines().chain([""]).enumerate() {
        if line.trim_start().starts_with("```") {
            is_code = !is_code;
            continue;
        }
        let proof = line.strip_prefix(START).and_then(|rest| rest.strip_suffix("-->")).map(str::trim);
        let is_heading = line.starts_with('#');
        if is_code || !(line.trim().is_empty() || proof.is_some() || is_heading) {
            if !is_code {
                if block.is_empty() {
                    first = i + 1;
                }
                block += line;
                block.push('\n');
            }
            continue;
        }
        if has_number(&block) {
            open.push(Claim { line: first, text: std::mem::take(&mut block), proof: None });
        }
        block.clear();
        if let Some(proof) = proof {
            if i == 0 {
                whole_page = Some(proof.to_owned());
            }
            done.extend(open.drain(..).map(|claim| Claim { proof: Some(proof.to_owned()), ..claim }));
        } else if is_heading {
            done.append(&mut open);
        }
    }
    done.append(&mut open);
    for claim in &mut done {
        claim.proof = claim.proof.take().or_else(|| whole_page.clone());
    }
    done
}

/// Whether a block has a number with a unit. In a table, the unit may be in the heading.
fn has_number(block: &str) -> bool {
    let words: Vec<&str> = block.split(|c: char| c.is_whitespace() || "|()[],:;/".contains(c)).collect();
    let is_number = |word: &str| word.starts_with(|c: char| c.is_ascii_digit() || c == '.');
    let is_unit = |word: &str| UNITS.contains(&word.trim_end_matches(['.', '?', '!']));
    let attached = |word: &&str| is_number(word) && word.ends_with(['%', '×']);
    let follows = words.windows(2).any(|pair| is_number(pair[0]) && is_unit(pair[1]));
    let is_table = block.starts_with('|') && words.iter().any(|w| is_unit(w)) && words.iter().any(|w| is_number(w));
    follows || is_table || words.iter().any(attached)
}

/// The error in a proof, if there is one.
fn wrong(root: &Path, sources: &[(PathBuf, String)], proof: &str) -> Option<String> {
    if proof == "limits" {
        return None;
    }
    let Some((date, by)) = proof.split_once(", ") else {
        return Some("a proof is a date and a test or command".into());
    };
    if !(date.len() == 7 || date.len() == 10) || !date.chars().all(|c| c.is_ascii_digit() || c == '-') {
        return Some(format!("{date} is no date"));
    }
    for by in by.split(", ") {
        let problem = match by.split_once(' ') {
            Some(("test", name)) => match name.split_once(".rs::") {
                Some((file, symbol)) => paper::problem(sources, &format!("{file}.rs"), symbol),
                None => (!root.join(name).exists()).then(|| format!("{name} does not exist")),
            },
            Some(("command", line)) => line
                .split_whitespace()
                .filter(|word| word.starts_with("lab/") || word.starts_with("crates/"))
                .find(|file| !root.join(file).exists())
                .map(|file| format!("{file} does not exist")),
            _ => Some("a proof is 'test FILE::NAME' or 'command LINE'".into()),
        };
        if problem.is_some() {
            return problem;
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_cover_the_blocks_above_them() {
        let text = "# A\n\nIt takes 3 ms.\n\n| a | % |\n|---|---|\n| b | 4 |\n\n<!-- proof: limits -->\n\n\
                    No number: 3 hairs.\n\n\
                    ## B\n\nWithin 2 % of it.\n\n```sh\necho 3 ms\n```\n## C\n1.5× as fast\n\
                    <!-- proof: 2026-11, test a.rs::b -->\n";
        let found = claims_of(text);
        let proofs: Vec<_> = found.iter().map(|claim| (claim.line, claim.proof.as_deref())).collect();
        let test = Some("2026-11, test a.rs::b");
        assert_eq!(proofs, [(3, Some("limits")), (5, Some("limits")), (15, None), (21, test)]);
        let page = claims_of("<!-- proof: limits -->\n# A\n\nAt most 5 %.\n");
        assert_eq!(page[0].proof.as_deref(), Some("limits"));
    }

    #[test]
    fn proofs_exist() {
        let sources = [(PathBuf::from("crates/x/tests/a.rs"), "fn b() {}".to_owned())];
        let wrong = |proof: &str| wrong(Path::new("/"), &sources, proof);
        assert_eq!(wrong("limits"), None);
        assert_eq!(wrong("2026-11-26, test x/tests/a.rs::b, command cargo bench -p vellus"), None);
        for bad in [
            "2026-11",
            "November, test a.rs::b",
            "2026-11, test a.rs::c",
            "2026-11, command lab/none.py",
            "2026-11, us",
        ] {
            assert!(wrong(bad).is_some(), "{bad}");
        }
    }
}
