//! What all pages show: the values of all controls.

use crate::camera::Report;
use crate::request::{Coat, Groom};
use serde::Serialize;

/// The values of all controls.
#[derive(Clone, Debug, Serialize)]
pub struct State {
    /// Always `state`.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// Number of the last command.
    pub revision: u64,
    /// Name of the scene.
    pub scene: String,
    /// What the file has that was left out or replaced: the warnings of the command.
    pub warnings: Vec<String>,
    /// Strands and segments, in words.
    pub summary: String,
    /// Looks of strands.
    pub looks: Vec<LookState>,
    /// Lights.
    pub lights: Vec<LightState>,
    /// Which version is shown: 0 for A, 1 for B.
    pub version: usize,
    /// The version that is not shown.
    pub other: OtherState,
    /// Whether there is something to undo.
    pub can_undo: bool,
    /// Whether there is something to redo.
    pub can_redo: bool,
    /// Name of the reflectance model.
    pub model: &'static str,
    /// Names of all models.
    pub models: Vec<&'static str>,
    /// Rotation of all lights about the up axis, degrees.
    pub azimuth: f32,
    /// The groom.
    pub groom: Groom,
    /// What happens in the background, if anything.
    pub busy: Option<String>,
    /// Stops.
    pub exposure: f32,
    /// The images of the scene, which a saved scene does not have.
    pub images: usize,
    /// Width and height of the whole picture.
    pub size: [usize; 2],
    /// Left, top, right, bottom; `None` is the whole picture.
    pub crop: Option<[f32; 4]>,
    /// Whether the picture refines.
    pub paused: bool,
    /// Samples a pixel.
    pub target: u64,
    /// Whether the picture is denoised.
    pub denoise: bool,
    /// Why the picture cannot be denoised, if so.
    pub no_denoiser: Option<String>,
    /// The camera.
    pub camera: Report,
    /// Files of the folder.
    pub files: Vec<String>,
    /// The last message for all pages, if any.
    pub note: Option<String>,
}

/// What pages show of the other version.
#[derive(Clone, Debug, Serialize)]
pub struct OtherState {
    /// The fibre of each look: parameters by name.
    pub fibers: Vec<serde_json::Value>,
    /// Name of its reflectance model.
    pub model: &'static str,
}

/// A look of strands.
#[derive(Clone, Debug, Serialize)]
pub struct LookState {
    /// Its name.
    pub name: String,
    /// Parameters by name.
    pub fiber: serde_json::Value,
    /// Whether the colours of its strands vary in the scene.
    pub patterned: bool,
    /// How the colour varies.
    #[serde(flatten)]
    pub coat: Coat,
}

/// A light.
#[derive(Clone, Debug, Serialize)]
pub struct LightState {
    /// Its group, or its kind.
    pub name: String,
    /// Kind: dome, distant, rect, …
    pub kind: &'static str,
    /// Factor of its emission.
    pub gain: f32,
    /// Translation in scene units.
    pub shift: [f32; 3],
    /// Whether it can move.
    pub movable: bool,
}
