//! Errors.

use std::path::{Path, PathBuf};

/// What can go wrong while a scene is rendered and its picture is stored.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The scene is invalid, or a reflectance model refuses one of its fibres.
    #[error(transparent)]
    Scene(#[from] vellus_scene::Error),
    /// A setting is out of range. The text names the setting and its range.
    #[error("{0}")]
    Settings(String),
    /// The system has no memory for a film of this size.
    #[error(
        "a film of {} x {} pixels needs {:.1} GB of memory, which the system does not give: choose a smaller picture, \
         a crop or fewer layers",
        size[0],
        size[1],
        *bytes as f64 * 1e-9
    )]
    Memory {
        /// Width and height in pixels.
        size: [usize; 2],
        /// Bytes of the film.
        bytes: u64,
    },
    /// The size, area or layers of a film do not match the picture that is rendered into it.
    #[error("the film is of another picture: {0}")]
    OtherFilm(String),
    /// A checkpoint is of another picture, or of samples that the session does not render.
    #[error("{0}")]
    OtherCheckpoint(String),
    /// Rendering was cancelled. The film did not change.
    #[error("rendering was cancelled")]
    Cancelled,
    /// The bytes of a checkpoint or of a picture are not in the format of this version.
    #[error("{0}")]
    Malformed(String),
    /// An encoder of pictures failed.
    #[error("cannot encode {format}: {what}")]
    Encode {
        /// The file format.
        format: &'static str,
        /// What the encoder reports.
        what: String,
    },
    /// A file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system reports.
        source: std::io::Error,
    },
    /// A file cannot be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the operating system reports.
        source: std::io::Error,
    },
    /// A film or a picture could not be written. Its samples are where `rescue` says.
    #[error("the picture is not written{}", rescued(rescue, *samples))]
    NotWritten {
        /// Where the samples are.
        rescue: Rescue,
        /// Samples a pixel.
        samples: u64,
        /// Whether these are all samples that were planned.
        complete: bool,
        /// Why it could not be written.
        source: Box<Error>,
    },
    /// A film in a file is not what this version writes, or does not fit the others.
    #[error("{}: {what}", path.display())]
    Film {
        /// The file.
        path: PathBuf,
        /// The problem.
        what: String,
    },
    /// Films that cannot be merged.
    #[error("{0}")]
    Merge(String),
    /// A GPU is missing, cannot render the scene, or was lost.
    #[error("{0}")]
    Device(String),
    /// A GPU was lost while it rendered.
    #[error("{what}; {samples} samples a pixel are kept{}", kept.as_ref().map_or(String::new(), in_file))]
    DeviceLost {
        /// What the driver reports.
        what: String,
        /// Samples a pixel that are kept.
        samples: u64,
        /// The checkpoint with these samples. `None` if it could not be written.
        kept: Option<PathBuf>,
    },
    /// Intel Open Image Denoise is missing, or it failed.
    #[error("{0}")]
    Denoise(String),
}

/// Where the samples are after their picture could not be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Rescue {
    /// All of them are in this film.
    Saved(PathBuf),
    /// Only those of the last checkpoint are left.
    LastCheckpoint(PathBuf),
    /// They are lost, and why.
    Lost(String),
}

fn in_file(path: impl AsRef<Path>) -> String {
    format!(" in {}", path.as_ref().display())
}

/// Says where the samples of a picture are that could not be written.
fn rescued(rescue: &Rescue, samples: u64) -> String {
    match rescue {
        Rescue::Saved(path) => format!("; all {samples} samples a pixel are kept in {}", path.display()),
        Rescue::LastCheckpoint(path) => format!("; {} has the samples of the last checkpoint", path.display()),
        Rescue::Lost(why) => format!(", and the samples could not be saved anywhere: {why}"),
    }
}
