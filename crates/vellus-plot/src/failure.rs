//! Errors of pictures and reports.

use plotters::drawing::DrawingAreaErrorKind;
use std::io;
use std::path::{Path, PathBuf};

/// A picture or report that cannot be made or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file name with another extension.
    #[error("{}: the name must end in .png or .svg", .0.display())]
    Extension(PathBuf),
    /// A file that cannot be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The drawing library failed.
    #[error("cannot draw: {0}")]
    Draw(String),
    /// A picture that cannot be encoded as PNG.
    #[error("cannot encode PNG: {0}")]
    Png(#[from] png::EncodingError),
    /// A window without width, for a picture of averages.
    #[error("the window from {low} to {high} has no width")]
    Window {
        /// Its lower end.
        low: f64,
        /// Its upper end.
        high: f64,
    },
    /// A query out of range, or a line that is not a query.
    #[error("{0}")]
    Query(String),
    /// A broken CSV file.
    #[error(transparent)]
    Csv(#[from] csv::Error),
    /// A fibre or table out of range.
    #[error(transparent)]
    Fiber(#[from] vellus::Error),
    /// A fitted model out of range.
    #[error(transparent)]
    Fit(#[from] vellus_fit::Error),
}

/// A result with [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

impl<E: std::error::Error + Send + Sync> From<DrawingAreaErrorKind<E>> for Error {
    fn from(error: DrawingAreaErrorKind<E>) -> Self {
        Error::Draw(error.to_string())
    }
}

/// Writes a file.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    vellus_io::write(path, bytes).map_err(|source| Error::Write { path: path.to_owned(), source })
}
