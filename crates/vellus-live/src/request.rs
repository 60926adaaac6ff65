//! Commands of a page.

use serde::{Deserialize, Serialize};

/// The largest width or height of a picture, in pixels.
pub(crate) const MAX_SIDE: usize = 4096;

/// The smallest one.
pub(crate) const MIN_SIDE: usize = 16;

/// A change of the picture, or a question about it. Positions are shares of the whole picture, from its upper left
/// corner, in [0, 1].
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "type", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Command {
    /// Turns the camera around its target: degrees to the right, and upward.
    Orbit {
        /// To the right, degrees.
        x: f32,
        /// Upward, degrees.
        y: f32,
    },
    /// Moves camera and target, in heights of the picture at the target.
    Pan {
        /// To the right.
        x: f32,
        /// Upward.
        y: f32,
    },
    /// Multiplies the distance to the target; in [0.01, 100].
    Zoom {
        /// Below 1 is nearer.
        factor: f32,
    },
    /// Focuses on a point of the picture, which becomes the target.
    Focus {
        /// Horizontal position.
        x: f32,
        /// Vertical position.
        y: f32,
    },
    /// Returns to the camera of the scene.
    Home,
    /// Sets the lens.
    Lens {
        /// Vertical angle of view, in degrees; in [1, 150].
        angle: f32,
        /// Radius of the lens, in scene units; at least 0.
        radius: f32,
    },
    /// Sets the exposure, in stops; in [-20, 20].
    Exposure {
        /// The exposure.
        stops: f32,
    },
    /// Sets width and height in pixels; from 16 to 4096.
    Size {
        /// Width.
        width: usize,
        /// Height.
        height: usize,
    },
    /// Renders only a part of the picture: left, top, right, bottom. `None` is the whole picture.
    Crop {
        /// The part.
        area: Option<[f32; 4]>,
    },
    /// Stops or continues to refine.
    Pause {
        /// Whether to stop.
        on: bool,
    },
    /// Sets the number of samples a pixel; in [1, 65536].
    Target {
        /// The number.
        samples: u64,
    },
    /// Cleans the picture with Open Image Denoise.
    Denoise {
        /// Whether to clean.
        on: bool,
    },
    /// Asks what is at a point of the picture.
    Pick {
        /// Horizontal position.
        x: f32,
        /// Vertical position.
        y: f32,
    },
    /// Sets the fibre of a look, in the format of fibre files.
    Look {
        /// Index of the look.
        look: usize,
        /// The fibre: parameters by name.
        fiber: serde_json::Value,
    },
    /// Sets how the colour of a look varies over the strands.
    Coat {
        /// Index of the look.
        look: usize,
        /// The settings.
        #[serde(flatten)]
        coat: Coat,
    },
    /// Selects the reflectance model of the fibres.
    Model {
        /// Its name.
        name: String,
    },
    /// Rotates all lights about the up axis through the middle of the scene, in degrees.
    Azimuth {
        /// The angle.
        degrees: f32,
    },
    /// Scales and moves a light.
    Light {
        /// Index of the light.
        light: usize,
        /// Factor of its emission; in [0, 1000].
        gain: f32,
        /// Translation, in scene units. Domes and distant lights do not move.
        shift: [f32; 3],
    },
    /// Sets the groom.
    Groom(Groom),
    /// Undoes the last change of fibres, model, lights or groom.
    Undo,
    /// Redoes what was undone.
    Redo,
    /// Shows version A or B of fibres, model, lights and groom.
    Version {
        /// 0 for A, 1 for B.
        index: usize,
    },
    /// Copies the version that is shown to the other one.
    CopyVersion,
    /// Opens a scene or a groom in the folder of the server.
    Open {
        /// The name of the file.
        file: String,
    },
}

impl Command {
    /// Whether the command changes nothing.
    pub(crate) fn is_question(&self) -> bool {
        matches!(self, Command::Pick { .. })
    }

    /// The control that a step of undo belongs to. `None` if the command changes neither fibres nor model, lights or
    /// groom.
    pub(crate) fn control(&self) -> Option<String> {
        match self {
            Command::Look { look, .. } => Some(format!("look {look}")),
            Command::Coat { look, .. } => Some(format!("coat {look}")),
            Command::Model { .. } => Some("model".to_owned()),
            Command::Azimuth { .. } => Some("azimuth".to_owned()),
            Command::Light { light, .. } => Some(format!("light {light}")),
            Command::Groom(_) => Some("groom".to_owned()),
            _ => None,
        }
    }
}

/// How the colour of a look varies over the strands.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coat {
    /// Whether the strands keep the colours of the scene. Otherwise all have the colour of the look.
    pub pattern: bool,
    /// The absorption at the tip relative to that at the root; in [0.01, 100]. Above 1, tips are darker, and channels
    /// that hardly absorb get darker too.
    pub tip: f32,
}

impl Default for Coat {
    fn default() -> Self {
        Coat { pattern: true, tip: 1.0 }
    }
}

/// Changes of the strands of the scene. The values of [`Groom::default`] change nothing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Groom {
    /// The number of strands relative to the scene; in [0.01, 4]. Above 1 they are interpolated.
    pub density: f32,
    /// Factor of the length; in [0.1, 5].
    pub length: f32,
    /// How far the tips of neighbours move toward each other; in [0, 1].
    pub clump: f32,
    /// Strands per clump; from 2 to 1000.
    pub clump_strands: usize,
}

impl Default for Groom {
    fn default() -> Self {
        Groom { density: 1.0, length: 1.0, clump: 0.0, clump_strands: 40 }
    }
}

/// Checks that a number is in a range.
pub(crate) fn within(name: &str, x: f32, low: f32, high: f32) -> Result<f32, String> {
    if (low..=high).contains(&x) { Ok(x) } else { Err(format!("{name} is {x}: it must be in [{low}, {high}]")) }
}
