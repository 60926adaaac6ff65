//! The state of reading a stage: what was read so far, and caches of what prims share.

use crate::error::Error;
use crate::image::{self, Encoding, Image};
use crate::read::look::BoundLook;
use crate::read::options::Options;
use crate::stage::Stage;
use crate::warning::Warnings;
use std::collections::{HashMap, HashSet};
use std::path::PathBuf;
use vellus_scene::{Scene, Texture, Units, Wrap};

/// A scene in the making.
pub(crate) struct Reader<'a> {
    pub stage: Stage,
    pub options: &'a Options,
    pub scene: Scene,
    pub warnings: Warnings,
    /// By material; that of curves without one under the empty path.
    pub looks: HashMap<String, BoundLook>,
    /// By material, or by mesh where it has none.
    pub surfaces: HashMap<String, usize>,
    /// Looks and primvars of which it was said that they leave their range.
    pub held: HashSet<(usize, String)>,
    textures: HashMap<(String, Encoding, Option<usize>, [Wrap; 2]), usize>,
}

impl<'a> Reader<'a> {
    /// Nothing is read yet.
    pub fn new(stage: Stage, options: &'a Options, units: Units) -> Self {
        Reader {
            stage,
            options,
            scene: Scene { units: Some(units), ..Scene::default() },
            warnings: Warnings::default(),
            looks: HashMap::new(),
            surfaces: HashMap::new(),
            held: HashSet::new(),
            textures: HashMap::new(),
        }
    }

    /// Index of the texture in a file that a prim refers to; `channel` makes it grey.
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
        // The part in brackets is the file in the package.
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

    /// What a prim is called in messages later on: its path, unless we have written it with a name of its own.
    pub fn name(&self, prim: &str) -> Result<String, Error> {
        let given = self.stage.words(prim, "vellus:name")?.and_then(|words| words.into_iter().next());
        Ok(given.unwrap_or_else(|| prim.to_owned()))
    }
}
