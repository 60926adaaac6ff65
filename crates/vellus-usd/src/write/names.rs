//! What the prims and files of a written stage are called, and how values are stored in it.

use crate::write::text::{Text, quoted};
use std::io::{self, Write};
use vellus_scene::{Parameter, Wrap};

/// Paths in the stage and names of files of what others refer to, in the order of the scene.
#[derive(Default)]
pub(crate) struct Names {
    /// Materials of strands.
    pub looks: Vec<String>,
    /// Materials of meshes.
    pub surfaces: Vec<String>,
    /// Files beside the stage.
    pub textures: Vec<String>,
    /// What lies beyond their edges.
    pub wraps: Vec<[Wrap; 2]>,
}

/// The name for messages, which need not be that of a prim.
pub(crate) fn vellus_name<W: Write>(text: &mut Text<W>, name: &str) -> io::Result<()> {
    text.set("custom string vellus:name", &quoted(name))
}

/// Angles in degrees.
pub(crate) fn to_file(parameter: Parameter, value: [f32; 3]) -> [f32; 3] {
    if parameter.is_angle() { value.map(|x| f64::from(x).to_degrees() as f32) } else { value }
}
