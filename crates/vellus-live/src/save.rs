//! Files for the browser to save, and files that it loads.

use crate::session::Session;
use std::io::Write;
use std::path::Path;
use vellus_open::{FiberFormat, Opened, Options};
use vellus_render::session::camera_notes;
use vellus_render::{Denoised, Film, Layer, PixelType};
use vellus_scene::Scene;
use vellus_usd::Format;

/// What is saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Save {
    /// The fibre of a look as TOML.
    LookToml(usize),
    /// The fibre of a look as a USD material.
    LookUsd(usize),
    /// The whole scene as binary USD, without its images: the text of many strands is large.
    Scene,
    /// The lights as USD.
    Lights,
    /// The camera as USD.
    Camera,
    /// The picture as PNG, after exposure.
    Png,
    /// The picture as OpenEXR, without exposure.
    Exr,
}

impl Save {
    /// What a file name stands for: `look-0.toml`, `look-0.usda`, `scene.usdc`, `lights.usda`,
    /// `camera.usda`, `picture.png` or `picture.exr`.
    pub fn parse(name: &str) -> Option<Self> {
        let number = |text: &str| text.parse().ok().filter(|_| text.len() < 6);
        match name {
            "scene.usdc" => Some(Save::Scene),
            "lights.usda" => Some(Save::Lights),
            "camera.usda" => Some(Save::Camera),
            "picture.png" => Some(Save::Png),
            "picture.exr" => Some(Save::Exr),
            _ => {
                let look = name.strip_prefix("look-")?;
                let toml = look.strip_suffix(".toml").and_then(number).map(Save::LookToml);
                toml.or_else(|| look.strip_suffix(".usda").and_then(number).map(Save::LookUsd))
            }
        }
    }

    /// The media type.
    pub fn media(self) -> &'static str {
        match self {
            Save::LookToml(_) => "application/toml",
            Save::LookUsd(_) | Save::Lights | Save::Camera => "model/vnd.usda",
            // The binary format has no registered type.
            Save::Scene => "application/octet-stream",
            Save::Png => "image/png",
            Save::Exr => "image/x-exr",
        }
    }
}

/// The bytes of a file. `film` is the picture at full resolution, if there is one.
pub fn bytes(
    what: Save,
    session: &Session,
    film: Option<&Film>,
    denoised: Option<&Denoised>,
) -> Result<Vec<u8>, String> {
    let film = || film.ok_or("the picture is not ready: wait for the first sample at full resolution");
    let look = |index: usize| session.look(index).ok_or("the look does not exist");
    match what {
        Save::LookToml(index) => {
            let (_, fiber) = look(index)?;
            FiberFormat::Toml.write(fiber).map(String::into_bytes).map_err(|error| error.to_string())
        }
        Save::LookUsd(index) => {
            look(index)?;
            usd(&session.part(Some(index)), Format::Text, || false)
        }
        Save::Scene => usd(&session.scene(), Format::Crate, || false),
        Save::Lights => usd(&session.lamps(), Format::Text, || false),
        Save::Camera => usd(&session.part(None), Format::Text, || false),
        Save::Png => film()?
            .to_png(denoised.map(|denoised| &denoised.beauty[..]), session.display(), &[])
            .map_err(|error| error.to_string()),
        Save::Exr => {
            let film = film()?;
            let notes = camera_notes(&session.orbit.camera(), film.whole());
            let exr = film.to_exr(&[Layer::Beauty], denoised, PixelType::Half, &notes);
            exr.map_err(|error| error.to_string())
        }
    }
}

/// A scene without textures as a USD file. The work ends early if it is `cancelled`.
pub fn usd(scene: &Scene, format: Format, cancelled: impl Fn() -> bool) -> Result<Vec<u8>, String> {
    let mut out = Cancelled { bytes: Vec::new(), cancelled };
    vellus_usd::write_to(scene, format, &mut out).map_err(|error| chain(&error))?;
    Ok(out.bytes)
}

/// Keeps what is written, until nobody needs it.
struct Cancelled<F> {
    bytes: Vec<u8>,
    cancelled: F,
}

impl<F: Fn() -> bool> Write for Cancelled<F> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        if (self.cancelled)() {
            return Err(std::io::Error::other("nobody waits for the file"));
        }
        self.bytes.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// Opens the strands or meshes of a dropped file. `temporary` is a folder for it.
pub fn load(name: &str, bytes: Vec<u8>, temporary: &Path) -> Result<Session, String> {
    // Only formats without references to other files: a page must not read files of the server.
    let extension = Path::new(name).extension().and_then(|extension| extension.to_str()).map(str::to_lowercase);
    let extension = match extension.as_deref() {
        Some(known @ ("abc" | "hair" | "tfx" | "data" | "ply" | "npy" | "npz" | "obj")) => known.to_owned(),
        Some("usd" | "usda" | "usdc" | "usdz") => {
            let why = "USD files may name other files: start the server with --folder and open it there";
            return Err(why.to_owned());
        }
        _ => return Err("this is no groom: drop an .abc, .hair, .tfx, .data, .ply, .npy, .npz or .obj file".to_owned()),
    };
    let folder = tempfile::tempdir_in(temporary).map_err(|error| format!("no temporary folder: {error}"))?;
    let path = folder.path().join(format!("dropped.{extension}"));
    std::fs::write(&path, &bytes).map_err(|error| format!("no temporary file: {error}"))?;
    drop(bytes);
    let options = Options { staging: Some(vellus_open::Staging::new(1.5)), ..Options::default() };
    let shown = |error: String| error.replace(&path.display().to_string(), "the file");
    let opened: Opened = vellus_open::open(&path, &options).map_err(|error| shown(chain(&error)))?;
    let title: String = name.chars().take(80).collect();
    Session::new(title, opened).map_err(|error| shown(error.to_string()))
}

/// An error with its causes.
pub fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text = format!("{text}: {error}");
        cause = error.source();
    }
    text
}
