//! The source files of a scene.

use crate::digest::{Digest, DigestBuilder};
use std::collections::BTreeMap;

/// Names and digests of all files that a scene was read from.
///
/// The name of a file is the path in the file that refers to it. A relative path is joined to the name of the folder of
/// the referring file. The root file has an empty name. Names therefore do not depend on the location of the scene.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sources(BTreeMap<String, Digest>);

impl Sources {
    /// An empty list.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a file by its name and content.
    pub fn add(&mut self, name: &str, bytes: &[u8]) {
        self.add_digest(name, Digest::of(bytes));
    }

    /// Adds a file by its name and digest.
    pub fn add_digest(&mut self, name: &str, digest: Digest) {
        self.0.insert(name.to_owned(), digest);
    }

    /// Adds all files of another list.
    pub fn extend(&mut self, other: Sources) {
        self.0.extend(other.0);
    }

    /// Names and digests, sorted by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, Digest)> {
        self.0.iter().map(|(name, digest)| (name.as_str(), *digest))
    }

    /// The digest of all files. It does not depend on the order in which they were added.
    pub fn digest(&self) -> Digest {
        self.iter().fold(DigestBuilder::new(), |builder, (name, digest)| builder.field(name, digest.0)).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_of_reading_does_not_matter_and_swapped_contents_do() {
        let sources = |files: [(&str, &[u8]); 2]| {
            let mut sources = Sources::new();
            files.into_iter().for_each(|(name, bytes)| sources.add(name, bytes));
            sources.digest()
        };
        let once = sources([("a.png", b"1"), ("b.png", b"2")]);
        assert_eq!(once, sources([("b.png", b"2"), ("a.png", b"1")]));
        assert_ne!(once, sources([("a.png", b"2"), ("b.png", b"1")]));
    }
}
