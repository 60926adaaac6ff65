//! Warnings about what a reader ignored or replaced.

use std::fmt;

/// Something in a file that is not supported. It was ignored or replaced, and the rest of the file was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// Paths of the prims that it concerns, in the order of the file.
    pub prims: Vec<String>,
    /// What is not supported, and what the reader did instead.
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
pub(crate) struct Warnings(pub Vec<Warning>);

impl Warnings {
    pub fn add(&mut self, prim: &str, what: impl Into<String>) {
        let what = what.into();
        match self.0.iter_mut().find(|w| w.what == what) {
            Some(warning) if warning.prims.iter().any(|p| p == prim) => {}
            Some(warning) => warning.prims.push(prim.to_owned()),
            None => self.0.push(Warning { prims: vec![prim.to_owned()], what }),
        }
    }
}
