//! Tables of a crate file: each entry is there once, and values refer to it by its index.

use std::collections::HashMap;
use std::hash::Hash;

/// A list of different entries.
pub(crate) struct Table<T> {
    entries: Vec<T>,
    indices: HashMap<T, u32>,
}

impl<T: Clone + Eq + Hash> Table<T> {
    pub fn new() -> Self {
        Table { entries: Vec::new(), indices: HashMap::new() }
    }

    /// The index of an entry, which is added if it is new.
    pub fn index(&mut self, entry: T) -> u32 {
        *self.indices.entry(entry).or_insert_with_key(|entry| {
            self.entries.push(entry.clone());
            self.entries.len() as u32 - 1
        })
    }

    pub fn entries(&self) -> &[T] {
        &self.entries
    }
}

/// The tables that values refer to.
pub(crate) struct Tables {
    pub tokens: Table<String>,
    /// Indices of tokens.
    pub strings: Table<u32>,
    /// The index of the parent, and the token of the last part of the path, which is negative for properties.
    pub paths: Table<(u32, i32)>,
}

/// The index of the path `/`.
pub(crate) const ROOT: u32 = 0;

impl Tables {
    pub fn new() -> Self {
        let mut tables = Tables { tokens: Table::new(), strings: Table::new(), paths: Table::new() };
        // The first token has no negative, so it must not be the name of a property.
        tables.token("");
        tables.paths.index((ROOT, 0));
        tables
    }

    pub fn token(&mut self, token: &str) -> u32 {
        self.tokens.index(token.to_owned())
    }

    pub fn string(&mut self, string: &str) -> u32 {
        let token = self.token(string);
        self.strings.index(token)
    }

    /// The path of a prim in a prim.
    pub fn prim(&mut self, parent: u32, name: &str) -> u32 {
        let token = self.token(name).cast_signed();
        self.paths.index((parent, token))
    }

    /// The path of a property of a prim.
    pub fn property(&mut self, prim: u32, name: &str) -> u32 {
        let token = self.token(name).cast_signed();
        self.paths.index((prim, -token))
    }

    /// An absolute path of a prim or property.
    pub fn path(&mut self, path: &str) -> u32 {
        let (prims, property) = path.split_once('.').map_or((path, None), |(prims, property)| (prims, Some(property)));
        let prim = prims.split('/').skip(1).fold(ROOT, |parent, name| self.prim(parent, name));
        property.map_or(prim, |property| self.property(prim, property))
    }
}
