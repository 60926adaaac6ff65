//! What is rendered: a built-in scene, or a file.

use crate::fiber_args::FiberArgs;
use crate::say::note;
use anyhow::{Context, Result, bail};
use std::path::Path;
use vellus_scene::{Look, Scene};

/// A scene.
#[derive(clap::Args, Clone)]
pub struct Input {
    /// A built-in scene (`vellus scene` lists them); a USD file (.usda, .usdc, .usdz); strands as .hair or .tfx.
    #[arg(default_value = "raccoon", value_name = "SCENE|FILE")]
    scene: String,
    /// The small version of a built-in scene.
    #[arg(long)]
    small: bool,
    #[command(flatten)]
    fiber: FiberArgs,
    /// Width (diameter) of strands whose file has none, in the file's unit.
    #[arg(long, value_name = "WIDTH")]
    width: Option<f32>,
    /// A share of the strands only, wider so that they cover as much: for previews.
    #[arg(long, value_parser = share, value_name = "PERCENT")]
    strands: Option<f32>,
    /// Camera of a USD file, by name or path; the first without it.
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// Time code of a USD file.
    #[arg(long, value_name = "TIME", allow_negative_numbers = true)]
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

/// Reads a USD file, and says what is left out.
pub fn load_usd(path: &Path, options: &vellus_usd::Options) -> Result<Scene> {
    let (scene, warnings) = vellus_usd::read(path, options)?;
    for warning in warnings {
        note!("warning: {warning}");
    }
    Ok(scene)
}

impl Input {
    /// Reads or grows it.
    pub fn load(&self) -> Result<Scene> {
        let mut scene = self.whole()?;
        if let Some(share) = self.strands {
            scene.strands.iter_mut().for_each(|strands| *strands = vellus_groom::thin(strands, share));
        }
        Ok(scene)
    }

    fn whole(&self) -> Result<Scene> {
        if let Some(scene) = vellus_groom::scene(&self.scene, self.small) {
            if !self.fiber.is_default() || self.width.is_some() || self.camera.is_some() || self.frame.is_some() {
                bail!(
                    "--fiber, --set, --width, --camera, --frame and --frames are for files: a built-in scene has its own"
                );
            }
            return Ok(scene);
        }
        let path = Path::new(&self.scene);
        let strands = path.extension().is_some_and(|e| e == "hair" || e == "tfx");
        if strands && (self.frame.is_some() || self.camera.is_some()) {
            bail!("--frame, --frames and --camera are for USD files: {} has neither", self.scene);
        }
        let read = || std::fs::read(path).with_context(|| format!("cannot read {}", path.display()));
        let strands = match path.extension().and_then(|e| e.to_str()) {
            Some("hair") => vellus_groom::read_hair(&read()?, &self.scene, self.width)?,
            Some("tfx") => vellus_groom::read_tfx(&read()?, &self.scene, self.width)?,
            Some("usda" | "usdc" | "usdz" | "usd") => return self.usd(path),
            _ => {
                let names: Vec<_> = vellus_groom::SCENES.iter().map(|(name, _)| *name).collect();
                bail!(
                    "{}: neither a built-in scene ({}) nor a .usda, .usdc, .usdz, .hair or .tfx file",
                    self.scene,
                    names.join(", ")
                );
            }
        };
        let look = Look::constant(self.fiber.name(), self.fiber.load()?);
        Ok(Scene { strands: vec![strands], looks: vec![look], ..Scene::default() })
    }

    fn usd(&self, path: &Path) -> Result<Scene> {
        let options = vellus_usd::Options {
            default_width: self.width,
            frame: self.frame,
            camera: self.camera.clone(),
            shutter: None,
            fallback: self.fiber.load()?,
        };
        load_usd(path, &options)
    }

    /// The scene or file.
    pub fn name(&self) -> String {
        self.scene.clone()
    }

    /// Another frame of it.
    pub fn set_frame(&mut self, frame: f64) {
        self.frame = Some(frame);
    }

    /// What tells it from other scenes.
    pub fn identity(&self) -> Result<String> {
        let modified = std::fs::metadata(&self.scene).and_then(|m| m.modified()).ok();
        let more = (&self.camera, self.frame, self.strands);
        Ok(format!("{} {} {:?} {:?} {more:?} {modified:?}", self.scene, self.small, self.fiber.load()?, self.width))
    }
}
