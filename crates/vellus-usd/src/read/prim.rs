//! A prim while it is read.

use crate::error::Error;
use crate::read::network::{Input, Walk};
use crate::stage::{Numbers, Stage, When};

/// A prim while it is read. Its properties that nobody asks for are in the ledger: see [`crate::read::ledger`].
#[derive(Clone, Copy)]
pub(crate) struct Prim<'s> {
    pub stage: &'s Stage,
    pub path: &'s str,
}

impl<'s> Prim<'s> {
    /// Begins to read a prim.
    pub fn new(stage: &'s Stage, path: &'s str) -> Result<Self, Error> {
        stage.visit(path)?;
        Ok(Prim { stage, path })
    }

    /// Numbers, vectors, or an array of them, when the shutter opens.
    pub fn numbers(&self, name: &str) -> Result<Option<Numbers>, Error> {
        self.stage.numbers(self.path, name, When::Open)
    }

    /// One number, vector, quaternion or matrix, when the shutter opens.
    pub fn precise(&self, name: &str) -> Result<Option<Vec<f64>>, Error> {
        self.stage.precise(self.path, name, When::Open)
    }

    /// One finite number.
    pub fn number(&self, name: &str, fallback: f64) -> Result<f64, Error> {
        match self.precise(name)?.as_deref() {
            None => Ok(fallback),
            Some(&[x]) if x.is_finite() => Ok(x),
            Some(_) => Err(self.error(format!("{name} must be a finite number"))),
        }
    }

    /// An array of integers, when the shutter opens.
    pub fn integers(&self, name: &str) -> Result<Option<Vec<i64>>, Error> {
        self.stage.integers(self.path, name, When::Open)
    }

    /// The first token or string.
    pub fn token(&self, name: &str) -> Result<Option<String>, Error> {
        Ok(self.stage.words(self.path, name)?.and_then(|words| words.into_iter().next()))
    }

    /// The targets of a relationship.
    pub fn targets(&self, name: &str) -> Result<Vec<String>, Error> {
        self.stage.targets(self.path, name)
    }

    /// Whether an attribute has a value.
    pub fn has_value(&self, name: &str) -> Result<bool, Error> {
        self.stage.has_value(self.path, name)
    }

    /// The source of an input.
    pub fn input(&self, name: &str) -> Result<Input, Error> {
        Walk::from(self.path, name).end(self.stage)
    }

    /// The first token or string of an input, over its connections.
    pub fn input_token(&self, name: &str) -> Result<Option<String>, Error> {
        match self.input(name)? {
            Input::Value(at) => Prim { stage: self.stage, path: &at.prim }.token(&at.name),
            _ => Ok(None),
        }
    }

    pub fn error(&self, what: impl Into<String>) -> Error {
        Error::prim(self.path, what)
    }
}
