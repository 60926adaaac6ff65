//! Text in source files and documents: the length of lines, and the language of code blocks.

use std::fs;
use std::path::{Path, PathBuf};

/// The longest line of code or comment, in characters. rustfmt enforces it for code, but not for comments.
const LONGEST: usize = 120;

/// Checks all source files and documents. The message lists every problem.
pub fn check(root: &Path) -> Result<(), String> {
    let mut problems = Vec::new();
    for path in files(root)? {
        let bytes = fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        let Ok(text) = String::from_utf8(bytes) else { continue };
        let name = path.strip_prefix(root).unwrap_or(&path).display();
        let found = match path.extension().and_then(|e| e.to_str()) {
            Some("md") if compiled(root, &path) => unnamed_blocks(&text),
            Some("rs" | "toml" | "py" | "yml" | "wgsl" | "js" | "mjs" | "css") => long_lines(&text),
            _ => continue,
        };
        problems.extend(found.into_iter().map(|(line, problem)| format!("{name}:{line}: {problem}")));
    }
    if problems.is_empty() { Ok(()) } else { Err(problems.join("\n")) }
}

/// All files of the repository except those in hidden folders and those that git ignores by `.gitignore`.
fn files(root: &Path) -> Result<Vec<PathBuf>, String> {
    let mut files = Vec::new();
    let mut folders = vec![root.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))? {
            let path = entry.map_err(|e| format!("{}: {e}", folder.display()))?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if path.is_dir() {
                if !["target", "out", "corpus", "artifacts", "__pycache__", ".git"].contains(&name.as_str()) {
                    folders.push(path);
                }
            } else {
                files.push(path);
            }
        }
    }
    files.sort();
    Ok(files)
}

/// Whether rustdoc compiles the examples of a document: README and the pages of the book.
fn compiled(root: &Path, path: &Path) -> bool {
    path == root.join("README.md") || path.starts_with(root.join("docs"))
}

/// Lines above the limit. A line of code with a string is exempt, since a break could change the string. So is a line
/// that has no space to break it at, such as a link.
fn long_lines(text: &str) -> Vec<(usize, String)> {
    let long = |line: &&str| {
        let comment = line.trim_start().starts_with("//");
        let string = line.contains('"') || line.ends_with('\\');
        line.chars().count() > LONGEST && (comment || !string) && line.chars().skip(LONGEST / 2).any(|c| c == ' ')
    };
    text.lines()
        .enumerate()
        .filter(|(_, line)| long(line))
        .map(|(i, line)| (i + 1, format!("{} characters, at most {LONGEST} are allowed", line.chars().count())))
        .collect()
}

/// Code blocks that do not name their language. Rustdoc would compile them as Rust.
fn unnamed_blocks(text: &str) -> Vec<(usize, String)> {
    let mut inside = false;
    let mut found = Vec::new();
    for (i, line) in text.lines().enumerate() {
        if let Some(language) = line.trim_start().strip_prefix("```") {
            if !inside && language.is_empty() {
                found.push((i + 1, "a code block without a language: write sh, rust, text, …".to_owned()));
            }
            inside = !inside;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_are_counted_in_characters() {
        let line = "ω".repeat(LONGEST - 2) + " ω";
        assert!(long_lines(&line).is_empty());
        assert_eq!(long_lines(&format!("short\n{line}ω"))[0].0, 2);
        assert!(long_lines(&"x".repeat(2 * LONGEST)).is_empty());
        let string = format!("f(\"{}\");", "x ".repeat(LONGEST));
        assert!(long_lines(&string).is_empty() && !long_lines(&format!("// {string}")).is_empty());
    }

    #[test]
    fn blocks_without_a_language_are_found() {
        assert_eq!(unnamed_blocks("```sh\nls\n```\n\n```\nx\n```\n")[0].0, 5);
    }
}
