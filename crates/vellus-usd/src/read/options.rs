//! What can be set about reading, and what reading returns.

use crate::warning::Warning;
use vellus::Fiber;
use vellus_io::Sources;
use vellus_scene::Scene;

/// What a file does not say.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Width (diameter) of curves that have none, in world units, in [0, 2·10⁹]. Without it such curves are an error.
    pub default_width: Option<f32>,
    /// The time code that is read, interpolated between samples. Without it: the stage's startTimeCode, or where it has none the first
    /// sample of each attribute. Values without time are for attributes without samples.
    pub frame: Option<f64>,
    /// Name or path of the camera; without it the first one is taken.
    pub camera: Option<String>,
    /// When the shutter opens and closes, in time codes after [`Options::frame`]; it replaces that of the camera.
    pub shutter: Option<[f64; 2]>,
    /// Fibre of curves whose material has no VellusFur shader.
    pub fallback: Fiber,
}

impl Default for Options {
    /// Needs widths, takes the first camera and makes fur without a material white.
    fn default() -> Self {
        Options { default_width: None, frame: None, camera: None, shutter: None, fallback: Fiber::hair() }
    }
}

/// What [`read`] gives.
#[derive(Clone, Debug)]
pub struct Reading {
    /// What was read, in world space.
    pub scene: Scene,
    /// What is not supported, and what was done instead.
    pub warnings: Vec<Warning>,
    /// All files that were read: layers and textures. A package (.usdz) is one file.
    pub sources: Sources,
}
