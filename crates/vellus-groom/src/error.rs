//! What can be wrong with a file of strands, or with how fur is to grow.

/// Why strands cannot be read, written or grown.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A file is not what it should be.
    #[error("{file}, byte {offset}: {what}")]
    File {
        /// Its name, as given to the reader.
        file: String,
        /// Where in it.
        offset: usize,
        /// What is wrong there, and what belongs there.
        what: String,
    },
    /// Neither the file nor the caller says how wide the strands are.
    #[error(
        "{file} has no widths: give their diameter with --width, in the file's unit (`vellus groom info` suggests one)"
    )]
    NoWidth {
        /// Its name, as given to the reader.
        file: String,
    },
    /// The width given for strands without one is not a width.
    #[error("the width {0} is out of range: it must be in [0, 2e9]")]
    Width(f32),
    /// A format cannot hold these strands.
    #[error("{strands}: {what}")]
    Unwritable {
        /// The strands' name.
        strands: String,
        /// What does not fit.
        what: String,
    },
    /// A setting of the groom is out of its range.
    #[error("{name} = {value} is out of range: {range}")]
    Setting {
        /// The setting's name.
        name: &'static str,
        /// What was given.
        value: f32,
        /// What is allowed.
        range: &'static str,
    },
    /// There is nowhere for strands to grow: the mesh is empty, or the density 0 all over.
    #[error("{0}: no triangle has both an area and a density")]
    Nowhere(String),
    /// A text file is not what it should be.
    #[error("{file}, line {line}: {what}")]
    Line {
        /// Its name, as given to the reader.
        file: String,
        /// Where in it, from 1 on.
        line: usize,
        /// What is wrong there, and what belongs there.
        what: String,
    },
    /// The mesh itself is broken.
    #[error(transparent)]
    Scene(#[from] vellus_scene::Error),
}
