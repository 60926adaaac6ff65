//! The scene on the command line.

use crate::fiber_args::{FiberArgs, Overrides};
use crate::say::note;
use anyhow::{Result, anyhow};
use std::path::PathBuf;
use vellus::Fiber;
use vellus_io::parse;
use vellus_open::{Error, Opened, Options, Warning};

/// Which scene.
#[derive(clap::Args, Clone)]
pub struct Input {
    /// A built-in scene (`vellus scene` lists them), a USD file (.usda, .usdc, .usdz), or strands as .hair or .tfx.
    #[arg(default_value = "raccoon", value_name = "SCENE|FILE")]
    pub scene: PathBuf,
    /// Use the small version of a built-in scene.
    #[arg(long)]
    small: bool,
    /// Fibre of strands whose file defines none: a preset (see `vellus fiber list`), or a TOML or JSON file
    /// [default: red-fox]. Built-in scenes have their own fibres.
    #[arg(long, value_name = "NAME|FILE")]
    fiber: Option<PathBuf>,
    #[command(flatten)]
    overrides: Overrides,
    /// Width (diameter) of strands whose file defines none, in the unit of the file.
    #[arg(long, value_name = "WIDTH", value_parser = parse::positive::<f32>)]
    width: Option<f32>,
    /// Keep only this share of the strands, and widen them to cover as much. For previews.
    #[arg(long, value_parser = parse::share, value_name = "PERCENT", allow_hyphen_values = true)]
    strands: Option<f32>,
    /// Camera of a USD file, by name or path [default: the first].
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// Time code of a USD file.
    #[arg(long, value_name = "TIME", value_parser = parse::real, allow_hyphen_values = true)]
    pub frame: Option<f64>,
}

impl Input {
    /// The options of the scene, after checking that they fit it. The scene is not read.
    pub fn options(&self) -> Result<Options> {
        let fiber = FiberArgs { fiber: self.fiber.clone(), overrides: self.overrides.clone() };
        let mut options = Options {
            small: self.small,
            // Its file is read after the check.
            fiber: fiber.is_given().then(|| (fiber.name(), Fiber::hair())),
            width: self.width,
            strands: self.strands,
            camera: self.camera.clone(),
            frame: self.frame,
        };
        vellus_open::check(&self.scene, &options).map_err(explain)?;
        if let Some((_, parameters)) = &mut options.fiber {
            *parameters = fiber.load()?;
        }
        Ok(options)
    }

    /// Opens the scene, and prints warnings.
    pub fn open(&self) -> Result<Opened> {
        report(vellus_open::open(&self.scene, &self.options()?))
    }

    /// Opens the scene for measurements: strands without widths get the width 0.
    pub fn open_to_measure(&self) -> Result<Opened> {
        report(vellus_open::open_to_measure(&self.scene, &self.options()?))
    }
}

/// The scene or the error, in terms of options; warnings are printed.
fn report(opened: Result<Opened, Error>) -> Result<Opened> {
    let opened = opened.map_err(explain)?;
    for warning in &opened.warnings {
        match warning {
            Warning::UnusedFiber { file, why } => {
                note!("warning: --fiber and --set change nothing in {}: {why}", file.display());
            }
            other => note!("warning: {other}"),
        }
    }
    Ok(opened)
}

/// Names the options that an error is about.
pub fn explain(error: Error) -> anyhow::Error {
    match error {
        Error::BuiltIn(scene) => anyhow!(
            "--fiber, --set, --width, --camera, --frame and --frames are for files: the built-in scene {scene} has its \
             own"
        ),
        Error::NotUsd(file) => {
            anyhow!("--frame, --frames and --camera are for USD files: {} has neither", file.display())
        }
        Error::SeveralMeshes { .. } => anyhow!("{error} with --on"),
        other => other.into(),
    }
}
