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

    /// Whether a page has Rust code of its own, and not only parts of a listing.
    fn has_rust_examples(text: &str) -> bool {
        let mut lines = text.lines().peekable();
        while let Some(line) = lines.next() {
            if line.starts_with("```rust") && !lines.peek().is_some_and(|next| next.starts_with("{{#include")) {
                return true;
            }
        }
        false
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
