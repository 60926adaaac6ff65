//! The names of a prim's properties, and which of them were asked for.

use openusd::tf::Token;
use std::cell::Cell;

/// The properties of a prim.
#[derive(Default)]
pub(crate) struct Properties {
    /// Each name, and whether it was asked for.
    names: Vec<(Token, Cell<bool>)>,
    visited: Cell<bool>,
}

impl Properties {
    pub(super) fn new(names: Vec<Token>) -> Self {
        Properties {
            names: names.into_iter().map(|name| (name, Cell::new(false))).collect(),
            visited: Cell::new(false),
        }
    }

    /// The names.
    pub fn iter(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(|(name, _)| name.as_str())
    }

    /// Whether the prim has a property, which counts as asked for from now on.
    pub(super) fn ask(&self, name: &str) -> bool {
        let found = self.names.iter().find(|(known, _)| known.as_str() == name);
        found.is_some_and(|(_, asked)| {
            asked.set(true);
            true
        })
    }

    /// Notes that the prim is read. Returns whether this is new.
    pub(super) fn visit(&self) -> bool {
        !self.visited.replace(true)
    }

    /// The names that nobody asked for.
    pub fn unread(&self) -> impl Iterator<Item = &str> {
        self.names.iter().filter(|(_, asked)| !asked.get()).map(|(name, _)| name.as_str())
    }
}
