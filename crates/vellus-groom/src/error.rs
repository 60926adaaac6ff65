//! Errors of reading, writing and growing strands.

/// The reason why strands cannot be read, written or grown.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A binary file is invalid.
    #[error("{file}, byte {offset}: {what}")]
    File {
        /// Its name, as given to the reader.
        file: String,
        /// Offset of the problem in bytes.
        offset: usize,
        /// The problem, and what is expected.
        what: String,
    },
    /// Neither the file nor the caller sets the width of the strands.
    #[error(
        "{file} has no widths: set a diameter in the unit of the file with --width (`vellus groom info` suggests one)"
    )]
    NoWidth {
        /// Its name, as given to the reader.
        file: String,
    },
    /// The default width is out of range.
    #[error("the width {0} is out of range: it must be in [0, 2e9]")]
    Width(f32),
    /// The file format does not support these strands.
    #[error("{strands}: {what}")]
    Unwritable {
        /// The name of the strands.
        strands: String,
        /// What is not supported.
        what: String,
    },
    /// A setting of the groom is out of range.
    #[error("{name} = {value} is out of range: {range}")]
    Setting {
        /// The name of the setting.
        name: &'static str,
        /// The value.
        value: f32,
        /// The allowed range.
        range: &'static str,
    },
    /// Strands cannot grow anywhere: the mesh is empty, or the density is 0 everywhere.
    #[error("{0}: no triangle has both an area and a density")]
    Nowhere(String),
    /// A text file is invalid.
    #[error("{file}, line {line}: {what}")]
    Line {
        /// Its name, as given to the reader.
        file: String,
        /// Line of the problem, from 1.
        line: usize,
        /// The problem, and what is expected.
        what: String,
    },
    /// The mesh or the resulting strands are not valid.
    #[error(transparent)]
    Scene(#[from] vellus_scene::Error),
}
