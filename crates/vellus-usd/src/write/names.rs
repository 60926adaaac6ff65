//! Names of the prims and files of a written stage, and units of its values.

use crate::write::text::{Text, quoted};
use std::io::{self, Write};
use vellus_scene::{Parameter, Wrap};

/// Paths of materials and textures that prims refer to, in the order of the scene.
#[derive(Default)]
pub(crate) struct Names {
    /// Materials of strands.
    pub looks: Vec<String>,
    /// Materials of meshes.
    pub surfaces: Vec<String>,
    /// Texture files, relative to the stage.
    pub textures: Vec<String>,
    /// Wrap modes of the textures.
    pub wraps: Vec<[Wrap; 2]>,
}

/// Writes the name for messages, which need not be a valid name of a prim.
pub(crate) fn vellus_name<W: Write>(text: &mut Text<W>, name: &str) -> io::Result<()> {
    text.set("custom string vellus:name", &quoted(name))
}

/// Converts a parameter to the units of the file: angles are in degrees.
pub(crate) fn to_file(parameter: Parameter, value: [f32; 3]) -> [f32; 3] {
    if parameter.is_angle() { value.map(|x| f64::from(x).to_degrees() as f32) } else { value }
}
