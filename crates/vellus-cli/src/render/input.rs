//! What is rendered: a built-in scene, or a file.

use crate::fiber_args::{FiberArgs, Overrides};
use crate::number::finite;
use crate::say::note;
use anyhow::{Context, Result, bail};
use std::path::{Path, PathBuf};
use vellus_io::{DigestBuilder, Sources};
use vellus_render::session::{add_fiber, optional};
use vellus_scene::{Look, Scene};
use vellus_usd::FALLBACK_LOOK;

/// Which scene.
#[derive(clap::Args, Clone)]
pub struct Input {
    /// A built-in scene (`vellus scene` lists them), a USD file (.usda, .usdc, .usdz), or strands as .hair or .tfx.
    #[arg(default_value = "raccoon", value_name = "SCENE|FILE")]
    scene: PathBuf,
    /// Render the small version of a built-in scene.
    #[arg(long)]
    small: bool,
    /// Fibre of strands whose file defines none: a preset (see `vellus fiber list`), or a TOML or JSON file
    /// [default: red-fox]. Built-in scenes have their own fibres.
    #[arg(long, value_name = "NAME|FILE")]
    fiber: Option<PathBuf>,
    #[command(flatten)]
    overrides: Overrides,
    /// Width (diameter) of strands whose file defines none, in the file's unit.
    #[arg(long, value_name = "WIDTH", value_parser = width)]
    width: Option<f32>,
    /// Render only this share of the strands, and widen them so that they cover as much: for previews.
    #[arg(long, value_parser = share, value_name = "PERCENT", allow_hyphen_values = true)]
    strands: Option<f32>,
    /// Camera of a USD file, by name or path [default: the first].
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// Time code of a USD file.
    #[arg(long, value_name = "TIME", value_parser = time_code, allow_hyphen_values = true)]
    frame: Option<f64>,
}

fn share(text: &str) -> Result<f32, String> {
    let percent = text.strip_suffix('%').unwrap_or(text).parse().unwrap_or(f32::NAN);
    if percent > 0.0 && percent <= 100.0 {
        Ok(percent / 100.0)
    } else {
        Err("a share is above 0% and at most 100%".to_owned())
    }
}

fn width(text: &str) -> Result<f32, String> {
    finite(text, |x| x > 0.0, " above 0")
}

fn time_code(text: &str) -> Result<f64, String> {
    finite(text, |_| true, "")
}

/// Is there a built-in scene of this name?
pub fn is_built_in(name: &str) -> bool {
    vellus_groom::SCENES.iter().any(|(known, _)| *known == name)
}

/// The kind of an input, from its name.
enum Kind<'a> {
    BuiltIn(&'a str),
    Usd,
    Hair,
    Tfx,
}

/// Reads a USD file, and reports its warnings.
pub fn load_usd(path: &Path, options: &vellus_usd::Options) -> Result<vellus_usd::Reading> {
    let reading = vellus_usd::read(path, options)?;
    for warning in &reading.warnings {
        note!("warning: {warning}");
    }
    Ok(reading)
}

impl Input {
    /// Refuses names and options that do not fit together, before any file is read.
    pub fn check(&self) -> Result<()> {
        match self.kind()? {
            Kind::BuiltIn(name) => {
                let seen = self.camera.is_some() || self.frame.is_some();
                if self.fiber().is_given() || self.width.is_some() || seen {
                    bail!(
                        "--fiber, --set, --width, --camera, --frame and --frames are for files: the built-in scene \
                         {name} has its own"
                    );
                }
            }
            Kind::Hair | Kind::Tfx => {
                if self.frame.is_some() || self.camera.is_some() {
                    bail!("--frame, --frames and --camera are for USD files: {} has neither", self.scene.display());
                }
            }
            Kind::Usd => {}
        }
        self.fiber().load().map(|_| ())
    }

    fn kind(&self) -> Result<Kind<'_>> {
        if let Some(name) = self.scene.to_str().filter(|name| is_built_in(name)) {
            return Ok(Kind::BuiltIn(name));
        }
        match self.scene.extension().and_then(|e| e.to_str()) {
            Some("hair") => Ok(Kind::Hair),
            Some("tfx") => Ok(Kind::Tfx),
            Some("usda" | "usdc" | "usdz" | "usd") => Ok(Kind::Usd),
            _ => {
                let names: Vec<_> = vellus_groom::SCENES.iter().map(|(name, _)| *name).collect();
                bail!(
                    "{}: neither a built-in scene ({}) nor a .usda, .usdc, .usdz, .hair or .tfx file",
                    self.scene.display(),
                    names.join(", ")
                );
            }
        }
    }

    fn fiber(&self) -> FiberArgs {
        FiberArgs { fiber: self.fiber.clone(), overrides: self.overrides.clone() }
    }

    /// Reads or grows the scene.
    pub fn load(&self) -> Result<Scene> {
        self.load_with_sources().map(|(scene, _)| scene)
    }

    /// Loads the scene for measurements: strands without widths get the width 0.
    pub fn load_to_measure(&self) -> Result<Scene> {
        let built_in = matches!(self.kind()?, Kind::BuiltIn(_));
        let width = self.width.or((!built_in).then_some(0.0));
        Input { width, ..self.clone() }.load()
    }

    /// Reads or grows the scene, and returns the files that it was read from. A built-in scene has none: its name identifies
    /// it.
    pub fn load_with_sources(&self) -> Result<(Scene, Sources)> {
        let (mut scene, sources) = self.whole()?;
        if let Some(share) = self.strands {
            scene.strands.iter_mut().for_each(|strands| *strands = vellus_groom::thin(strands, share));
        }
        Ok((scene, sources))
    }

    fn whole(&self) -> Result<(Scene, Sources)> {
        self.check()?;
        let path = &self.scene;
        let mut sources = Sources::new();
        let mut read = |name| -> Result<Vec<u8>> {
            let bytes = vellus_io::read_at_most(path, vellus_groom::MAX_FILE_BYTES)
                .with_context(|| format!("cannot read {}", path.display()))?;
            sources.add(name, &bytes);
            Ok(bytes)
        };
        let name = self.name();
        let strands = match self.kind()? {
            Kind::BuiltIn(name) => {
                let scene =
                    vellus_groom::scene(name, self.small).with_context(|| format!("there is no scene {name}"))?;
                return Ok((scene, sources));
            }
            Kind::Usd => return self.usd(),
            Kind::Hair => vellus_groom::read_hair(&read(".hair")?, &name, self.width)?,
            Kind::Tfx => vellus_groom::read_tfx(&read(".tfx")?, &name, self.width)?,
        };
        let look = Look::constant(self.fiber().name(), self.fiber().load()?);
        Ok((Scene { strands: vec![strands], looks: vec![look], ..Scene::default() }, sources))
    }

    fn usd(&self) -> Result<(Scene, Sources)> {
        let options = vellus_usd::Options {
            default_width: self.width,
            frame: self.frame,
            camera: self.camera.clone(),
            shutter: None,
            fallback: self.fiber().load()?,
        };
        let reading = load_usd(&self.scene, &options)?;
        let looks = &reading.scene.looks;
        if self.fiber().is_given() && !looks.iter().any(|look| look.name == FALLBACK_LOOK) {
            let names: Vec<&str> = looks.iter().map(|look| look.name.as_str()).collect();
            let own = if names.is_empty() {
                "it has no strands".to_owned()
            } else {
                format!("its strands have the fibres of its own materials: {}", names.join(", "))
            };
            note!("warning: --fiber and --set change nothing in {}: {own}", self.scene.display());
        }
        Ok((reading.scene, reading.sources))
    }

    /// The name of the scene or the file.
    pub fn name(&self) -> String {
        self.scene.display().to_string()
    }

    /// Chooses another frame.
    pub fn set_frame(&mut self, frame: f64) {
        self.frame = Some(frame);
    }

    /// Adds what identifies the scene, except for the files that it is read from.
    pub fn add_to(&self, builder: DigestBuilder) -> Result<DigestBuilder> {
        // The content of its files identifies a scene, its name a built-in one.
        let built_in = self.scene.to_str().filter(|name| is_built_in(name));
        let builder = builder
            .field("scene", built_in.unwrap_or(""))
            .field("small", [u8::from(self.small)])
            .field("width", optional(self.width.map(f32::to_le_bytes)))
            .field("strands", optional(self.strands.map(f32::to_le_bytes)))
            .field("camera", self.camera.as_deref().unwrap_or(""))
            .field("frame", optional(self.frame.map(f64::to_le_bytes)));
        // A built-in scene has its own fibres.
        if built_in.is_some() { Ok(builder) } else { Ok(add_fiber(builder, &self.fiber().load()?)) }
    }
}
