//! The state of reading a stage: the scene so far, and caches of what prims share.

use crate::error::Error;
use crate::image::{self, Encoding, Image};
use crate::read::options::Options;
use crate::stage::Stage;
use crate::warning::Warnings;
use std::collections::{HashMap, HashSet};
use std::path::PathBuf;
use vellus_scene::{Parameter, Scene, Texture, Units, Wrap};

/// The look of a material, and the parameters that its shader reads from primvars.
#[derive(Clone, Debug)]
pub(crate) struct BoundLook {
    /// Index in the scene.
    pub look: usize,
    /// Names of the primvars, without `primvars:`.
    pub primvars: Vec<(Parameter, String)>,
}

/// The state of reading a stage.
pub(crate) struct Reader<'a> {
    pub stage: Stage,
    pub options: &'a Options,
    pub scene: Scene,
    pub warnings: Warnings,
    /// Looks by the path of the material. Curves without a material have the empty path.
    pub looks: HashMap<String, BoundLook>,
    /// The names of looks that are shading networks of other programs.
    pub networks: Vec<String>,
    /// Surfaces by the path of the material, or of the mesh if it has no material.
    pub surfaces: HashMap<String, usize>,
    /// Looks and primvars with a warning that a value is out of range.
    pub held: HashSet<(usize, String)>,
    textures: HashMap<(String, Encoding, Option<usize>, [Wrap; 2]), usize>,
}

impl<'a> Reader<'a> {
    /// A reader with an empty scene.
    pub fn new(stage: Stage, options: &'a Options, units: Units) -> Self {
        Reader {
            stage,
            options,
            scene: Scene { units: Some(units), ..Scene::default() },
            warnings: Warnings::default(),
            looks: HashMap::new(),
            networks: Vec::new(),
            surfaces: HashMap::new(),
            held: HashSet::new(),
            textures: HashMap::new(),
        }
    }

    /// Loads the texture file that a prim refers to, and returns its index in the scene. With a `channel`, all three
    /// channels of the texture become that channel.
    pub fn texture(
        &mut self,
        prim: &str,
        file: String,
        encoding: Encoding,
        channel: Option<usize>,
        wrap: [Wrap; 2],
    ) -> Result<usize, Error> {
        let key = (file, encoding, channel, wrap);
        if let Some(&index) = self.textures.get(&key) {
            return Ok(index);
        }
        let bytes = self.stage.asset_bytes(&key.0)?;
        // The part in brackets is the file inside the package.
        let name = PathBuf::from(key.0.trim_end_matches(']').replace('[', "/"));
        let Image { texture, warning } = image::decode(&name, &bytes, encoding)?;
        if let Some(what) = warning {
            self.warnings.add(prim, what);
        }
        let mut texture = Texture { wrap, ..texture };
        if let Some(channel) = channel {
            texture.pixels.iter_mut().for_each(|pixel| *pixel = [pixel[channel]; 3]);
        }
        self.scene.textures.push(texture);
        self.textures.insert(key, self.scene.textures.len() - 1);
        Ok(self.scene.textures.len() - 1)
    }

    /// The name of a prim in later messages: `vellus:name` if it has one, otherwise its path.
    pub fn name(&self, prim: &str) -> Result<String, Error> {
        let given = self.stage.words(prim, "vellus:name")?.and_then(|words| words.into_iter().next());
        Ok(given.unwrap_or_else(|| prim.to_owned()))
    }
}
