//! Reading a stage: prim after prim into a scene.

mod camera;
mod curves;
mod layout;
mod light;
pub(crate) mod look;
mod mesh;
mod motion;
mod network;
mod primvar;
mod surface;
pub(crate) mod uv_texture;
mod xform;

use crate::error::Error;
use crate::image::{self, Encoding, Image};
use crate::read::look::BoundLook;
use crate::read::network::bound_material;
use crate::read::xform::{Place, places};
use crate::stage::Stage;
use crate::warning::{Warning, Warnings};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use vellus::Fiber;
use vellus_io::Sources;
use vellus_scene::{Scene, Texture, Wrap};

/// What a file does not say.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Width (diameter) of curves that have none, in world units, in [0, 2·10⁹]. Without it such curves are an error.
    pub default_width: Option<f32>,
    /// The time code that is read, interpolated between samples. Without it: the stage's startTimeCode, or where it has none the first
    /// sample of each attribute. Values without time are for attributes without samples.
    pub frame: Option<f64>,
    /// Name or path of the camera; without it the first one is taken.
    pub camera: Option<String>,
    /// When the shutter opens and closes, in time codes after [`Options::frame`]; it replaces that of the camera.
    pub shutter: Option<[f64; 2]>,
    /// Fibre of curves whose material has no VellusFur shader.
    pub fallback: Fiber,
}

impl Default for Options {
    /// Needs widths, takes the first camera and makes fur without a material white.
    fn default() -> Self {
        Options { default_width: None, frame: None, camera: None, shutter: None, fallback: Fiber::hair() }
    }
}

/// What [`read`] gives.
#[derive(Clone, Debug)]
pub struct Reading {
    /// What was read, in world space.
    pub scene: Scene,
    /// What is not supported, and what was done instead.
    pub warnings: Vec<Warning>,
    /// All files that were read: layers and textures. A package (.usdz) is one file.
    pub sources: Sources,
}

/// Reads a file (.usda, .usdc, .usdz) with all it refers to.
///
/// What is not supported is skipped and said in the warnings. Everything is brought to world space; the up axis stays what it is.
///
/// # Errors
/// [`Error::File`] if it or a file it refers to is missing or broken, [`Error::Prim`] if a prim has values that do not fit together
/// or are out of range, [`Error::Empty`] if there is nothing to see. A read never panics, but a broken binary file may make the
/// panic hook print a line ([`crate::quiet_caught_panics`]).
pub fn read(file: &Path, options: &Options) -> Result<Reading, Error> {
    if let Some(width) = options.default_width
        && !(0.0..=curves::MAX_WIDTH).contains(&width)
    {
        let max = curves::MAX_WIDTH;
        return Err(Error::file(file, format!("the default width is {width}: it must be in [0, {max:e}]")));
    }
    let stage = Stage::open(file, options.frame)?;
    let paths = stage.prims().map_err(|what| Error::file(file, what))?;
    stage.check_composition(file)?;
    let units = stage.units().map_err(|what| Error::file(file, what))?;
    let mut reader = Reader {
        stage,
        options,
        scene: Scene { units: Some(units), ..Scene::default() },
        warnings: Warnings::default(),
        looks: HashMap::new(),
        surfaces: HashMap::new(),
        held: HashSet::new(),
        textures: HashMap::new(),
    };
    reader.scene(file, &paths)?;
    let Reader { stage, scene, warnings, .. } = reader;
    if scene.strands.is_empty() && scene.meshes.is_empty() {
        let skipped: Vec<String> = warnings.0.iter().map(ToString::to_string).collect();
        let skipped = if skipped.is_empty() { String::new() } else { format!(" ({})", skipped.join("; ")) };
        return Err(Error::Empty { file: file.to_owned(), skipped });
    }
    scene.validate()?;
    Ok(Reading { scene, warnings: warnings.0, sources: stage.sources() })
}

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

impl Reader<'_> {
    fn scene(&mut self, file: &Path, paths: &[String]) -> Result<(), Error> {
        // The camera's shutter decides which times all else is read at.
        let wanted = self.options.camera.as_deref();
        let chosen = camera::choose(&self.stage, paths, wanted)?;
        if let (Some(name), None) = (wanted, &chosen) {
            return Err(Error::file(file, format!("it has no camera called {name}")));
        }
        let shutter = match (self.options.shutter, &chosen) {
            (Some(shutter), _) => shutter,
            (None, Some(prim)) => camera::shutter(&self.stage, prim)?,
            (None, None) => [0.0; 2],
        };
        if !(shutter[0].is_finite() && shutter[1].is_finite() && shutter[0] <= shutter[1]) {
            return Err(Error::file(file, format!("the shutter opens at {} and closes at {}", shutter[0], shutter[1])));
        }
        if shutter[1] > shutter[0] && self.stage.clock.is_timeless() {
            let what = "the stage has no startTimeCode: its first samples are read and nothing moves; give a frame";
            self.warnings.add("/", what);
        }
        self.stage.clock.close = self.stage.clock.open + shutter[1];
        self.stage.clock.open += shutter[0];

        for place in places(&self.stage, paths)? {
            if chosen.as_ref() == Some(&place.path) {
                self.scene.camera = camera::read(self, &place)?;
            } else if place.shown && !place.swallowed {
                self.prim(&place)?;
            }
        }
        Ok(())
    }

    fn prim(&mut self, place: &Place) -> Result<(), Error> {
        match place.type_name.as_str() {
            "BasisCurves" => curves::read(self, place),
            "Mesh" => mesh::read(self, place),
            "DomeLight" | "DomeLight_1" | "DistantLight" | "RectLight" | "DiskLight" | "SphereLight"
            | "CylinderLight" => light::read(self, place),
            "GeomSubset" => {
                let whole = place.path.rsplit_once('/').map_or("", |(parent, _)| parent);
                if bound_material(self, &place.path)? != bound_material(self, whole)? {
                    self.warnings.add(&place.path, "a mesh has one material: that of part of it is left out");
                }
                Ok(())
            }
            // What would be seen in another renderer.
            "NurbsCurves" | "HermiteCurves" | "NurbsPatch" | "Points" | "PointInstancer" | "Sphere" | "Cube"
            | "Cylinder" | "Cylinder_1" | "Cone" | "Capsule" | "Capsule_1" | "Plane" | "TetMesh" | "Volume"
            | "GeometryLight" | "PortalLight" | "PluginLight" => {
                self.warnings.add(&place.path, format!("{} is not supported and left out", place.type_name));
                Ok(())
            }
            _ => Ok(()),
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
