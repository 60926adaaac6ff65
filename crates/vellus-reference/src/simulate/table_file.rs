//! Files of medulla tables.

use std::io;
use std::path::{Path, PathBuf};
use vellus::{TableData, Tables};

/// The largest file that is read: 1 GiB. The shipped tables are smaller than 1 MiB.
const MAX_BYTES: u64 = 1 << 30;

/// Why a table file cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system reports.
        source: io::Error,
    },
    /// The file is no table file, or it is damaged.
    #[error("{name}")]
    Table {
        /// The file.
        name: String,
        /// The problem.
        source: vellus::Error,
    },
}

/// Reads a table file, and returns its size in bytes too. Without a file, these are the tables that `vellus` contains.
///
/// # Errors
/// [`ReadError`] if the file cannot be read or is damaged.
pub fn read_tables(file: Option<&Path>) -> Result<(TableData, usize), ReadError> {
    let parse = |bytes: &[u8], name: String| match TableData::from_bytes(bytes) {
        Ok(data) => Ok((data, bytes.len())),
        Err(source) => Err(ReadError::Table { name, source }),
    };
    let Some(path) = file else { return parse(Tables::SHIPPED, "the shipped tables".to_owned()) };
    let bytes = vellus_io::read_at_most(path, MAX_BYTES);
    let bytes = bytes.map_err(|source| ReadError::Read { path: path.to_owned(), source })?;
    parse(&bytes, path.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_tables_are_the_default() {
        let (data, bytes) = read_tables(None).unwrap();
        assert_eq!((data.to_bytes().unwrap(), bytes), (Tables::SHIPPED.to_vec(), Tables::SHIPPED.len()));
        let missing = read_tables(Some(Path::new("missing.vellus"))).unwrap_err();
        assert_eq!(missing.to_string(), "cannot read missing.vellus");
    }
}
