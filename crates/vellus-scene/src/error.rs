//! Errors of scenes.

/// The reason why a scene is not valid.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum Error {
    /// A value is inconsistent or out of range.
    #[error("{place}: {what}")]
    Invalid {
        /// The name of the strands, mesh, light or other object with the problem.
        place: String,
        /// The problem, and the allowed values.
        what: String,
    },
    /// A parameter of a fibre is out of range.
    #[error("{place}: {what}")]
    Fiber {
        /// The name of the look.
        place: String,
        /// The error of the parameter. The message includes it, so it is not a `source`: chains of errors would print
        /// it twice.
        what: vellus::Error,
    },
}

/// An [`Error::Invalid`].
pub(crate) fn invalid(place: &str, what: impl Into<String>) -> Error {
    Error::Invalid { place: place.to_owned(), what: what.into() }
}
