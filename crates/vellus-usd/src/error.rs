//! Errors of reading and writing USD.

use std::fmt;
use std::path::{Path, PathBuf};

/// The reason why a file was not read or written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file cannot be read.
    #[error("cannot read {}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The file is broken, or a file that it refers to is missing or broken.
    #[error("{}: {what}", file.display())]
    File {
        /// The file with the problem.
        file: PathBuf,
        /// The problem.
        what: String,
    },
    /// A file cannot be written.
    #[error("cannot write {}", file.display())]
    Write {
        /// The file.
        file: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// A prim has values that are inconsistent or out of range.
    #[error("{prim}: {what}")]
    Prim {
        /// The path of the prim in the stage.
        prim: String,
        /// The problem, and the allowed values.
        what: String,
    },
    /// The stage has no visible strand and no visible mesh.
    #[error("{}: nothing to render: {skipped}", file.display())]
    Empty {
        /// The file.
        file: PathBuf,
        /// What the stage has instead, and its warnings in brackets.
        skipped: String,
    },
    /// The scene is not valid: see [`vellus_scene::Scene::validate`].
    #[error(transparent)]
    Scene(#[from] vellus_scene::Error),
}

impl Error {
    pub(crate) fn file(file: &Path, what: impl fmt::Display) -> Self {
        Error::File { file: file.to_owned(), what: what.to_string() }
    }

    pub(crate) fn read(file: &Path, source: std::io::Error) -> Self {
        Error::Read { file: file.to_owned(), source }
    }

    pub(crate) fn write(file: &Path, source: std::io::Error) -> Self {
        Error::Write { file: file.to_owned(), source }
    }

    pub(crate) fn prim(prim: &str, what: impl Into<String>) -> Self {
        Error::Prim { prim: prim.to_owned(), what: what.into() }
    }
}

/// The reason why the content of a file is invalid. [`Error::File`] adds the name of the file, [`Error::Prim`] that of
/// the prim.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub(crate) struct Invalid(pub String);

impl From<String> for Invalid {
    fn from(what: String) -> Self {
        Invalid(what)
    }
}

impl From<&str> for Invalid {
    fn from(what: &str) -> Self {
        Invalid(what.to_owned())
    }
}

impl From<Invalid> for String {
    fn from(invalid: Invalid) -> Self {
        invalid.0
    }
}
