//! What can be wrong with a scene.

/// Why a scene cannot be used.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum Error {
    /// Something is inconsistent or outside its range.
    #[error("{place}: {what}")]
    Invalid {
        /// The strands, mesh, light … it is in, by name.
        place: String,
        /// What, and what is allowed.
        what: String,
    },
    /// A fibre's parameter is out of range.
    #[error("{place}: {what}")]
    Fiber {
        /// The look it is in.
        place: String,
        /// The parameter. It is part of the message, so it is no `source`: chains of errors would print it twice.
        what: vellus::Error,
    },
}

/// An [`Error::Invalid`].
pub(crate) fn invalid(place: &str, what: impl Into<String>) -> Error {
    Error::Invalid { place: place.to_owned(), what: what.into() }
}
