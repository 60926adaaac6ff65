//! README and the pages of the book with Rust examples. `cargo test --doc` compiles and runs these.
//!
//! The programs in `docs/book/listings` are examples of this crate: see its manifest.

/// Each page is a module, so that a failure names it.
macro_rules! pages {
    ($($name:ident: $path:literal,)*) => {
        $(
            #[cfg(doctest)]
            #[doc = include_str!(concat!("../../../", $path))]
            mod $name {}
        )*

        #[cfg(test)]
        const PAGES: &[&str] = &[$($path),*];
    };
}

pages! {
    readme: "README.md",
    crates: "docs/book/src/crates.md",
    gpu: "docs/book/src/gpu.md",
}

#[cfg(test)]
#[path = "../../../docs/book/listings/furnace.rs"]
#[expect(dead_code, reason = "`main` prints the table, and a test compares it")]
mod furnace;

#[cfg(test)]
mod tests {
    use super::{PAGES, furnace};
    use std::path::{Path, PathBuf};

    fn root() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
    }

    /// All files below `docs`, relative to the root.
    fn documents() -> Vec<String> {
        let mut folders = vec![root().join("docs")];
        let mut files = Vec::new();
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path);
                } else {
                    files.push(path.strip_prefix(root()).unwrap().to_string_lossy().replace('\\', "/"));
                }
            }
        }
        files
    }

    /// Before the code of a listing: its file in `docs/book/listings`, and after a colon the name of a part.
    const LISTING: &str = "listing ";

    /// Whether a page has Rust code of its own, and not only parts of a listing.
    fn has_rust_examples(text: &str) -> bool {
        let mut before = "";
        text.lines().any(|line| {
            let listing = before.starts_with(&format!("<!-- generated: {LISTING}"));
            before = line;
            line.starts_with("```rust") && !listing
        })
    }

    /// A part of a listing, without the lines that mark parts.
    fn listing(name: &str) -> String {
        let (file, anchor) = name.split_once(':').unwrap_or((name, ""));
        let text = std::fs::read_to_string(root().join("docs/book/listings").join(file)).unwrap();
        let begin = format!("ANCHOR: {anchor}");
        let skip = |line: &&str| !anchor.is_empty() && !line.ends_with(&begin);
        let lines: Vec<&str> = text.lines().skip_while(skip).skip(usize::from(!anchor.is_empty())).collect();
        let end = |line: &&&str| anchor.is_empty() || !line.ends_with(&format!("ANCHOR_END: {anchor}"));
        let lines: Vec<&&str> = lines.iter().take_while(end).filter(|line| !line.contains("ANCHOR")).collect();
        let filled = lines.iter().filter(|line| !line.is_empty());
        let indent = filled.map(|line| line.len() - line.trim_start().len()).min().unwrap_or(0);
        lines.iter().map(|line| format!("{}\n", line.get(indent..).unwrap_or_default())).collect()
    }

    /// Pages have the code of the listings that they name, so that they can be read without mdBook.
    #[test]
    fn generated_pages_have_the_code_of_their_listings() {
        for page in documents().iter().filter(|page| page.ends_with(".md")) {
            let text = std::fs::read_to_string(root().join(page)).unwrap();
            assert!(!text.contains("{{#include ../listings"), "{page}: write <!-- generated: {LISTING}… -->");
            let names = text.lines().filter_map(|line| line.strip_prefix("<!-- generated: ")?.strip_suffix(" -->"));
            for name in names.filter(|name| name.starts_with(LISTING)) {
                let code = listing(&name[LISTING.len()..]);
                crate::generated::part(page, name, &format!("```rust\n{code}```\n"));
            }
        }
    }

    /// Pages have the numbers that tests prove.
    #[test]
    fn generated_numbers_are_those_that_tests_prove() {
        let pages = documents().into_iter().filter(|page| page.ends_with(".md"));
        for page in pages.chain(["README.md".to_owned(), "PAPER.md".to_owned()]) {
            let text = std::fs::read_to_string(root().join(&page)).unwrap();
            crate::generated::file(&page, &crate::numbers::fill(&text));
        }
    }

    /// The table of the parameters is that of the crate.
    #[test]
    fn generated_table_of_parameters_is_that_of_the_crate() {
        let mut table = "| name | symbol | range | meaning |\n|---|---|---|---|\n".to_owned();
        for parameter in vellus::Parameter::ALL {
            let (range, sign) = (parameter.range(), parameter.unit().sign());
            let rgb = if parameter.channels() == 3 { ", RGB" } else { "" };
            let unit = if parameter.unit() == vellus::ParameterUnit::PerRadius { ", per fibre radius" } else { "" };
            let name = parameter.name();
            let symbol = if parameter.symbol() == name { "" } else { parameter.symbol() };
            let values = match parameter.choices() {
                [] => format!("{}{sign} to {}{sign}", range.low, range.high),
                words => words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(" or "),
            };
            table += &format!("| `{name}` | {symbol} | {values} | {}{rgb}{unit} |\n", parameter.description());
        }
        crate::generated::part("docs/book/src/fibers.md", "parameters", &table);
    }

    #[test]
    fn every_page_with_rust_examples_is_listed() {
        for page in documents().iter().filter(|page| page.ends_with(".md")) {
            let text = std::fs::read_to_string(root().join(page)).unwrap();
            let listed = PAGES.contains(&page.as_str());
            assert_eq!(has_rust_examples(&text), listed, "{page}: documents.rs lists the pages with Rust examples");
        }
    }

    /// The numbers of a table that starts with `theta_o`, up to the end of its block.
    fn rows(text: &str) -> Vec<Vec<f64>> {
        let lines = text.lines().skip_while(|line| !line.starts_with("theta_o")).skip(1);
        let numbers = |line: &str| -> Vec<f64> {
            let words = line.split(|c: char| c.is_whitespace() || c == '°');
            words.filter_map(|word| word.parse().ok()).collect()
        };
        lines.take_while(|line| *line != "```").map(numbers).collect()
    }

    /// Its random numbers are fixed. Processors differ in the seventh digit of a query, so a number near the middle of
    /// two of four decimals may be rounded to the other one.
    #[test]
    #[ignore = "test: 4 million hits"]
    fn the_furnace_of_the_guide_prints_the_table_of_the_page() {
        let page = std::fs::read_to_string(root().join("docs/book/src/integration.md")).unwrap();
        let printed = furnace::table().unwrap();
        let (shown, computed) = (rows(&page), rows(&printed));
        let is_near =
            |(a, b): (&Vec<f64>, &Vec<f64>)| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1.5e-4);
        assert!(shown.len() == 4 && computed.len() == 4, "{shown:?}\n{printed}");
        assert!(shown.iter().zip(&computed).all(is_near), "the page has {shown:?}, but the program prints\n{printed}");
        // What the page says about the columns.
        for row in &computed {
            let [_, sample, eval, error] = row[..] else { panic!("{printed}") };
            assert!(sample == 1.0 && (eval - 1.0).abs() < 3.0 * error, "{printed}");
        }
    }

    #[test]
    fn every_listing_is_an_example() {
        let manifest = std::fs::read_to_string(root().join("crates/vellus-testing/Cargo.toml")).unwrap();
        for listing in documents().iter().filter(|page| page.ends_with(".rs")) {
            assert!(manifest.contains(&format!("path = \"../../{listing}\"")), "{listing} is no [[example]]");
        }
    }
}
