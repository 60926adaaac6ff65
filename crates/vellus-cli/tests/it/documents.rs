//! The commands in README and the book exist, and so do their options.

use crate::common::{Limited, command};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// README and all pages below `docs`.
fn pages() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut pages = vec![root.join("README.md")];
    let mut folders = vec![root.join("docs")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "md") {
                pages.push(path);
            }
        }
    }
    pages
}

/// The arguments of each `vellus` or `cargo run --release --` in shell blocks, with the line it is in.
fn commands(text: &str) -> Vec<(usize, Vec<String>)> {
    let (mut shell, mut inside, mut open) = (false, false, None::<(usize, String)>);
    let mut found = Vec::new();
    for (i, line) in text.lines().enumerate() {
        if let Some(language) = line.trim_start().strip_prefix("```") {
            (shell, inside) = (!inside && ["sh", "bash", "console"].contains(&language), !inside);
            continue;
        }
        if !shell {
            continue;
        }
        let (start, mut joined) = open.take().unwrap_or((i + 1, String::new()));
        joined += line.split(" #").next().unwrap_or_default();
        if let Some(rest) = joined.strip_suffix('\\') {
            open = Some((start, rest.to_owned()));
            continue;
        }
        for part in joined.split(['|', ';', '&']) {
            let words: Vec<String> = part.split_whitespace().map(|word| word.replace(['"', '\''], "")).collect();
            let arguments = match words.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
                ["vellus", ..] => 1,
                ["cargo", "run", "--release", "--", ..] => 4,
                _ => continue,
            };
            found.push((start, words[arguments..].to_vec()));
        }
    }
    found
}

/// The help of a subcommand.
struct Help {
    /// Names of its own subcommands.
    commands: Vec<String>,
    /// All options, with their dashes.
    options: Vec<String>,
}

fn help(path: &[String]) -> Help {
    let output = command(Path::new("."), &[]).args(path).arg("--help").run().unwrap();
    assert!(output.status.success(), "vellus {} --help", path.join(" "));
    let text = String::from_utf8(output.stdout).unwrap();
    let first_words = |heading: &str| -> Vec<String> {
        let lines = text.lines().skip_while(|line| *line != heading).skip(1).take_while(|line| line.starts_with("  "));
        lines.filter_map(|line| line.split_whitespace().next()).map(str::to_owned).collect()
    };
    // Lines of options are indented less than their explanations.
    let lines = text.lines().filter(|line| line.trim_start().starts_with('-') && !line.starts_with("        "));
    let words = lines.flat_map(|line| line.split([' ', ',', '[', '=', '<'])).filter(|word| word.starts_with('-'));
    let options = words.map(|word| word.trim_end_matches('.').to_owned()).collect();
    Help { commands: first_words("Commands:"), options }
}

#[test]
fn commands_in_documents_exist_with_their_options() {
    let mut helps: HashMap<Vec<String>, Help> = HashMap::new();
    let (mut problems, mut count) = (Vec::new(), 0);
    for page in pages() {
        let text = std::fs::read_to_string(&page).unwrap();
        for (line, words) in commands(&text) {
            count += 1;
            let mut path = Vec::new();
            let mut positional = false;
            for word in &words {
                if word == "--" && path == ["farm", "plan"] {
                    // Options of another command follow.
                    path = vec!["render".to_owned()];
                    continue;
                }
                let help = helps.entry(path.clone()).or_insert_with(|| help(&path));
                let number = word.trim_start_matches('-').starts_with(|c: char| c.is_ascii_digit());
                if word.starts_with('-') && word.len() > 1 && !number {
                    let name = word.split('=').next().unwrap_or_default().to_owned();
                    if !help.options.contains(&name) && !["--help", "-h", "--version"].contains(&name.as_str()) {
                        problems.push(format!("{}:{line}: vellus {} has no {name}", page.display(), path.join(" ")));
                    }
                    positional = true;
                } else if !positional && help.commands.contains(word) {
                    path.push(word.clone());
                } else if !positional && !help.commands.is_empty() {
                    problems.push(format!("{}:{line}: vellus {} has no {word}", page.display(), path.join(" ")));
                    positional = true;
                } else {
                    positional = true;
                }
            }
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
    assert!(count >= 10, "only {count} commands were found");
}

#[test]
fn commands_are_found_in_shell_blocks_only() {
    let text =
        "vellus no\n```sh\nvellus a --b \\\n  c   # d\nls; cargo run --release -- e\n```\n```text\nvellus no\n```\n";
    let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
    assert_eq!(commands(text), [(3, words(&["a", "--b", "c"])), (5, words(&["e"]))]);
}
