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
mod tests {
    use super::PAGES;
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

    #[test]
    fn every_listing_is_an_example() {
        let manifest = std::fs::read_to_string(root().join("crates/vellus-testing/Cargo.toml")).unwrap();
        for listing in documents().iter().filter(|page| page.ends_with(".rs")) {
            assert!(manifest.contains(&format!("path = \"../../{listing}\"")), "{listing} is no [[example]]");
        }
    }
}
