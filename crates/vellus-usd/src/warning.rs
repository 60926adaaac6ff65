//! Warnings about what a reader ignored or replaced.

use std::collections::{HashMap, HashSet};
use std::fmt;

/// A part of a file that could not be read. The rest of the file was.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Fault {
    /// A layer, reference or payload.
    Layer,
    /// A prim, which is left out.
    Prim,
    /// A material, which is replaced.
    Material,
    /// The image of a texture, which is replaced.
    Texture,
}

impl fmt::Display for Fault {
    /// The plural.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Fault::Layer => "layers",
            Fault::Prim => "prims",
            Fault::Material => "materials",
            Fault::Texture => "textures",
        })
    }
}

/// Something in a file that is not supported or broken. It was ignored or replaced, and the rest of the file was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// What could not be read. `None` if it is something that is not supported.
    pub fault: Option<Fault>,
    /// Paths of the prims that it concerns, in the order of the file; or a file.
    pub prims: Vec<String>,
    /// What is not supported or broken, and what the reader did instead.
    pub what: String,
}

impl fmt::Display for Warning {
    /// Names at most three prims.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown = self.prims.len().min(3);
        f.write_str(&self.prims[..shown].join(", "))?;
        if self.prims.len() > shown {
            write!(f, " and {} more", self.prims.len() - shown)?;
        }
        write!(f, ": {}", self.what)
    }
}

/// Collects warnings. A warning that many prims share is stored once.
#[derive(Default)]
pub(crate) struct Warnings {
    all: Vec<Warning>,
    /// The index of each text.
    known: HashMap<String, usize>,
    /// The prims of each warning.
    seen: HashSet<(usize, String)>,
}

impl Warnings {
    pub fn add(&mut self, prim: &str, what: impl Into<String>) {
        self.add_fault(None, prim, what.into());
    }

    pub fn add_fault(&mut self, fault: Option<Fault>, prim: &str, what: String) {
        let index = *self.known.entry(what.clone()).or_insert(self.all.len());
        if index == self.all.len() {
            self.all.push(Warning { fault, prims: Vec::new(), what });
        }
        if self.seen.insert((index, prim.to_owned())) {
            self.all[index].prims.push(prim.to_owned());
        }
    }

    pub fn into_vec(self) -> Vec<Warning> {
        self.all
    }
}
