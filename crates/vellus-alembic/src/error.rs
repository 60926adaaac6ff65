//! Errors of archives.

/// The reason why an archive, or an object of it, cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The file is an Alembic archive in HDF5, the format before 2013.
    #[error(
        "this Alembic file is stored as HDF5, and only Ogawa can be read: convert it with \
         `abcconvert -toOgawa OLD.abc NEW.abc`, a program of the Alembic library"
    )]
    Hdf5,
    /// The file cannot be read.
    #[error("it cannot be read: {0}")]
    Read(String),
    /// The file is no Alembic archive.
    #[error("it is not an Alembic archive")]
    NotAlembic,
    /// The program that wrote the file did not finish.
    #[error("the archive is not complete: the program that wrote it did not close it")]
    NotClosed,
    /// The version of the format is not known.
    #[error("the version of the {what} is {found}: it must be {allowed}")]
    Version {
        /// Which format.
        what: &'static str,
        /// The version of the file.
        found: i64,
        /// Those that can be read.
        allowed: &'static str,
    },
    /// The archive is damaged.
    #[error("the archive is damaged at byte {at}: {what}")]
    Damaged {
        /// The place in the file.
        at: usize,
        /// The problem, and what is expected.
        what: String,
    },
    /// A property is missing, or has a type or a size that its schema does not allow.
    #[error("{property} {what}")]
    Property {
        /// The name of the property.
        property: String,
        /// The problem, and what is expected.
        what: String,
    },
}

/// An error at a place of the file.
pub(crate) fn damaged(at: usize, what: impl Into<String>) -> Error {
    Error::Damaged { at, what: what.into() }
}

/// An error of a property.
pub(crate) fn wrong(property: &str, what: impl Into<String>) -> Error {
    Error::Property { property: property.to_owned(), what: what.into() }
}
