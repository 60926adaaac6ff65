//! Errors of models.

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
    /// A parameter of the fibre is out of range.
    #[error(transparent)]
    Fiber(#[from] vellus::Error),
}
