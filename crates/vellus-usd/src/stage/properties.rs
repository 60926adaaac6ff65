//! The names of a prim's properties, and which of them were asked for.

use super::Stage;
use super::names::check_property;
use crate::error::Error;
use openusd::tf::Token;
use std::cell::Cell;
use std::rc::Rc;

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

impl Stage {
    /// Notes that a prim is read: each of its properties must then be asked for, or be known as one without effect.
    pub fn visit(&self, prim: &str) -> Result<(), Error> {
        if self.properties(prim)?.visit() {
            self.visited.borrow_mut().push(prim.to_owned());
        }
        Ok(())
    }

    /// Notes that properties are known, because others of the same prim replace them.
    pub fn know(&self, prim: &str, names: &[&str]) -> Result<(), Error> {
        let properties = self.properties(prim)?;
        names.iter().for_each(|name| {
            properties.ask(name);
        });
        Ok(())
    }

    /// The prims that were visited. Instances with the same content count once.
    pub fn visited(&self) -> Vec<String> {
        self.visited.borrow().clone()
    }

    /// All properties of a prim.
    pub fn properties(&self, prim: &str) -> Result<Rc<Properties>, Error> {
        if self.last.borrow().0 == prim {
            return Ok(self.last.borrow().1.clone());
        }
        let composed = self.instances.borrow().composed(prim).0.into_owned();
        let known = self.properties.borrow().get(&composed).cloned();
        let names = match known {
            Some(names) => names,
            None => self.ask(prim, |prim| {
                let mut names = self.stage.prim(prim).property_names()?;
                if let Some(Err(what)) = names.iter().map(|name| check_property(name)).find(Result::is_err) {
                    self.leave_out(prim, what.0)?;
                    names.retain(|name| check_property(name).is_ok());
                }
                Ok(Rc::new(Properties::new(names)))
            })?,
        };
        self.properties.borrow_mut().entry(composed).or_insert_with(|| names.clone());
        *self.last.borrow_mut() = (prim.to_owned(), names.clone());
        Ok(names)
    }

    /// Whether a prim has a property. Most properties are not set, and `openusd` is slow to report that.
    pub fn has_property(&self, prim: &str, name: &str) -> Result<bool, Error> {
        Ok(self.properties(prim)?.ask(&self.spelled(prim, name)?))
    }
}
