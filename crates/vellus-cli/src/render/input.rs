//! The scene on the command line.

use crate::fiber_args::{FiberArgs, Overrides};
use crate::say;
use anyhow::{Result, anyhow, bail};
use std::path::PathBuf;
use vellus::Species;
use vellus_io::parse;
use vellus_open::{Error, Format, Markings, Mix, Opened, Options, Ramp, Staging, Tips, Warning};

/// A reflectance on a command line. A list would be several values for clap.
#[derive(Clone, Copy)]
struct Reflectance([f32; 3]);

/// The times of a shutter. An array would be several values for clap.
#[derive(Clone, Copy)]
struct Shutter([f64; 2]);

fn parse_shutter(text: &str) -> Result<Shutter, String> {
    parse::shutter(text).map(Shutter)
}

fn reflectance(text: &str) -> Result<Reflectance, String> {
    vellus_open::reflectance(text).map(Reflectance)
}

/// Which scene.
#[derive(clap::Args, Clone)]
pub struct Input {
    /// A built-in scene (`vellus scene` lists them), a USD file (.usda, .usdc, .usdz), an Alembic archive (.abc),
    /// strands as .hair, .tfx, .data, .ply, .npy or .npz, or meshes as .obj.
    #[arg(default_value = "raccoon", value_name = "SCENE|FILE")]
    pub scene: PathBuf,
    /// Use the small version of a built-in scene.
    #[arg(long)]
    small: bool,
    /// Fibre of strands whose file defines none: a preset (see `vellus fiber list`), a TOML or JSON file, or a
    /// MaterialX material (FILE.mtlx#NAME) [default: red-fox]. It replaces the fibres of a built-in scene.
    #[arg(long, value_name = "NAME|FILE")]
    fiber: Option<PathBuf>,
    #[command(flatten)]
    overrides: Overrides,
    /// --fiber and --set replace the fibres of the file's own materials, too. --set alone keeps their other
    /// parameters.
    #[arg(long = "override")]
    replace: bool,
    /// The coat of a species, such as red-fox: typical colours from root to tip, of the belly and of single hairs, and
    /// its fibre in place of the default of --fiber. --ramp, --belly and --mix replace its parts.
    #[arg(long, value_name = "SPECIES")]
    coat: Option<Species>,
    /// Colour of the tips of all strands: a name, #rrggbb, or R,G,B.
    #[arg(long, value_name = "COLOR", value_parser = reflectance)]
    tip_color: Option<Reflectance>,
    /// Share of the length over which strands get the colour of their tips [default: 30%].
    #[arg(long, value_name = "PERCENT", value_parser = parse::share, requires = "tip_color")]
    tips: Option<f32>,
    /// Colours from root to tip, with spaces between them; an @ gives a position: "black fawn@40% white".
    #[arg(long, value_name = "COLORS")]
    ramp: Option<Ramp>,
    /// Colour where the skin faces down, as on the belly of most animals.
    #[arg(long, value_name = "COLOR", value_parser = reflectance)]
    belly: Option<Reflectance>,
    /// A share of the strands, chosen at random, gets another colour: white:30%. May be repeated.
    #[arg(long, value_name = "COLOR:PERCENT")]
    mix: Vec<Mix>,
    /// How wet the coat is: water around the fibres makes it darker, and strands lie down and stick together.
    #[arg(long, value_name = "PERCENT", value_parser = parse::share)]
    wet: Option<f32>,
    /// What a reflectance is: the colour that this groom shows (groom), or that of a dense coat of its fibres (dense).
    #[arg(long, value_name = "COAT", default_value = "groom", value_parser = ["groom", "dense"])]
    reflectance_of: String,
    /// Width (diameter) of strands whose file defines none, in the unit of the file. `vellus groom info` suggests one,
    /// and `vellus render` uses it.
    #[arg(long, value_name = "WIDTH", value_parser = parse::positive::<f32>)]
    width: Option<f32>,
    /// The number of strands. Below 100%: keep only this share, and widen them to cover as much, for previews. Above
    /// 100%: interpolate between them, for guides and thin coats; at most 10000%.
    #[arg(long, value_parser = parse::multiple, value_name = "PERCENT", allow_hyphen_values = true)]
    pub strands: Option<f32>,
    /// Camera of the file, by name or path [default: that of its RenderSettings, or the first].
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// End with an error if there is a warning about the scene. For farms and checks.
    #[arg(long)]
    strict: bool,
    /// Time code of a USD file, or frame of an Alembic archive.
    #[arg(long, value_name = "TIME", value_parser = parse::real, allow_hyphen_values = true)]
    pub frame: Option<f64>,
    /// When the shutter opens and closes, in frames relative to the frame, e.g. -0.25:0.25. `off` is no motion blur
    /// [default: the shutter of the camera].
    #[arg(long, value_name = "OPEN:CLOSE", value_parser = parse_shutter, allow_hyphen_values = true)]
    shutter: Option<Shutter>,
}

impl Input {
    /// The options of the scene, after checking that they fit it. The scene is not read.
    pub fn options(&self, staging: Option<Staging>) -> Result<Options> {
        let fiber = FiberArgs { fiber: self.fiber.clone(), overrides: self.overrides.clone() };
        if self.replace && !fiber.is_given() {
            bail!("--override needs --fiber or --set");
        }
        let replace = self.replace || matches!(Format::of(&self.scene), Ok(Format::BuiltIn(_)));
        let mut options = Options {
            small: self.small,
            width: self.width,
            strands: self.strands,
            camera: self.camera.clone(),
            frame: self.frame,
            shutter: self.shutter.map(|shutter| shutter.0),
            strict: self.strict,
            markings: Markings {
                ramp: self.ramp.clone(),
                belly: self.belly.map(|color| color.0),
                tips: self.tip_color.map(|color| Tips { color: color.0, share: self.tips.unwrap_or(Tips::SHARE) }),
                mix: self.mix.clone(),
            },
            coat: self.coat,
            wet: self.wet.unwrap_or(0.0),
            reflectance_of: self.reflectance_of.parse().map_err(|error: String| anyhow!(error))?,
            instances: staging.is_some(),
            staging,
            ..Options::default()
        };
        vellus_open::check(&self.scene, &options).map_err(explain)?;
        // The file of the fibre is read after the check.
        if fiber.is_given() && replace {
            options.recolor = Some(fiber.recolor()?);
        } else if fiber.is_given() {
            options.fiber = Some((fiber.name(), fiber.load()?));
        }
        Ok(options)
    }

    /// Opens the scene with [`Input::options`], and prints warnings.
    pub fn open_with(&self, options: &Options) -> Result<Opened> {
        report(vellus_open::open(&self.scene, options))
    }

    /// Prints warnings about the scene that the renderer found, once for all frames.
    pub fn warn(&self, warnings: &[String]) -> Result<()> {
        let kind = if self.strict { "error" } else { "warning" };
        warnings.iter().for_each(|warning| say::note_once(format!("{kind}: {warning}")));
        if self.strict { strict(warnings.len()) } else { Ok(()) }
    }

    /// Opens the scene again, without printing its warnings.
    pub fn open_quietly(&self, staging: Staging) -> Result<Opened> {
        vellus_open::open(&self.scene, &self.options(Some(staging))?).map_err(explain)
    }

    /// Opens the scene for measurements: strands without widths get the width 0.
    pub fn open_to_measure(&self) -> Result<Opened> {
        report(vellus_open::open_to_measure(&self.scene, &self.options(None)?))
    }
}

/// The scene or the error, in terms of options; warnings are printed, once for all frames.
fn report(opened: Result<Opened, Error>) -> Result<Opened> {
    if let Err(Error::Strict(warnings)) = &opened {
        warn(warnings, true)?;
    }
    let opened = opened.map_err(explain)?;
    warn(&opened.warnings, false)?;
    opened.notes().for_each(say::note_once);
    Ok(opened)
}

/// Prints warnings. Those of one kind become one line, unless they are errors: then each has its line.
pub fn warn(warnings: &[Warning], is_strict: bool) -> Result<()> {
    if !is_strict {
        Warning::lines(warnings).iter().for_each(|warning| say::note_once(format!("warning: {warning}")));
        return Ok(());
    }
    warnings.iter().for_each(|warning| say::note_once(format!("error: {warning}")));
    strict(warnings.len())
}

/// The error for warnings with --strict.
fn strict(warnings: usize) -> Result<()> {
    match warnings {
        0 => Ok(()),
        1 => bail!("there is a warning, which is an error with --strict"),
        count => bail!("there are {count} warnings, which are errors with --strict"),
    }
}

/// Names the options that an error is about.
pub fn explain(error: Error) -> anyhow::Error {
    match error {
        Error::BuiltIn(scene) => {
            anyhow!(
                "--width, --camera, --shutter, --frame and --frames are for files: the built-in scene {scene} has its \
                 own"
            )
        }
        Error::Fiber(error) => error.of_option("--set ").into(),
        Error::NotUsd(file) => {
            anyhow!(
                "--shutter, --frame, --frames and --camera are for USD and Alembic files: {} has none",
                file.display()
            )
        }
        Error::SeveralMeshes { .. } => anyhow!("{error} with --on"),
        other => other.into(),
    }
}
