//! The options of staging.

use crate::{Error, Format, color};
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use vellus_io::DigestBuilder;
use vellus_scene::View;

/// The version of the studio. It changes with every change of its pictures.
const VERSION: u8 = 1;

/// Extensions of images.
const IMAGES: [&str; 3] = ["png", "hdr", "exr"];

/// How a scene is staged: from where the camera looks, which lights it has, and what is behind it.
///
/// A scene keeps what it has, unless an option replaces it. A scene without lights gets a studio: a key light, a fill
/// light and a rim light over a grey cyclorama, a ground that bends up to a wall without a visible edge. A scene
/// without a camera gets [`View::default`]: three quarters from the front ([`vellus_scene::Scene::front`]).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[cfg_attr(feature = "clap", command(next_help_heading = "Camera, lights and background"))]
pub struct Staging {
    /// Width over height of the picture. `None` is that of [`Opened::size`](crate::Opened::size).
    #[cfg_attr(feature = "clap", arg(skip))]
    pub aspect: Option<f32>,
    /// Look from here, and frame the subject: degrees to the subject's left from its front, degrees upward, and a
    /// magnification. It replaces the camera of the scene [default for files without a camera: 35,15].
    #[cfg_attr(feature = "clap", arg(long, allow_hyphen_values = true, value_name = "YAW,PITCH[,ZOOM]"))]
    pub view: Option<View>,
    /// Lights instead of those of the scene: studio (key, fill and rim light), sun, sky (overcast), or a lat-long
    /// image (.png, .hdr, .exr) [default for files without lights: studio].
    #[cfg_attr(feature = "clap", arg(long, value_name = "studio|sun|sky|IMAGE"))]
    pub light: Option<Lighting>,
    /// What is behind the scene: a colour (black, #rrggbb), transparent, or an image that fills the picture. It
    /// replaces the ground and the backdrop of --light and of built-in scenes.
    #[cfg_attr(feature = "clap", arg(long, value_name = "COLOR|transparent|IMAGE"))]
    pub background: Option<Backdrop>,
    /// Meshes to add to the scene: the body under a groom (.obj, .usda, .usdc, .usdz).
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub body: Option<PathBuf>,
}

impl Staging {
    /// The default staging of a picture with this ratio of width to height.
    pub fn new(aspect: impl Into<Option<f32>>) -> Self {
        let aspect = aspect.into();
        Staging { aspect, view: None, light: None, background: None, body: None }
    }

    /// Checks the files without reading them.
    ///
    /// # Errors
    /// [`Error::Body`] if the body has another format. [`Error::Read`] if a file does not exist.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let image = match &self.light {
            Some(Lighting::Image(path)) => Some(path),
            _ => None,
        };
        let behind = match &self.background {
            Some(Backdrop::Image(path)) => Some(path),
            _ => None,
        };
        let has_meshes = |body: &PathBuf| matches!(Format::of(body), Ok(Format::Obj | Format::Usd | Format::Alembic));
        if let Some(body) = self.body.as_ref().filter(|body| !has_meshes(body)) {
            return Err(Error::Body(body.clone()));
        }
        [image, behind, self.body.as_ref()].into_iter().flatten().try_for_each(|path| {
            std::fs::metadata(path).map(|_| ()).map_err(|source| Error::Read { path: path.clone(), source })
        })
    }

    /// Adds everything that changes the scene to a digest, except for the files. A built-in scene without options is
    /// not staged.
    pub(crate) fn identify(&self, builder: DigestBuilder, built_in: bool) -> DigestBuilder {
        let Staging { view, light, background, body, .. } = self;
        if built_in && *self == Staging::new(self.aspect) {
            return builder;
        }
        let numbers = |numbers: &[f32]| numbers.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        let view = view.map_or_else(Vec::new, |View { yaw, pitch, zoom }| numbers(&[yaw, pitch, zoom]));
        let light = light.as_ref().map_or("", Lighting::name);
        let background = match background {
            None => Vec::new(),
            Some(Backdrop::Color(color)) => numbers(color),
            Some(Backdrop::Transparent) => b"transparent".to_vec(),
            Some(Backdrop::Image(_)) => b"image".to_vec(),
        };
        builder
            .field("staging", [VERSION])
            .field("view", view)
            .field("light", light)
            .field("background", background)
            .field("body", [u8::from(body.is_some())])
    }
}

/// Lights of a studio.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Lighting {
    /// Key light, fill light and rim light.
    Studio,
    /// The sun and a weak blue sky.
    Sun,
    /// An overcast sky.
    Sky,
    /// A lat-long image, infinitely far away.
    Image(PathBuf),
}

impl Lighting {
    /// Its name: `studio`, `sun`, `sky` or `image`.
    fn name(&self) -> &'static str {
        match self {
            Lighting::Studio => "studio",
            Lighting::Sun => "sun",
            Lighting::Sky => "sky",
            Lighting::Image(_) => "image",
        }
    }
}

impl fmt::Display for Lighting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Lighting::Image(path) => path.display().fmt(f),
            other => f.write_str(other.name()),
        }
    }
}

impl FromStr for Lighting {
    type Err = String;

    /// Reads `studio`, `sun`, `sky`, or the path of a .png, .hdr or .exr file.
    fn from_str(text: &str) -> Result<Self, String> {
        let named = [Lighting::Studio, Lighting::Sun, Lighting::Sky].into_iter().find(|light| light.name() == text);
        named.or_else(|| image(text).map(Lighting::Image)).ok_or_else(|| {
            "it must be studio, sun, sky, or an image in the lat-long format (.png, .hdr, .exr)".to_owned()
        })
    }
}

/// What is behind a scene.
#[derive(Clone, Debug, PartialEq)]
pub enum Backdrop {
    /// Linear RGB, in [0, 1].
    Color([f32; 3]),
    /// Nothing: PNG files have an alpha channel.
    Transparent,
    /// An image that fills the picture.
    Image(PathBuf),
}

impl FromStr for Backdrop {
    type Err = String;

    /// Reads `transparent`, `black`, `white`, `grey` (18 % reflectance), another [`color`], or the path of
    /// a .png, .hdr or .exr file.
    fn from_str(text: &str) -> Result<Self, String> {
        let color = match text {
            "transparent" => return Ok(Backdrop::Transparent),
            "black" => Some([0.0; 3]),
            "white" => Some([1.0; 3]),
            "grey" | "gray" => Some([0.18; 3]),
            other => color(other).ok(),
        };
        color.map(Backdrop::Color).or_else(|| image(text).map(Backdrop::Image)).ok_or_else(|| {
            "it must be transparent, a colour (a name, #rrggbb or R,G,B), or an image (.png, .hdr, .exr)".to_owned()
        })
    }
}

/// The path of an image, if the text has the extension of one.
fn image(text: &str) -> Option<PathBuf> {
    let extension = Path::new(text).extension()?.to_str()?.to_ascii_lowercase();
    IMAGES.contains(&extension.as_str()).then(|| text.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_and_backgrounds_are_read() {
        assert_eq!("sun".parse(), Ok(Lighting::Sun));
        assert_eq!("a/sky.HDR".parse(), Ok(Lighting::Image("a/sky.HDR".into())));
        assert_eq!("transparent".parse(), Ok(Backdrop::Transparent));
        assert_eq!("a.png".parse(), Ok(Backdrop::Image("a.png".into())));
        let Ok(Backdrop::Color(color)) = "#ff8000".parse() else { panic!() };
        assert!(color[0] == 1.0 && (color[1] - 0.2159).abs() < 1e-4 && color[2] == 0.0);
        for bad in ["", "moon", "a.jpg", "#12345", "#gggggg", "#ééé", "1,2"] {
            assert!(bad.parse::<Lighting>().is_err() && bad.parse::<Backdrop>().is_err(), "{bad}");
        }
    }
}
