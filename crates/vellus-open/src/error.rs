//! Errors and warnings.

use crate::FiberError;
use std::fmt;
use std::path::{Path, PathBuf};
use vellus_scene::{Broken, MAX_COPIED};

/// The reason why a scene cannot be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The name is neither that of a built-in scene nor that of a file of a supported format.
    #[error(
        "{}: neither a built-in scene ({}) nor a .usda, .usdc, .usdz, .abc, .hair, .tfx, .data, .ply, .npy, .npz or .obj file",
        .0.display(),
        vellus_groom::SCENES.map(|(name, _)| name).join(", ")
    )]
    Unknown(PathBuf),
    /// An Alembic archive cannot be read.
    #[error("{}", path.display())]
    Alembic {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: vellus_alembic::Error,
    },
    /// An Alembic archive has nothing that can be shown.
    #[error("{}: it has no curves and no meshes that can be shown{}", path.display(), indented(warnings))]
    Empty {
        /// The file.
        path: PathBuf,
        /// The problem of its objects.
        warnings: Vec<Warning>,
    },
    /// An Alembic archive has no camera with this name or path.
    #[error("{}: it has no camera called {name}", path.display())]
    NoCamera {
        /// The file.
        path: PathBuf,
        /// The name.
        name: String,
    },
    /// An option that is only for files is set for a built-in scene.
    #[error("a width, a camera, a frame and a shutter are for files: the built-in scene {0} has its own")]
    BuiltIn(String),
    /// Copies of the instances of a built-in scene would need too much memory.
    #[error("copies of the instances of {0} would have more than {MAX_COPIED} points")]
    Copies(String),
    /// A camera of the file and a view are set.
    #[error("--camera and --view exclude each other: each sets the camera")]
    TwoCameras,
    /// The body is not a file of a supported format.
    #[error("--body {}: it must be a .obj, .usda, .usdc, .usdz or .abc file", .0.display())]
    Body(PathBuf),
    /// A fibre cannot be changed.
    #[error(transparent)]
    Fiber(#[from] FiberError),
    /// A camera, a frame or a shutter is set for a file that is neither USD nor Alembic.
    #[error("a camera, a frame and a shutter are for USD and Alembic files: {} has none of them", .0.display())]
    NotUsd(PathBuf),
    /// A file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system reports.
        source: std::io::Error,
    },
    /// No strand of a file can be rendered.
    #[error("{}: {broken}: nothing is left", path.display())]
    Broken {
        /// The file.
        path: PathBuf,
        /// Its strands.
        broken: Broken,
    },
    /// There are warnings, and [`Options::strict`](crate::Options::strict) is set.
    #[error("{}", strict(.0))]
    Strict(Vec<Warning>),
    /// A file of strands or polygons is invalid.
    #[error(transparent)]
    Strands(#[from] vellus_groom::Error),
    /// Strands cannot be interpolated.
    #[error("{strands}: {source}")]
    Interpolation {
        /// Their name.
        strands: String,
        /// Why.
        source: vellus_groom::Error,
    },
    /// A value of a group of strands is out of its range, or a mesh cannot grow it.
    #[error(transparent)]
    Group(#[from] vellus_groom::GroupError),
    /// A USD file is invalid.
    #[error(transparent)]
    Usd(#[from] vellus_usd::Error),
    /// A file cannot be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the operating system reports.
        source: std::io::Error,
    },
    /// A .hair file cannot hold these strands.
    #[error("{}: {what}", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// Why not.
        what: String,
    },
    /// A .hair file cannot hold so many sets of strands.
    #[error("a .hair file holds one set of strands, but the scene has {0}")]
    SeveralStrands(usize),
    /// The scene has no mesh.
    #[error("there is no mesh to grow on")]
    NoMesh,
    /// The scene has several meshes, and none was chosen.
    #[error("there are {count} meshes: choose from {known}")]
    SeveralMeshes {
        /// Their number.
        count: usize,
        /// Their names.
        known: String,
    },
    /// The scene has no mesh of this name.
    #[error("there is no mesh '{name}' (there are: {known})")]
    UnknownMesh {
        /// The name.
        name: String,
        /// The names of all meshes.
        known: String,
    },
}

/// All warnings, one a line.
fn strict(warnings: &[Warning]) -> String {
    let lines = indented(warnings);
    let count = if warnings.len() == 1 {
        "a warning is an error".to_owned()
    } else {
        format!("{} warnings are errors", warnings.len())
    };
    format!("{count} with --strict:{lines}")
}

/// Warnings, each on a line of its own.
fn indented(warnings: &[Warning]) -> String {
    warnings.iter().map(|warning| format!("\n  {warning}")).collect()
}

/// A warning about a scene that was opened.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// A USD file has something that is not supported.
    Usd(vellus_usd::Warning),
    /// An Alembic archive has something that is not supported.
    Alembic {
        /// The path of the object, or of the file.
        object: String,
        /// What is not supported, and what happens instead.
        what: String,
    },
    /// A fibre is set in the [`Options`](crate::Options), but strands of the file do not use it.
    UnusedFiber {
        /// The file.
        file: PathBuf,
        /// Why not.
        why: String,
    },
    /// These strands had no widths and got a suggested one.
    SuggestedWidth {
        /// Their name.
        strands: String,
        /// The width.
        width: f32,
    },
    /// Some strands of a file were left out.
    Broken {
        /// The name of the strands.
        strands: String,
        /// Which.
        broken: Broken,
    },
    /// These strands have no widths and were omitted.
    NoWidths(String),
    /// These strands are transparent in their file.
    Transparent(String),
}

impl Warning {
    /// Warnings in words. Those of one [`vellus_usd::Fault`] become one line, with their number and the first of them.
    pub fn lines(warnings: &[Warning]) -> Vec<String> {
        let fault_of = |warning: &Warning| match warning {
            Warning::Usd(warning) => warning.fault,
            _ => None,
        };
        let mut seen = Vec::new();
        let line = |warning: &Warning| {
            let Some(fault) = fault_of(warning) else { return Some(warning.to_string()) };
            if seen.contains(&fault) {
                return None;
            }
            seen.push(fault);
            let all = warnings.iter().filter(|other| fault_of(other) == Some(fault));
            let prims = |warning: &Warning| if let Warning::Usd(warning) = warning { warning.prims.len() } else { 0 };
            Some(match (all.map(prims).sum(), warning) {
                (count @ 2.., Warning::Usd(vellus_usd::Warning { prims, what, .. })) => {
                    format!("{count} {fault} could not be read: the first is {}: {what}", prims[0])
                }
                _ => warning.to_string(),
            })
        };
        warnings.iter().filter_map(line).collect()
    }

    /// A fibre does not apply to a file with its `own` fibres; without any, the file has no strands.
    pub(crate) fn unused_fiber(file: &Path, own: &[&str]) -> Self {
        let why = match own {
            [] => "it has no strands".to_owned(),
            own => format!("strands have fibres of their own materials ({}); --override replaces them", own.join(", ")),
        };
        Warning::UnusedFiber { file: file.to_owned(), why }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Warning::Usd(warning) => warning.fmt(f),
            Warning::Alembic { object, what } => write!(f, "{object}: {what}"),
            Warning::UnusedFiber { file, why } => {
                write!(f, "{}: --fiber and --set are ignored: {why}", file.display())
            }
            Warning::SuggestedWidth { strands, width } => {
                write!(f, "{strands} has no widths: it is rendered with --width {width}")
            }
            Warning::Broken { strands, broken } => write!(f, "{strands}: {broken}"),
            Warning::NoWidths(strands) => write!(f, "{strands}: left out, it has no widths"),
            Warning::Transparent(strands) => write!(f, "{strands}: transparency is not supported: it is opaque"),
        }
    }
}
