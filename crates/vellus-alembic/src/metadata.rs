//! Pairs of names and values that describe an archive, an object or a property.

use std::sync::Arc;

/// Metadata: names and values.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Metadata(Arc<str>);

impl Metadata {
    /// Metadata from its text in the file, `name=value;name=value`.
    pub(crate) fn new(text: &str) -> Self {
        Metadata(text.into())
    }

    /// The value of a name.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.iter().find(|(key, _)| *key == name).map(|(_, value)| value)
    }

    /// All pairs in the order of the file.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0.split(';').filter_map(|pair| pair.split_once('='))
    }
}
