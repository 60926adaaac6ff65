//! What can be wrong with a profile, or with what is asked of it.

use std::path::{Path, PathBuf};

/// Bad input, with its place.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A profile that cannot be read or fitted.
    #[error("{}: {what}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// A line of a profile.
    #[error("{}, line {line}: {what}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// Counted from 1.
        line: u64,
        /// What is wrong with it.
        what: String,
    },
    /// A parameter that is asked to be fixed, tied or freed.
    #[error("{0}")]
    Parameter(String),
    /// A profile or a fit that is impossible.
    #[error("{0}")]
    Profile(String),
    /// A fibre out of range.
    #[error(transparent)]
    Fiber(#[from] vellus::Error),
}

impl Error {
    pub(crate) fn file(path: &Path, what: impl ToString) -> Self {
        Error::File { path: path.to_owned(), what: what.to_string() }
    }

    pub(crate) fn line(path: &Path, line: u64, what: impl ToString) -> Self {
        Error::Line { path: path.to_owned(), line, what: what.to_string() }
    }
}
