//! Errors of profiles and fits.

use std::path::{Path, PathBuf};

/// Bad input. The message names its place.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file that cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system reports.
        source: std::io::Error,
    },
    /// A file that is not a profile.
    #[error("{}: {what}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The problem.
        what: String,
    },
    /// A bad line of a profile.
    #[error("{}, line {line}: {what}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The number of the line, counted from 1.
        line: u64,
        /// The problem.
        what: String,
    },
    /// A parameter that cannot be fixed, tied or freed as requested, or a bad option.
    #[error("{0}")]
    Parameter(String),
    /// A profile that cannot be fitted, or a synthetic measurement that is impossible.
    #[error("{0}")]
    Profile(String),
    /// A parameter of a fibre out of range.
    #[error(transparent)]
    Fiber(#[from] vellus::Error),
}

impl Error {
    pub(crate) fn file(path: &Path, what: impl ToString) -> Self {
        Error::File { path: path.to_owned(), what: what.to_string() }
    }

    /// An error of the CSV reader. The message names the line.
    pub(crate) fn csv(path: &Path, error: &csv::Error) -> Self {
        match (error.kind(), error.position()) {
            (csv::ErrorKind::UnequalLengths { expected_len, len, .. }, Some(position)) => {
                let what = format!("{len} columns: expected {expected_len}, as in the header");
                Error::line(path, position.line(), what)
            }
            (_, Some(position)) => Error::line(path, position.line(), error),
            _ => Error::file(path, error),
        }
    }

    pub(crate) fn line(path: &Path, line: u64, what: impl ToString) -> Self {
        Error::Line { path: path.to_owned(), line, what: what.to_string() }
    }
}
