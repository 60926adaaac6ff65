//! What can be set about reading, and what reading returns.

use crate::read::settings::RenderSettings;
use crate::warning::Warning;
use vellus::Fiber;
use vellus_io::Sources;
use vellus_scene::{Camera, Scene};

/// Settings that a file does not contain.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Width (diameter) of curves that have none, in world units, in [0, 2·10⁹]. If it is `None`, such curves are
    /// left out with a warning.
    pub default_width: Option<f32>,
    /// The time code to read. Values are interpolated between samples. If it is `None`, the startTimeCode of the stage
    /// is read, or the first sample of each attribute if the stage has none. Attributes without samples have their
    /// default value.
    pub frame: Option<f64>,
    /// Name or path of the camera. If it is `None`, that of the RenderSettings is used, otherwise the first camera.
    pub camera: Option<String>,
    /// When the shutter opens and closes, in time codes relative to [`Options::frame`]. Overrides the shutter of the
    /// camera.
    pub shutter: Option<[f64; 2]>,
    /// How many frames before [`Options::frame`] the camera is read of: see [`Reading::earlier`].
    pub earlier: usize,
    /// The fibre of curves whose material has no VellusFur shader.
    pub fallback: Fiber,
    /// The fibre whose parameters complete a shading network of another program: the medulla and the cuticle's layers.
    pub network_base: Fiber,
    /// Whether instances share their prototypes ([`Scene::instances`]). Otherwise they are copied.
    pub instances: bool,
    /// Whether primvars of curves that rendering does not use are kept ([`Scene::custom`]).
    pub custom: bool,
}

impl Default for Options {
    /// Requires widths and uses the camera of the RenderSettings, or the first one. Curves without a VellusFur shader
    /// get [`Fiber::hair`], which also completes shading networks. Copies instances.
    fn default() -> Self {
        Options {
            default_width: None,
            frame: None,
            camera: None,
            shutter: None,
            earlier: 0,
            fallback: Fiber::hair(),
            network_base: Fiber::hair(),
            instances: false,
            custom: false,
        }
    }
}

/// When a picture of a stage is taken, and with which lens.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shot {
    /// The time code. `None` if neither the stage nor [`Options::frame`] says it.
    pub frame: Option<f64>,
    /// Time codes a second (timeCodesPerSecond).
    pub frames_per_second: f64,
    /// The focal length in scene units. `None` without a camera.
    pub focal_length: Option<f64>,
    /// The first and the last frame of the animation, as the file says them. `None` if it has none.
    pub range: Option<[f64; 2]>,
}

/// The result of [`read`](crate::read()).
#[derive(Clone, Debug)]
pub struct Reading {
    /// The scene, in world space.
    pub scene: Scene,
    /// What the file has that is not supported or could not be read.
    pub warnings: Vec<Warning>,
    /// The names of looks that are shading networks of other programs. [`Options::network_base`] completed them.
    pub networks: Vec<String>,
    /// What the stage says about its picture, if it has RenderSettings.
    pub settings: Option<RenderSettings>,
    /// The time and the lens of the picture.
    pub shot: Shot,
    /// The cameras of the [`Options::earlier`] frames before, the nearest first, up to the first frame in which
    /// something has another place. Empty if anything but a transform or the camera may change with time.
    pub earlier: Vec<Camera>,
    /// All files that were read: layers and textures. A package (.usdz) counts as one file.
    pub sources: Sources,
}
