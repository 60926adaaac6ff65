//! The state of reading a stage: the scene so far, and caches of what prims share.

use crate::error::Error;
use crate::image::{self, Budget, Encoding, Image};
use crate::read::link::Linked;
use crate::read::options::Options;
use crate::read::skeleton::Skeletons;
use crate::stage::Stage;
use crate::warning::Warnings;
use std::collections::{HashMap, HashSet};
use std::path::PathBuf;
use vellus_scene::{Camera, Parameter, Scene, Texture, Units, Wrap};

/// The look of a material, and the parameters that its shader reads from primvars.
#[derive(Clone, Debug)]
pub(crate) struct BoundLook {
    /// Index in the scene.
    pub look: usize,
    /// Names of the primvars, without `primvars:`.
    pub primvars: Vec<(Parameter, String)>,
}

/// A file of a texture, and how it is read.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct TextureSource {
    /// The path that [`Stage::asset`] resolved.
    pub file: String,
    pub encoding: Encoding,
    /// The channel that all three channels of the texture become.
    pub channel: Option<usize>,
    /// The wrap modes along u and v.
    pub wrap: [Wrap; 2],
}

/// The state of reading a stage.
pub(crate) struct Reader<'a> {
    pub stage: Stage,
    pub options: &'a Options,
    pub scene: Scene,
    pub warnings: Warnings,
    /// Looks by the path of the material. Curves without a material have the empty path.
    pub looks: HashMap<String, BoundLook>,
    /// The lights that may have links, which are read last.
    pub linked: Vec<Linked>,
    /// The names of looks that are shading networks of other programs.
    pub networks: Vec<String>,
    /// Surfaces by the path of the material, or of the mesh if it has no material.
    pub surfaces: HashMap<String, usize>,
    /// Looks and primvars with a warning that a value is out of range.
    pub held: HashSet<(usize, String)>,
    /// The length of a world unit where strands are read, if that is not world space.
    pub local_scale: f64,
    /// Skeletons, and what is below their roots.
    pub skeletons: Skeletons,
    /// The camera of the picture, if it is known, where meshes are read in world space.
    pub eye: Option<Camera>,
    /// The number of meshes of the stage.
    pub meshes: usize,
    /// The number of faces of subdivision surfaces.
    pub refined: usize,
    /// The number of points of copied instances.
    pub copied: usize,
    /// Whether what is ignored or replaced is an error, because the user named this part of the file.
    pub strict: bool,
    textures: HashMap<TextureSource, usize>,
    /// The memory of all images.
    pub images: Budget,
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
            linked: Vec::new(),
            networks: Vec::new(),
            surfaces: HashMap::new(),
            held: HashSet::new(),
            local_scale: 1.0,
            skeletons: Skeletons::default(),
            eye: None,
            meshes: 0,
            refined: 0,
            copied: 0,
            strict: false,
            textures: HashMap::new(),
            images: Budget::default(),
        }
    }

    /// Loads the texture that a prim refers to, and returns its index in the scene.
    pub fn texture(&mut self, prim: &str, source: TextureSource) -> Result<usize, Error> {
        if let Some(&index) = self.textures.get(&source) {
            return Ok(index);
        }
        let texture = self.load_texture(prim, &source)?;
        self.scene.textures.push(texture);
        self.textures.insert(source, self.scene.textures.len() - 1);
        Ok(self.scene.textures.len() - 1)
    }

    /// Loads the texture that a prim refers to, without adding it to the scene.
    pub fn load_texture(&mut self, prim: &str, source: &TextureSource) -> Result<Texture, Error> {
        let TextureSource { file, encoding, channel, wrap } = source;
        let bytes = self.stage.asset_bytes(file)?;
        // The part in brackets is the file inside the package.
        let name = PathBuf::from(file.trim_end_matches(']').replace('[', "/"));
        let Image { texture, warning } = image::decode(&name, &bytes, *encoding)?;
        self.images.image(&texture, bytes.len()).map_err(|what| Error::file(&name, what))?;
        if let Some(what) = warning {
            self.warnings.add(prim, what);
        }
        let mut texture = Texture { wrap: *wrap, ..texture };
        if let Some(channel) = *channel {
            texture.pixels.iter_mut().for_each(|pixel| *pixel = [pixel[channel]; 3]);
        }
        Ok(texture)
    }

    /// The name of a prim in later messages: `vellus:name` if it has one, otherwise its path.
    pub fn name(&self, prim: &str) -> Result<String, Error> {
        let given = self.stage.words(prim, "vellus:name")?.and_then(|words| words.into_iter().next());
        Ok(given.unwrap_or_else(|| prim.to_owned()))
    }
}
