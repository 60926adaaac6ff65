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
        // The part in brackets is the file inside the package.
        let name = PathBuf::from(file.trim_end_matches(']').replace('[', "/"));
        let (mut texture, size) = if file.contains(image::UDIM) {
            self.load_tiles(prim, file, *encoding)?
        } else {
            let (texture, size) = self.load_image(prim, file, *encoding)?;
            (Texture { wrap: *wrap, ..texture }, size)
        };
        self.images.image(&texture, size).map_err(|what| Error::file(&name, what))?;
        if let Some(channel) = *channel {
            texture.pixels.iter_mut().for_each(|pixel| *pixel = [pixel[channel]; 3]);
        }
        Ok(texture)
    }

    /// Loads a file, and returns its size in bytes too.
    fn load_image(&mut self, prim: &str, file: &str, encoding: Encoding) -> Result<(Texture, usize), Error> {
        let bytes = self.stage.asset_bytes(file)?;
        let name = PathBuf::from(file.trim_end_matches(']').replace('[', "/"));
        let Image { texture, warning } = image::decode(&name, &bytes, encoding)?;
        if let Some(what) = warning {
            self.warnings.add(prim, what);
        }
        Ok((texture, bytes.len()))
    }

    /// Loads tiles as one image. Those that cannot be read are missing in it.
    fn load_tiles(&mut self, prim: &str, file: &str, encoding: Encoding) -> Result<(Texture, usize), Error> {
        let numbers = self.stage.tiles(file);
        let (mut tiles, mut size, mut shrunk) = (Vec::new(), 0, false);
        for &number in &numbers {
            match self.load_image(prim, &image::tile_name(file, number), encoding) {
                Ok((mut tile, bytes)) => {
                    shrunk |= image::shrink(&mut tile, &numbers);
                    size += bytes;
                    tiles.push((number, tile));
                }
                Err(error) => self.complain(prim, format!("{error}: the tile is magenta"))?,
            }
        }
        let name = file.trim_end_matches(']').rsplit(['/', '[']).next().unwrap_or_default();
        if shrunk {
            let what =
                format!("the {} tiles {name} are too large for one image: they have a lower resolution", tiles.len());
            self.warnings.add(prim, what);
        }
        Ok((image::join(name.to_owned(), tiles), size))
    }

    /// The name of a prim in later messages: `vellus:name` if it has one, otherwise its path.
    pub fn name(&self, prim: &str) -> Result<String, Error> {
        let given = self.stage.words(prim, "vellus:name")?.and_then(|words| words.into_iter().next());
        Ok(given.unwrap_or_else(|| prim.to_owned()))
    }
}
