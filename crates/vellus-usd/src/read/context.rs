//! The state of reading a stage: the scene so far, and caches of what prims share.

use crate::error::Error;
use crate::image::{self, Budget, Encoding, Image};
use crate::read::link::Linked;
use crate::read::options::Options;
use crate::read::prim::Prim;
use crate::read::skeleton::Skeletons;
use crate::stage::Stage;
use crate::warning::{Fault, Warnings};
use std::collections::{HashMap, HashSet, VecDeque};
use std::path::PathBuf;
use vellus_scene::{Camera, Parameter, Scene, Texture, Units, Wrap};

/// The look of a material, and the parameters that its shader reads from primvars.
#[derive(Clone, Debug)]
pub(crate) struct BoundLook {
    /// Index in the scene.
    pub look: usize,
    /// Names of the primvars, without `primvars:`.
    pub primvars: Vec<(Parameter, String)>,
    /// The name of the texture coordinates of its textures, without `primvars:`, if a shader says it.
    pub uv: Option<String>,
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
    /// The name of the texture coordinates, without `primvars:`. `None` if the shader names none.
    pub uv: Option<String>,
}

/// The memory for images that other shaders may read again, in bytes: 128 MiB.
const DECODED: usize = 1 << 27;

/// The state of reading a stage.
pub(crate) struct Reader<'a> {
    pub stage: &'a Stage,
    pub options: &'a Options,
    pub scene: Scene,
    pub warnings: Warnings,
    /// Looks by the path of the material. Curves without a material have the empty path.
    pub looks: HashMap<String, BoundLook>,
    /// The lights that may have links, which are read last.
    pub linked: Vec<Linked>,
    /// The names of looks that are shading networks of other programs.
    pub networks: Vec<String>,
    /// The focal length of the camera in scene units.
    pub focal_length: Option<f64>,
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
    /// The cameras of the frames before: see [`Reading::earlier`](crate::Reading::earlier).
    pub earlier: Vec<Camera>,
    /// The diagonal of the meshes of a stage without a camera, or 0.
    pub stage_size: f64,
    /// The number of meshes of the stage.
    pub meshes: usize,
    /// The number of faces of subdivision surfaces.
    pub refined: usize,
    /// The number of instancers around what is read.
    pub nested: usize,
    /// The number of points of copied instances.
    pub copied: usize,
    /// Whether what is ignored or replaced is an error, because the user named this part of the file.
    pub is_named: bool,
    /// Prims that are not read to the end. A warning says why, so that their properties are not in the ledger.
    pub left_out: HashSet<String>,
    textures: HashMap<TextureSource, usize>,
    /// The images that were decoded last, with the sizes of their files.
    decoded: VecDeque<(String, Encoding, Texture, usize)>,
    /// The names of the texture coordinates that textures are looked up at, by the index of the texture.
    pub uv_sets: HashMap<usize, String>,
    /// The memory of all images.
    pub images: Budget,
}

impl<'a> Reader<'a> {
    /// A reader with an empty scene.
    pub fn new(stage: &'a Stage, options: &'a Options, units: Units) -> Self {
        Reader {
            stage,
            options,
            scene: Scene { units: Some(units), ..Scene::default() },
            warnings: Warnings::default(),
            looks: HashMap::new(),
            linked: Vec::new(),
            networks: Vec::new(),
            focal_length: None,
            surfaces: HashMap::new(),
            held: HashSet::new(),
            local_scale: 1.0,
            skeletons: Skeletons::default(),
            eye: None,
            earlier: Vec::new(),
            stage_size: 0.0,
            meshes: 0,
            refined: 0,
            nested: 0,
            copied: 0,
            is_named: false,
            uv_sets: HashMap::new(),
            left_out: HashSet::new(),
            textures: HashMap::new(),
            decoded: VecDeque::new(),
            images: Budget::default(),
        }
    }

    /// Loads the texture that a prim refers to, and returns its index in the scene.
    pub fn texture(&mut self, prim: &str, source: TextureSource) -> Result<usize, Error> {
        if let Some(&index) = self.textures.get(&source) {
            return Ok(index);
        }
        let texture = self.load_texture(prim, &source)?;
        let index = self.add_texture(texture, source.uv.clone());
        self.textures.insert(source, index);
        Ok(index)
    }

    /// Adds a texture that is looked up at these texture coordinates, and returns its index.
    pub fn add_texture(&mut self, texture: Texture, uv: Option<String>) -> usize {
        let index = self.scene.textures.len();
        self.scene.textures.push(texture);
        self.uv_sets.extend(uv.map(|uv| (index, uv)));
        index
    }

    /// A prim that is read from now on.
    pub fn prim<'s>(&self, path: &'s str) -> Result<Prim<'s>, Error>
    where
        'a: 's,
    {
        Prim::new(self.stage, path)
    }

    /// Notes that a part of the scene cannot be read, and what happens instead: a warning, or an error if the user
    /// named this part.
    pub fn fault(&mut self, fault: Fault, prim: &str, error: Error, instead: &str) -> Result<(), Error> {
        if self.is_named {
            return Err(error);
        }
        self.left_out.insert(prim.to_owned());
        let (prim, what) = match error {
            Error::Prim { prim, what } => (prim, what),
            Error::Scene(vellus_scene::Error::Invalid { what, .. }) => (prim.to_owned(), what),
            Error::Read { file, source } => (prim.to_owned(), format!("cannot read {}: {source}", file.display())),
            other => (prim.to_owned(), other.to_string()),
        };
        self.warnings.add_fault(Some(fault), &prim, format!("{what}: {instead}"));
        self.left_out.insert(prim);
        Ok(())
    }

    /// Notes that a property of a prim cannot be read. The prim is read without it.
    pub fn ignore(&mut self, prim: &str, error: Error) -> Result<(), Error> {
        match error {
            Error::Prim { what, .. } if !self.is_named => self.warnings.add(prim, format!("{what}: it is ignored")),
            other => return Err(other),
        }
        Ok(())
    }

    /// Reads a prim. If that fails, the prim is left out: nothing of it stays in the scene.
    pub fn attempt(&mut self, prim: &str, read: impl FnOnce(&mut Self) -> Result<(), Error>) -> Result<(), Error> {
        let Scene { strands, meshes, instances, lights, .. } = &self.scene;
        let [strands, meshes, instances] = [strands.len(), meshes.len(), instances.len()];
        let [lights, linked] = [lights.len(), self.linked.len()];
        let result = read(self).and_then(|()| {
            let new = &self.scene.lights[lights..];
            Ok(new.iter().try_for_each(|light| light.validate(self.scene.textures.len()))?)
        });
        let Err(error) = result else { return Ok(()) };
        self.scene.strands.truncate(strands);
        self.scene.meshes.truncate(meshes);
        self.scene.instances.truncate(instances);
        self.scene.lights.truncate(lights);
        self.linked.truncate(linked);
        self.fault(Fault::Prim, prim, error, "it is left out")
    }

    /// Loads the texture that a prim refers to, without adding it to the scene.
    pub fn load_texture(&mut self, prim: &str, source: &TextureSource) -> Result<Texture, Error> {
        let TextureSource { file, encoding, channel, wrap, uv: _ } = source;
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
            texture.pixels.spread(channel);
        }
        Ok(texture)
    }

    /// Loads a file, and returns its size in bytes too.
    fn load_image(&mut self, prim: &str, file: &str, encoding: Encoding) -> Result<(Texture, usize), Error> {
        let known = self.decoded.iter().find(|known| known.0 == file && known.1 == encoding);
        if let Some((_, _, texture, size)) = known {
            return Ok((texture.clone(), *size));
        }
        let bytes = self.stage.asset_bytes(file)?;
        let name = PathBuf::from(file.trim_end_matches(']').replace('[', "/"));
        let Image { texture, warning } = image::decode(&name, &bytes, encoding)?;
        if let Some(what) = warning {
            self.warnings.add(prim, what);
        }
        self.decoded.push_back((file.to_owned(), encoding, texture.clone(), bytes.len()));
        while self.decoded.iter().map(|known| known.2.pixels.size()).sum::<usize>() > DECODED {
            self.decoded.pop_front();
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
                Err(error) => self.fault(Fault::Texture, prim, error, "the tile is magenta")?,
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
