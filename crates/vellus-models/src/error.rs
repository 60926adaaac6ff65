//! Errors of models.

use crate::ModelKind;

/// An unknown model or an invalid fibre.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// There is no model of this name.
    #[error("unknown model '{name}': known are {known}")]
    UnknownModel {
        /// The name.
        name: String,
        /// All known names.
        known: String,
    },
    /// A refractive index of the medulla is given for a model that has none.
    #[error("{0} has one refractive index; only yan2015 takes two")]
    OneIndex(ModelKind),
    /// A parameter of the fibre is out of range.
    #[error(transparent)]
    Fiber(#[from] vellus::Error),
}
