//! README and the pages of the book whose Rust examples `cargo test --doc` compiles and runs.

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
}

#[cfg(test)]
mod tests {
    use super::PAGES;
    use std::path::Path;

    #[test]
    fn every_page_with_rust_examples_is_listed() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let mut folders = vec![root.join("docs")];
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path);
                    continue;
                }
                let page = path.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/");
                let markdown = page.ends_with(".md");
                if markdown && std::fs::read_to_string(&path).unwrap().contains("\n```rust") {
                    assert!(PAGES.contains(&page.as_str()), "{page} has Rust examples: list it in documents.rs");
                }
            }
        }
    }
}
