//! What can go wrong with a file.

use std::fmt;
use std::path::{Path, PathBuf};

/// Why a file was not read or written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file, or one it refers to, is missing or broken.
    #[error("{}: {what}", file.display())]
    File {
        /// The file that was to be read or written.
        file: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// A file cannot be written.
    #[error("cannot write {}", file.display())]
    Write {
        /// The file.
        file: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// A prim has something that is inconsistent or outside its range.
    #[error("{prim}: {what}")]
    Prim {
        /// Its path in the stage.
        prim: String,
        /// What is wrong, and what is allowed.
        what: String,
    },
    /// No strand and no mesh is visible.
    #[error("{}: nothing to render{skipped}", file.display())]
    Empty {
        /// The file.
        file: PathBuf,
        /// What it has that is not supported, in brackets, or nothing.
        skipped: String,
    },
    /// The scene does not hold together: [`vellus_scene::Scene::validate`].
    #[error(transparent)]
    Scene(#[from] vellus_scene::Error),
}

impl Error {
    pub(crate) fn file(file: &Path, what: impl fmt::Display) -> Self {
        Error::File { file: file.to_owned(), what: what.to_string() }
    }

    pub(crate) fn write(file: &Path, source: std::io::Error) -> Self {
        Error::Write { file: file.to_owned(), source }
    }

    pub(crate) fn prim(prim: &str, what: impl Into<String>) -> Self {
        Error::Prim { prim: prim.to_owned(), what: what.into() }
    }
}
