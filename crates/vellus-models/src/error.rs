//! What can be wrong with a model's name or its fibre.

/// Bad input.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A model nobody knows.
    #[error("unknown model '{name}': known are {known}")]
    UnknownModel {
        /// The name given.
        name: String,
        /// All names known.
        known: String,
    },
    /// A parameter outside its range.
    #[error(transparent)]
    Fiber(#[from] vellus::Error),
}
