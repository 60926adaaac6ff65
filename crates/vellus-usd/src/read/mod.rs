//! Reading a stage: each prim goes to the module that reads its schema.

mod camera;
mod color;
mod context;
mod curves;
mod custom;
mod empty;
mod instances;
mod layout;
mod ledger;
pub(crate) mod light;
pub(crate) mod link;
pub(crate) mod look;
mod mesh;
mod motion;
mod network;
mod nurbs;
mod options;
mod paint;
mod parts;
mod polygons;
mod prim;
mod primvar;
mod settings;
mod shading;
mod shapes;
mod skeleton;
mod skin;
mod spheres;
mod subdivision;
pub(crate) mod surface;
pub(crate) mod uv_texture;
mod xform;

pub use options::{Options, Reading, Shot};
pub use settings::RenderSettings;

use crate::error::{Error, Invalid};
use crate::read::context::Reader;
use crate::read::instances::{Shared, is_below};
use crate::read::network::bound_material;
use crate::read::shapes::SHAPES;
use crate::read::skeleton::Skeletons;
use crate::read::xform::{Place, places};
use crate::stack::on_large_stack;
use crate::stage::{MATERIALS, Repairs, Stage};
use crate::warning::{Fault, Warning};
use std::collections::HashMap;
use std::path::Path;
use vellus::Fiber;
use vellus_scene::Units;

/// Reads a file (.usda, .usdc, .usdz) and the files that it refers to.
///
/// Unsupported prims and inputs are ignored, and a warning names them. Parts that cannot be read are left out or
/// replaced, with a warning ([`crate::Fault`]). Everything is transformed to world space. The up axis does not
/// change.
///
/// # Errors
/// [`Error::Read`] if the file cannot be read. [`Error::File`] if it is broken, too large, or lacks the camera of
/// [`Options::camera`]. [`Error::Prim`] if that camera cannot be read. [`Error::Empty`] if nothing is visible. The
/// function never panics, but a broken binary file may make the panic hook print a line (see
/// [`crate::quiet_caught_panics`]).
pub fn read(file: &Path, options: &Options) -> Result<Reading, Error> {
    if let Some(width) = options.default_width
        && !(0.0..=curves::MAX_WIDTH).contains(&width)
    {
        let max = curves::MAX_WIDTH;
        return Err(Error::file(file, format!("the default width is {width}: it must be in [0, {max:e}]")));
    }
    on_large_stack(|| read_stage(file, options)).map_err(|error| Error::file(file, error))?
}

/// How often a stage is opened again without the properties of more layers.
const MOST_REPAIRS: usize = 4;

fn read_stage(file: &Path, options: &Options) -> Result<Reading, Error> {
    let mut stage = Stage::open(file, options.frame, Repairs::default())?;
    // Composition reads layers when they are needed.
    for _ in 0..MOST_REPAIRS {
        let read = read_composed(&stage, file, options);
        let Some(repairs) = stage.repairs() else { return read };
        stage = Stage::open(file, options.frame, repairs)?;
    }
    read_composed(&stage, file, options)
}

fn read_composed(stage: &Stage, file: &Path, options: &Options) -> Result<Reading, Error> {
    let broken = |what: Invalid| Error::file(file, what);
    let paths = stage.prims().map_err(broken)?;
    let mut reader = Reader::new(stage, options, Units::CENTIMETERS);
    let (units, ignored) = stage.units().map_err(broken)?;
    reader.scene.units = Some(units);
    ignored.iter().for_each(|what| reader.warnings.add("/", *what));
    let (settings, places) = read_prims(&mut reader, file, &paths)?;
    // Composition goes on while prims are read.
    for (place, what) in stage.composition_faults().map_err(broken)? {
        let what = format!("{what}: what it would bring in is left out");
        reader.warnings.add_fault(Some(Fault::Layer), &place, what);
    }
    for (prim, what) in stage.losses() {
        reader.warnings.add(&prim, format!("{what}: it is left out"));
    }
    if !options.instances {
        instances::copy_all(&mut reader)?;
    }
    ledger::check(&mut reader)?;
    let clock = stage.clock();
    let shot = Shot {
        frame: (!clock.is_timeless()).then_some(clock.frame),
        // A wrong rate is an error only where velocities need it.
        frames_per_second: stage.time_codes_per_second().unwrap_or(24.0),
        focal_length: reader.focal_length.filter(|_| reader.scene.camera.is_some()),
        range: stage.range(),
    };
    let Reader { scene, warnings, networks, earlier, .. } = reader;
    let warnings = warnings.into_vec();
    if scene.strands.is_empty() && scene.meshes.is_empty() && scene.instances.is_empty() {
        let skipped: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        let skipped = if skipped.is_empty() { String::new() } else { format!(" ({})", skipped.join("; ")) };
        let skipped = empty::reason(stage, &places).unwrap_or_else(String::from) + &skipped;
        return Err(Error::Empty { file: file.to_owned(), skipped });
    }
    scene.validate()?;
    Ok(Reading { scene, warnings, networks, settings, shot, earlier, sources: stage.sources() })
}

/// Reads a material of a MaterialX document (.mtlx) as a fibre. `name` may be `None` if the document has one material.
///
/// `base` gives the parameters that MaterialX lacks. The warnings report what was mapped. A fibre alone has no images:
/// parameters with images keep the values of `base`, and a warning names them.
///
/// # Errors
/// [`Error::Read`] if the document cannot be read. [`Error::File`] if it is broken, or does not have this one material.
/// [`Error::Prim`] if an input is out of range.
pub fn read_material(file: &Path, name: Option<&str>, base: &Fiber) -> Result<(Fiber, Vec<Warning>), Error> {
    on_large_stack(|| material_of(file, name, base)).map_err(|error| Error::file(file, error))?
}

fn material_of(file: &Path, name: Option<&str>, base: &Fiber) -> Result<(Fiber, Vec<Warning>), Error> {
    let options = Options { network_base: *base, ..Options::default() };
    let stage = Stage::open(file, None, Repairs::default())?;
    let materials = stage.children(MATERIALS).map_err(|what| Error::file(file, what))?;
    let known = materials.join(", ");
    let material = match (name, &materials[..]) {
        (None, [only]) => only,
        (None, _) => return Err(Error::file(file, format!("it has several materials: choose one of {known}"))),
        (Some(name), all) => match all.iter().find(|material| *material == name) {
            Some(material) => material,
            None => return Err(Error::file(file, format!("it has no material {name}: known are {known}"))),
        },
    };
    let mut reader = Reader::new(&stage, &options, Units::CENTIMETERS);
    reader.is_named = true;
    let found = shading::look(&mut reader, &format!("{MATERIALS}/{material}"))?;
    let (look, _) =
        found.ok_or_else(|| Error::file(file, format!("the material {material} has no shader of fibres")))?;
    if !look.textured.is_empty() {
        let names: Vec<&str> = look.textured.iter().map(|(parameter, _)| parameter.name()).collect();
        let what =
            format!("a fibre has no images, so those of {} are ignored: bind the material to curves", names.join(", "));
        reader.warnings.add(&look.name, what);
    }
    Ok((look.fiber, reader.warnings.into_vec()))
}

fn read_prims(
    reader: &mut Reader,
    file: &Path,
    paths: &[String],
) -> Result<(Option<RenderSettings>, Vec<Place>), Error> {
    // The shutter of the camera decides at which times everything else is read.
    let wanted = reader.options.camera.as_deref();
    let settings = settings::read(reader, paths)?;
    let chosen = camera::choose(reader, paths, wanted, &settings)?;
    if let (Some(name), None) = (wanted, &chosen) {
        return Err(Error::file(file, format!("the stage has no camera called {name}")));
    }
    let shutter = match (reader.options.shutter, &chosen) {
        (Some(shutter), _) => shutter,
        (None, Some(prim)) => camera::shutter(reader, prim, &settings)?,
        (None, None) => [0.0; 2],
    };
    if !is_shutter(shutter) {
        return Err(Error::file(
            file,
            format!(
                "the shutter opens at {} and closes at {}: both must be finite, and the first must not be later",
                shutter[0], shutter[1]
            ),
        ));
    }
    if shutter[1] > shutter[0] && reader.stage.clock().is_timeless() {
        let what = "the stage has no startTimeCode: the first samples are read, without motion blur; set a frame";
        reader.warnings.add("/", what);
    }
    reader.stage.set_shutter(shutter);

    if reader.options.earlier > 0 {
        reader.stage.watch_time();
    }
    let places = places(reader, paths)?;
    // The camera decides how far meshes are subdivided, or their number.
    reader.meshes = places.iter().filter(|place| place.type_name == "Mesh").count();
    if let Some(place) = places.iter().find(|place| Some(&place.path) == chosen.as_ref()) {
        match camera::read(reader, place, &settings) {
            Err(error) if wanted.is_none() => reader.fault(Fault::Prim, &place.path, error, "it is left out")?,
            camera => reader.scene.camera = camera?,
        }
        reader.eye = reader.scene.camera;
    } else {
        reader.stage_size = subdivision::stage_size(reader, &places);
    }
    reader.stage.forget_time();
    reader.skeletons = Skeletons::new(&places);
    let shared = Shared::find(reader, &places)?;
    let mut prototypes: HashMap<usize, Option<usize>> = HashMap::new();
    let mut point_prototypes = HashMap::new();
    let mut inside: Option<&str> = None;
    for (i, place) in places.iter().enumerate() {
        inside = inside.filter(|root| is_below(&place.path, root));
        if chosen.as_ref() == Some(&place.path) {
            continue;
        }
        if let Some(first) = shared.first(i) {
            inside = Some(&place.path);
            let prototype = match prototypes.get(&first) {
                Some(known) => *known,
                None => {
                    let within = places[i..].iter().take_while(|other| is_below(&other.path, &place.path));
                    let to_local = [place.to_world, place.moved].map(|matrix| matrix.inverse());
                    let known = &mut point_prototypes;
                    let read = instances::prototype(reader, &place.path, within, to_local, (&places, known))?;
                    prototypes.insert(first, read);
                    read
                }
            };
            if let Some(prototype) = prototype {
                reader
                    .attempt(&place.path, |reader| instances::add(reader, &place.path, prototype, &place.to_world))?;
            }
        }
        if !place.shown || place.swallowed {
            continue;
        }
        let kind = place.type_name.as_str();
        let is_shape = kind == "GeomSubset" || is_drawn(kind);
        if place.type_name == "PointInstancer" && inside.is_none() {
            reader.attempt(&place.path, |reader| {
                instances::point_instancer(reader, place, &places, &mut point_prototypes)
            })?;
        } else if inside.is_none() || !is_shape {
            reader.attempt(&place.path, |reader| read_prim(reader, place))?;
        }
    }
    link::read(reader, &places)?;
    reader.earlier = camera::earlier(reader, &places, chosen.as_deref(), &settings)?;
    Ok((settings.picture, places))
}

/// Whether prims of a type are strands or meshes in a picture.
fn is_drawn(kind: &str) -> bool {
    CURVES.contains(&kind) || ["Mesh", "Points"].contains(&kind) || SHAPES.contains(&kind)
}

/// Whether a shutter opens and closes in this order.
fn is_shutter([open, close]: [f64; 2]) -> bool {
    open.is_finite() && close.is_finite() && open <= close
}

fn read_prim(reader: &mut Reader, place: &Place) -> Result<(), Error> {
    match place.type_name.as_str() {
        kind if CURVES.contains(&kind) => curves::read(reader, place),
        "Mesh" => mesh::read(reader, place),
        "Points" => spheres::read(reader, place),
        shape if SHAPES.contains(&shape) => shapes::read(reader, place),
        light if LIGHTS.contains(&light) => {
            reader.prim(&place.path)?;
            light::read(reader, place)
        }
        "GeomSubset" => {
            let whole = place.path.rsplit_once('/').map_or("", |(parent, _)| parent);
            let is_mesh = reader.stage.type_name(whole)? == "Mesh";
            if !is_mesh && bound_material(reader, &place.path)? != bound_material(reader, whole)? {
                reader.warnings.add(&place.path, "only meshes have parts: the material of this subset is ignored");
            }
            Ok(())
        }
        known if UNSUPPORTED.contains(&known) => {
            reader.warnings.add(&place.path, format!("{} is not supported and is ignored", place.type_name));
            Ok(())
        }
        // Groups: what they have is inherited.
        group if GROUPS.contains(&group) => reader.prim(&place.path).map(|_| ()),
        // Prims that are read where others refer to them, and those that are nowhere in a picture.
        known if UNSEEN.contains(&known) || known.starts_with("Physics") => Ok(()),
        unknown => {
            reader.warnings.add(&place.path, format!("{unknown} is not known and is ignored"));
            Ok(())
        }
    }
}

/// Types of prims that are strands.
const CURVES: [&str; 3] = ["BasisCurves", "HermiteCurves", "NurbsCurves"];

const LIGHTS: [&str; 7] =
    ["DomeLight", "DomeLight_1", "DistantLight", "RectLight", "DiskLight", "SphereLight", "CylinderLight"];

/// Types of prims that other renderers show.
const UNSUPPORTED: [&str; 6] = ["NurbsPatch", "TetMesh", "Volume", "GeometryLight", "PortalLight", "PluginLight"];

const GROUPS: [&str; 4] = ["", "Scope", "Xform", "SkelRoot"];

/// Types of prims that are not in a picture by themselves.
const UNSEEN: [&str; 25] = [
    "Camera",
    "Material",
    "Shader",
    "NodeGraph",
    "Backdrop",
    "PointInstancer",
    "LightFilter",
    "PluginLightFilter",
    "RenderSettings",
    "RenderProduct",
    "RenderVar",
    "RenderPass",
    "RenderDenoisePass",
    "Skeleton",
    "SkelAnimation",
    "BlendShape",
    "SpatialAudio",
    "ColorSpace",
    "OpenVDBAsset",
    "Field3DAsset",
    "HoudiniLayerInfo",
    "HoudiniFieldAsset",
    "ArnoldOptions",
    "ArnoldDriverExr",
    "CoordSys",
];
