//! Names of the prims and files of a written stage, and units of its values.

use crate::write::geometry::kind;
use crate::write::text::{Text, quoted};
use std::collections::HashMap;
use std::io::{self, Write};
use vellus_scene::{Fit, Parameter, Scene, Wrap};

/// Paths of materials and textures that prims refer to, in the order of the scene.
#[derive(Default)]
pub(crate) struct Names {
    /// Materials of strands.
    pub looks: Vec<String>,
    /// Materials of meshes.
    pub surfaces: Vec<String>,
    /// Texture files, relative to the stage.
    pub textures: Vec<String>,
    /// The paths of all objects with a name, if lights have links.
    pub objects: HashMap<String, Vec<String>>,
    /// Wrap modes of the textures.
    pub wraps: Vec<[Wrap; 2]>,
}

/// The paths of all objects by their names. The prims get their names in this order.
pub(crate) fn object_paths(scene: &Scene) -> HashMap<String, Vec<String>> {
    let mut text = Text::new(io::sink());
    let mut paths: HashMap<String, Vec<String>> = HashMap::new();
    let mut add = |name: &str, path: String| paths.entry(name.to_owned()).or_default().push(path);
    let root = format!("/{}", text.name("", "Scene"));
    if let Some(camera) = &scene.camera {
        text.name(&root, "Camera");
        if camera.fit != Fit::Expand {
            text.name(&root, "RenderSettings");
        }
    }
    scene.lights.iter().for_each(|light| drop(text.name(&root, kind(light))));
    let own = scene.meshes.iter().map(|mesh| &mesh.name).chain(scene.strands.iter().map(|strands| &strands.name));
    own.for_each(|name| add(name, format!("{root}/{}", text.name(&root, name))));
    let classes: Vec<String> = scene.prototypes.iter().map(|item| text.name("", &item.name)).collect();
    let inside: Vec<Vec<(&String, String)>> = scene
        .prototypes
        .iter()
        .zip(&classes)
        .map(|(item, class)| {
            let meshes = item.meshes.iter().map(|mesh| &mesh.name);
            let names = meshes.chain(item.strands.iter().map(|strands| &strands.name));
            names.map(|name| (name, text.name(&format!("/{class}"), name))).collect()
        })
        .collect();
    for item in &scene.instances {
        let instance = text.name(&root, &scene.prototypes[item.prototype].name);
        inside[item.prototype].iter().for_each(|(name, child)| add(name, format!("{root}/{instance}/{child}")));
    }
    paths
}

/// Writes the name for messages, which need not be a valid name of a prim.
pub(crate) fn vellus_name<W: Write>(text: &mut Text<W>, name: &str) -> io::Result<()> {
    text.set("custom string vellus:name", &quoted(name))
}

/// Converts a parameter to the units of the file: angles are in degrees.
pub(crate) fn to_file(parameter: Parameter, value: [f32; 3]) -> [f32; 3] {
    if parameter.is_angle() { value.map(|x| f64::from(x).to_degrees() as f32) } else { value }
}
