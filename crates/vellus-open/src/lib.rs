//! Opens a scene of hair and fur by its name: a built-in scene, a USD file (.usda, .usdc, .usdz), or strands as .hair
//! or .tfx.
//!
//! [`FiberSource`] reads a fibre by its name, [`Growth`] grows fur on the meshes of a file, and [`write()`] writes a
//! scene.
//!
//! ```
//! use vellus_open::{Options, open};
//! # fn main() -> Result<(), vellus_open::Error> {
//! let opened = open("hair-lock", &Options { small: true, ..Options::default() })?;
//! assert_eq!(opened.scene.strands[0].len(), 200);
//! for warning in &opened.warnings {
//!     eprintln!("{warning}");
//! }
//! # Ok(()) }
//! ```

mod digest;
mod error;
mod fiber;
mod grow;
mod mesh;
mod write;

pub use digest::identify;
pub use error::{Error, Warning};
pub use fiber::{FiberError, FiberFormat, FiberSource, SettingError};
pub use grow::{Grown, Growth};
pub use mesh::{choose_meshes, open_coat, open_mesh};
pub use write::write;

use std::path::Path;
use vellus::Fiber;
use vellus_io::Sources;
use vellus_scene::{Look, Scene};
use vellus_usd::FALLBACK_LOOK;

/// Options for opening a scene.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Open the small version of a built-in scene.
    pub small: bool,
    /// Name and fibre of strands whose file defines none. `None` is the preset `red-fox`. Built-in scenes have their
    /// own.
    pub fiber: Option<(String, Fiber)>,
    /// Width (diameter) of strands whose file defines none, in the unit of the file; in [0, 2·10⁹]. If it is `None`,
    /// such strands are an error.
    pub width: Option<f32>,
    /// Keep only this share of the strands, in (0, 1], and widen them so that they cover as much.
    pub strands: Option<f32>,
    /// Camera of a USD file, by name or path. `None` is the first one.
    pub camera: Option<String>,
    /// Time code of a USD file. `None` is its startTimeCode.
    pub frame: Option<f64>,
}

impl Options {
    /// Name and fibre of strands whose file defines none.
    fn fiber(&self) -> (String, Fiber) {
        self.fiber.clone().unwrap_or_else(|| (fiber::DEFAULT.name().to_owned(), Fiber::preset(fiber::DEFAULT)))
    }
}

/// A scene that was opened.
#[derive(Clone, Debug)]
pub struct Opened {
    /// The scene.
    pub scene: Scene,
    /// The files that it was read from; none for a built-in scene.
    pub sources: Sources,
    /// Warnings about the scene.
    pub warnings: Vec<Warning>,
}

/// The format of a scene, from its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// One of [`vellus_groom::SCENES`]. Its name counts before a file of the same name.
    BuiltIn(&'static str),
    /// A USD file.
    Usd,
    /// Strands in the format of Cem Yuksel.
    Hair,
    /// Strands in the format of TressFX.
    Tfx,
}

impl Format {
    /// The format of a scene.
    ///
    /// # Errors
    /// [`Error::Unknown`].
    pub fn of(scene: impl AsRef<Path>) -> Result<Self, Error> {
        let scene = scene.as_ref();
        if let Some((name, _)) = vellus_groom::SCENES.iter().find(|(name, _)| scene.to_str() == Some(name)) {
            return Ok(Format::BuiltIn(name));
        }
        match scene.extension().and_then(|extension| extension.to_str()) {
            Some("hair") => Ok(Format::Hair),
            Some("tfx") => Ok(Format::Tfx),
            Some("usda" | "usdc" | "usdz" | "usd") => Ok(Format::Usd),
            _ => Err(Error::Unknown(scene.to_owned())),
        }
    }
}

/// Checks that a scene may have these options, without reading a file.
///
/// # Errors
/// [`Error::Unknown`], [`Error::BuiltIn`], [`Error::NotUsd`].
pub fn check(scene: impl AsRef<Path>, options: &Options) -> Result<Format, Error> {
    let scene = scene.as_ref();
    let seen = options.camera.is_some() || options.frame.is_some();
    let format = Format::of(scene)?;
    match format {
        Format::BuiltIn(name) if seen || options.fiber.is_some() || options.width.is_some() => {
            Err(Error::BuiltIn(name.to_owned()))
        }
        Format::Hair | Format::Tfx if seen => Err(Error::NotUsd(scene.to_owned())),
        _ => Ok(format),
    }
}

/// Opens a scene: the name of a built-in scene, or the path of a file.
///
/// # Errors
/// Those of [`check`]. [`Error::Read`], [`Error::Strands`] or [`Error::Usd`] if the file cannot be read or is invalid.
pub fn open(scene: impl AsRef<Path>, options: &Options) -> Result<Opened, Error> {
    let mut opened = open_all(scene.as_ref(), options)?;
    if let Some(share) = options.strands {
        opened.scene.strands.iter_mut().for_each(|strands| *strands = vellus_groom::thin(strands, share));
    }
    Ok(opened)
}

/// Opens a scene to measure it. Strands without widths get the width 0 instead of an error.
///
/// # Errors
/// As [`open`].
pub fn open_to_measure(scene: impl AsRef<Path>, options: &Options) -> Result<Opened, Error> {
    let built_in = matches!(Format::of(&scene)?, Format::BuiltIn(_));
    let width = options.width.or((!built_in).then_some(0.0));
    open(scene, &Options { width, ..options.clone() })
}

fn open_all(path: &Path, options: &Options) -> Result<Opened, Error> {
    let file = path.display().to_string();
    let mut sources = Sources::new();
    let strands = match check(path, options)? {
        Format::BuiltIn(name) => {
            let scene = vellus_groom::scene(name, options.small).ok_or_else(|| Error::Unknown(path.to_owned()))?;
            return Ok(Opened { scene, sources, warnings: Vec::new() });
        }
        Format::Usd => return open_usd(path, options),
        Format::Hair => vellus_groom::read_hair(&read(path, ".hair", &mut sources)?, &file, options.width)?,
        Format::Tfx => vellus_groom::read_tfx(&read(path, ".tfx", &mut sources)?, &file, options.width)?,
    };
    let (name, fiber) = options.fiber();
    let scene = Scene { strands: vec![strands], looks: vec![Look::constant(name, fiber)], ..Scene::default() };
    Ok(Opened { scene, sources, warnings: Vec::new() })
}

/// Reads a file, and adds it to `sources` by `name`.
fn read(path: &Path, name: &str, sources: &mut Sources) -> Result<Vec<u8>, Error> {
    let bytes = vellus_io::read_at_most(path, vellus_groom::MAX_FILE_BYTES)
        .map_err(|source| Error::Read { path: path.to_owned(), source })?;
    sources.add(name, &bytes);
    Ok(bytes)
}

fn open_usd(path: &Path, options: &Options) -> Result<Opened, Error> {
    let reader = vellus_usd::Options {
        default_width: options.width,
        frame: options.frame,
        camera: options.camera.clone(),
        shutter: None,
        fallback: options.fiber().1,
    };
    let vellus_usd::Reading { scene, warnings, sources } = vellus_usd::read(path, &reader)?;
    let mut warnings: Vec<Warning> = warnings.into_iter().map(Warning::Usd).collect();
    if options.fiber.is_some() && !scene.looks.iter().any(|look| look.name == FALLBACK_LOOK) {
        let names: Vec<&str> = scene.looks.iter().map(|look| look.name.as_str()).collect();
        let why = if names.is_empty() {
            "it has no strands".to_owned()
        } else {
            format!("its strands have the fibres of its own materials: {}", names.join(", "))
        };
        warnings.push(Warning::UnusedFiber { file: path.to_owned(), why });
    }
    Ok(Opened { scene, sources, warnings })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_that_do_not_fit_are_refused_before_reading() {
        let wide = Options { width: Some(1.0), ..Options::default() };
        let framed = Options { frame: Some(1.0), ..Options::default() };
        assert!(matches!(check("cat", &wide), Err(Error::BuiltIn(name)) if name == "cat"));
        assert!(matches!(check("missing.tfx", &framed), Err(Error::NotUsd(_))));
        assert!(matches!(check("missing.usda", &framed), Ok(Format::Usd)));
        assert!(matches!(check("missing.hair", &wide), Ok(Format::Hair)));
        assert!(check("unicorn", &wide).unwrap_err().to_string().contains("raccoon"));
        assert!(matches!(open("missing.hair", &wide), Err(Error::Read { .. })));
    }
}
