//! Names of the prims and files of a written stage, and units of its values.

use crate::write::encoder::Encoder;
use crate::write::geometry::kind;
use crate::write::value::Words;
use std::collections::{HashMap, HashSet};
use std::io;
use vellus_scene::{Parameter, Scene, Wrap};

/// Paths of materials and textures that prims refer to, in the order of the scene.
#[derive(Clone, Default)]
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
    /// Paths of prims that are already used.
    taken: HashSet<String>,
}

impl Names {
    /// Textures with these paths and wrap modes.
    pub fn new(textures: Vec<String>, wraps: Vec<[Wrap; 2]>) -> Self {
        Names { textures, wraps, ..Names::default() }
    }

    /// A valid and unused name for a prim in `parent`, similar to `wish`.
    pub fn unused(&mut self, parent: &str, wish: &str) -> String {
        // The last part of a path.
        let wish = wish.rsplit('/').next().unwrap_or_default();
        let mut name: String = wish.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        if name.is_empty() || name.starts_with(|c: char| c.is_ascii_digit()) {
            name.insert(0, '_');
        }
        let numbered = (1..).map(|n| if n == 1 { name.clone() } else { format!("{name}_{n}") });
        let free = numbered.skip_while(|n| self.taken.contains(&format!("{parent}/{n}"))).take(1).collect::<String>();
        self.taken.insert(format!("{parent}/{free}"));
        free
    }
}

/// The paths of all objects by their names, before the prims of lights and objects get theirs from `names`. They get
/// them in this order.
pub(crate) fn object_paths(scene: &Scene, mut names: Names) -> HashMap<String, Vec<String>> {
    let mut paths: HashMap<String, Vec<String>> = HashMap::new();
    let mut add = |name: &str, path: String| paths.entry(name.to_owned()).or_default().push(path);
    scene.lights.iter().for_each(|light| drop(names.unused("/Scene", kind(&light.shape))));
    let own = scene.meshes.iter().map(|mesh| &mesh.name).chain(scene.strands.iter().map(|strands| &strands.name));
    own.for_each(|name| add(name, format!("/Scene/{}", names.unused("/Scene", name))));
    let classes: Vec<String> = scene.prototypes.iter().map(|item| names.unused("", &item.name)).collect();
    let inside: Vec<Vec<(&String, String)>> = scene
        .prototypes
        .iter()
        .zip(&classes)
        .map(|(item, class)| {
            let meshes = item.meshes.iter().map(|mesh| &mesh.name);
            let all = meshes.chain(item.strands.iter().map(|strands| &strands.name));
            all.map(|name| (name, names.unused(&format!("/{class}"), name))).collect()
        })
        .collect();
    for item in &scene.instances {
        let instance = names.unused("/Scene", &scene.prototypes[item.prototype].name);
        inside[item.prototype].iter().for_each(|(name, child)| add(name, format!("/Scene/{instance}/{child}")));
    }
    paths
}

/// Writes the name for messages, which need not be a valid name of a prim.
pub(crate) fn vellus_name(out: &mut dyn Encoder, name: &str) -> io::Result<()> {
    out.set("custom string vellus:name", &Words(&plain(name)))
}

/// Replaces characters that need an escape in text, because readers handle escapes differently.
pub(crate) fn plain(text: &str) -> String {
    let replaced = |c: char| match c {
        '"' => '\'',
        '\\' => '/',
        c if c.is_control() => ' ',
        c => c,
    };
    text.chars().map(replaced).collect()
}

/// A string in quotes, [`plain`].
pub(crate) fn quoted(text: &str) -> String {
    format!("\"{}\"", plain(text))
}

/// Converts a parameter to the units of the file: angles are in degrees.
pub(crate) fn to_file(parameter: Parameter, value: [f32; 3]) -> [f32; 3] {
    if parameter.is_angle() { value.map(|x| f64::from(x).to_degrees() as f32) } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_valid_and_differ() {
        let mut names = Names::default();
        let found = ["/a/b c", "b_c", "", "7", "b_c"].map(|wish| names.unused("/Scene", wish));
        assert_eq!(found, ["b_c", "b_c_2", "_", "_7", "b_c_3"]);
        assert_eq!(names.unused("/Scene/Looks", "b c"), "b_c");
        assert_eq!(plain("a \"b\" \\ c\n"), "a 'b' / c ");
    }
}
