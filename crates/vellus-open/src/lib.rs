//! Opens a scene of hair and fur by its name: a built-in scene, a USD file (.usda, .usdc, .usdz), an Alembic archive
//! (.abc), strands as .hair, .tfx or those of research data sets, or meshes as .obj.
//!
//! [`Staging`] adds a camera, lights and a background to a file without them, and [`Recolor`] changes its fibres.
//!
//! [`FiberSource`] reads a fibre by its name, [`Growth`] grows fur on the meshes of a file, and [`write()`] writes a
//! scene.
//!
//! ```
//! use vellus_open::{Options, open};
//! # fn main() -> Result<(), vellus_open::Error> {
//! let opened = open("hair-lock", &Options { small: true, ..Options::default() })?;
//! assert_eq!(opened.scene.strands[0].len(), 200);
//! for warning in &opened.warnings {
//!     eprintln!("{warning}");
//! }
//! # Ok(()) }
//! ```
#![warn(clippy::print_stdout)]

mod alembic;
mod coats;
mod color;
mod digest;
mod error;
mod fiber;
mod grow;
mod markings;
mod mesh;
mod recolor;
mod shot;
mod staging;
mod write;

pub use color::{color, reflectance};
pub use digest::identify;
pub use error::{Error, Warning};
pub use fiber::{FiberError, FiberFormat, FiberSource, SettingError};
pub use grow::{Grown, Growth, Skin};
pub use markings::{Markings, Mix, Ramp, Tips};
pub use mesh::{choose_meshes, open_coat, open_mesh};
pub use recolor::Recolor;
pub use staging::{Backdrop, Lighting, Staging};
pub use write::{Flavor, Writing, dropped, write};

use std::path::Path;
use vellus::{Fiber, Parameter, Species};
use vellus_groom::{HairHeader, Interpolation};
use vellus_io::Sources;
use vellus_scene::{Camera, Look, ReflectanceOf, Scene, Strands};
use vellus_usd::{FALLBACK_LOOK, RenderSettings, Shot};

/// Options for opening a scene.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Open the small version of a built-in scene.
    pub small: bool,
    /// Name and fibre of strands whose file defines none. `None` is the preset `red-fox`. Built-in scenes have their
    /// own: see [`Options::recolor`].
    pub fiber: Option<(String, Fiber)>,
    /// A change of all fibres, those of the file or of the built-in scene included.
    pub recolor: Option<Recolor>,
    /// Colours along strands, between strands and of the belly.
    pub markings: Markings,
    /// The coat of a species: its [`Markings::of`] where there are no others, and its fibre if there is no other.
    pub coat: Option<Species>,
    /// How wet the coat is, in [0, 1]: its fibres ([`Fiber::wet`]), and its strands, which stick together
    /// ([`vellus_groom::soak`]). 0 changes nothing.
    pub wet: f32,
    /// What the reflectances of the scene mean.
    pub reflectance_of: ReflectanceOf,
    /// Width (diameter) of strands whose file defines none, in the unit of the file; in [0, 2·10⁹]. If it is `None`,
    /// such strands are an error, unless [`Options::staging`] is set: they then get
    /// [`vellus_groom::suggested_width`], and a warning.
    pub width: Option<f32>,
    /// The number of strands as a multiple of those in the file, above 0. Below 1: keep only this share, and widen them
    /// so that they cover as much. Above 1: interpolate between them ([`vellus_groom::interpolate()`]), with roots that
    /// belong to the first frame.
    pub strands: Option<f32>,
    /// How strands follow those between which they are interpolated.
    pub interpolation: Interpolation,
    /// Camera of a USD or Alembic file, by name or path. `None` is the first one.
    pub camera: Option<String>,
    /// Time code of a USD file; `None` is its startTimeCode. Frame of an Alembic archive; `None` is its first sample.
    pub frame: Option<f64>,
    /// When the shutter opens and closes, in time codes or frames relative to the frame, in this order. Equal times are
    /// no motion blur. `None` is the shutter of the camera.
    pub shutter: Option<[f64; 2]>,
    /// How many frames before this one the camera of a USD file is read of: see [`Opened::earlier`].
    pub earlier: usize,
    /// Whether instances of a USD file or a built-in scene share strands and meshes ([`Scene::instances`]). Otherwise
    /// they are copied.
    pub instances: bool,
    /// Whether attributes of strands that rendering does not use are kept ([`Scene::custom`]), for a conversion. They
    /// are lost if [`Options::strands`] changes the strands.
    pub custom: bool,
    /// Whether a warning is an error ([`Error::Strict`]).
    pub strict: bool,
    /// Prepares the scene for a picture. `None` leaves it as it is in the file.
    pub staging: Option<Staging>,
}

impl Options {
    /// Name and fibre of strands whose file defines none.
    fn fiber(&self) -> (String, Fiber) {
        let species = self.coat.unwrap_or(fiber::DEFAULT);
        self.fiber.clone().unwrap_or_else(|| (species.name().to_owned(), Fiber::preset(species)))
    }

    /// All markings.
    fn markings(&self) -> Markings {
        self.markings.clone().or(self.coat.map(Markings::of).unwrap_or_default())
    }
}

/// A scene that was opened.
#[derive(Clone, Debug, Default)]
pub struct Opened {
    /// The scene.
    pub scene: Scene,
    /// The files that it was read from; none for a built-in scene.
    pub sources: Sources,
    /// Warnings about the scene.
    pub warnings: Vec<Warning>,
    /// What [`Options::staging`] added to a file without a camera or lights, in one line.
    pub staged: Option<String>,
    /// What a USD file says about its picture.
    pub settings: Option<RenderSettings>,
    /// The time and the lens of a USD or Alembic file.
    pub shot: Option<Shot>,
    /// The cameras of the frames before in a USD file: see [`vellus_usd::Reading::earlier`].
    pub earlier: Vec<Camera>,
    /// The header of a .hair file. Its thickness is `None` if [`Options::width`] replaces it.
    pub header: Option<HairHeader>,
    /// Whether the lights are those of [`Options::staging`]. The exposure should be set from the picture.
    pub is_metered: bool,
}

/// The longer side of a picture in pixels, if nothing says it.
const LONGER: usize = 960;

/// The size of a picture of a built-in scene if the user does not say it.
pub const BUILT_IN_SIZE: [usize; 2] = [LONGER, 2 * LONGER / 3];

impl Opened {
    /// The size of the picture if the user does not say it: the resolution of the file's RenderSettings, or
    /// 960 pixels for the longer side of the camera's film.
    pub fn size(&self) -> [usize; 2] {
        let resolution = self.settings.and_then(|settings| settings.size);
        resolution.unwrap_or_else(|| self.scene.camera.map_or(BUILT_IN_SIZE, |camera| camera.size(LONGER)))
    }

    /// The part of a picture of this size to render, if the file's RenderSettings have one: left column, top row, width
    /// and height.
    pub fn crop(&self, size: [usize; 2]) -> Option<[usize; 4]> {
        self.settings?.crop(size)
    }

    /// What was added to the content of the files, one line each.
    pub fn notes(&self) -> impl Iterator<Item = String> {
        let width = self.header.and_then(|header| header.thickness).map(|width| {
            let name = self.scene.strands.first().map_or("", |strands| &strands.name);
            format!("{name}: the width is {width}, the default of the file (--width replaces it)")
        });
        self.staged.clone().into_iter().chain(width)
    }
}

/// The format of a scene, from its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// One of [`vellus_groom::SCENES`]. Its name counts before a file of the same name.
    BuiltIn(&'static str),
    /// A USD file.
    Usd,
    /// An Alembic archive.
    Alembic,
    /// Strands in the format of Cem Yuksel.
    Hair,
    /// Strands in the format of TressFX.
    Tfx,
    /// Strands of a research data set: .data, .ply, .npy or .npz.
    Research,
    /// Meshes in Wavefront's format.
    Obj,
}

impl Format {
    /// The format of a scene.
    ///
    /// # Errors
    /// [`Error::Unknown`].
    pub fn of(scene: impl AsRef<Path>) -> Result<Self, Error> {
        let scene = scene.as_ref();
        if let Some((name, _)) = vellus_groom::SCENES.iter().find(|(name, _)| scene.to_str() == Some(name)) {
            return Ok(Format::BuiltIn(name));
        }
        match scene.extension().and_then(|extension| extension.to_str()) {
            Some("hair") => Ok(Format::Hair),
            Some("tfx") => Ok(Format::Tfx),
            Some("data" | "ply" | "npy" | "npz") => Ok(Format::Research),
            _ if mesh::is_obj(scene) => Ok(Format::Obj),
            Some("abc") => Ok(Format::Alembic),
            Some("usda" | "usdc" | "usdz" | "usd") => Ok(Format::Usd),
            _ => Err(Error::Unknown(scene.to_owned())),
        }
    }
}

/// Checks that a scene may have these options, without reading a file. Files that options name must exist.
///
/// # Errors
/// [`Error::Unknown`], [`Error::BuiltIn`], [`Error::NotUsd`], [`Error::TwoCameras`].
/// [`Error::Body`] or [`Error::Read`] for the files of [`Options::staging`].
pub fn check(scene: impl AsRef<Path>, options: &Options) -> Result<Format, Error> {
    let scene = scene.as_ref();
    let seen = options.camera.is_some() || options.frame.is_some() || options.shutter.is_some();
    let viewed = options.staging.as_ref().is_some_and(|staging| staging.view.is_some());
    if options.camera.is_some() && viewed {
        return Err(Error::TwoCameras);
    }
    let format = Format::of(scene)?;
    options.staging.as_ref().map_or(Ok(()), Staging::check)?;
    match format {
        Format::BuiltIn(name) if seen || options.fiber.is_some() || options.width.is_some() => {
            Err(Error::BuiltIn(name.to_owned()))
        }
        Format::Hair | Format::Tfx | Format::Research | Format::Obj if seen => Err(Error::NotUsd(scene.to_owned())),
        _ => Ok(format),
    }
}

/// Opens a scene: the name of a built-in scene, or the path of a file.
///
/// # Errors
/// Those of [`check`]. [`Error::Read`], [`Error::Strands`], [`Error::Usd`] or [`Error::Alembic`] if the file cannot be
/// read or is invalid. [`Error::NoCamera`] if an archive lacks the camera. [`Error::Broken`] or [`Error::Empty`] if
/// nothing of it can be rendered. [`Error::Strict`] if there are warnings, and none may be.
/// [`Error::Fiber`] if [`Options::recolor`] is wrong for a fibre of the scene.
pub fn open(scene: impl AsRef<Path>, options: &Options) -> Result<Opened, Error> {
    // Strands without widths get the width 0 first, and later a suggested one.
    open_with(scene.as_ref(), options, options.staging.as_ref().map(|_| 0.0))
}

/// Opens a scene. Strands whose file has no width at all get the width `missing`.
fn open_with(scene: &Path, options: &Options, missing: Option<f32>) -> Result<Opened, Error> {
    let mut opened = open_dense(scene, options, missing)?;
    if let Some(recolor) = &options.recolor {
        recolor.apply(&mut opened.scene)?;
    }
    opened.scene.reflectance = options.reflectance_of;
    let markings = options.markings();
    if !markings.is_empty() {
        markings.apply(&mut opened.scene);
    }
    if options.wet > 0.0 {
        soak(scene, options, &mut opened.scene)?;
    }
    let is_recolored = options.recolor.as_ref().is_some_and(Recolor::changes_color) || !markings.is_empty();
    if is_recolored && matches!(Format::of(scene)?, Format::BuiltIn(_)) {
        // Its exposure suits the coat that was replaced, and its skin has the pattern of that coat.
        opened.is_metered = true;
        for surface in opened.scene.surfaces.iter_mut().filter(|surface| surface.name.ends_with(" skin")) {
            (surface.skin, surface.color.texture) = (true, None);
        }
    }
    if let Some(staging) = &options.staging {
        let built_in = matches!(Format::of(scene)?, Format::BuiltIn(_));
        let still = still(scene, options, staging, &opened.scene)?;
        opened.warnings.extend(suggest_widths(&mut opened.scene, still.as_ref()));
        if !built_in || *staging != Staging::new(staging.aspect) {
            let camera = opened.scene.camera;
            staging::stage(&mut opened, staging, built_in, still)?;
            if opened.scene.camera != camera {
                opened.earlier.clear();
                opened.shot.iter_mut().for_each(|shot| shot.focal_length = None);
            }
        }
    }
    if options.strict && !opened.warnings.is_empty() {
        return Err(Error::Strict(opened.warnings));
    }
    if let Some(share) = options.strands.filter(|share| *share < 1.0) {
        opened.scene.all_strands_mut().for_each(|strands| *strands = vellus_groom::thin(strands, share));
        opened.scene.custom.clear();
    }
    Ok(opened)
}

/// Opens a scene to measure it. Strands without widths get the width 0 instead of an error.
///
/// # Errors
/// As [`open`].
pub fn open_to_measure(scene: impl AsRef<Path>, options: &Options) -> Result<Opened, Error> {
    open_with(scene.as_ref(), options, Some(0.0))
}

/// The first frame of an animation whose frame `scene` has no widths, camera or lights of its own. All frames get those
/// of the first one, so that they do not flicker.
fn still(path: &Path, options: &Options, staging: &Staging, scene: &Scene) -> Result<Option<Scene>, Error> {
    if options.frame.is_none() || !(staging.is_needed(scene) || scene.all_strands().any(has_no_width)) {
        return Ok(None);
    }
    let mut still = open_dense(path, &Options { frame: None, ..options.clone() }, Some(0.0))?.scene;
    suggest_widths(&mut still, None);
    Ok(Some(still))
}

/// Opens a file, and interpolates between its strands if there are to be more.
fn open_dense(path: &Path, options: &Options, missing: Option<f32>) -> Result<Opened, Error> {
    let mut opened = open_all(path, options, missing)?;
    let Some(factor) = options.strands.filter(|factor| *factor > 1.0) else { return Ok(opened) };
    opened.scene.custom.clear();
    let first = || open_all(path, &Options { frame: None, ..options.clone() }, Some(0.0));
    let rest = options.frame.map(|_| first()).transpose()?.map(|first| first.scene);
    for strands in opened.scene.all_strands_mut() {
        let rest = rest.as_ref().and_then(|rest| rest.all_strands().find(|rest| rest.name == strands.name));
        let denser = vellus_groom::interpolate(strands, rest, factor, options.interpolation);
        *strands = denser.map_err(|source| Error::Interpolation { strands: strands.name.clone(), source })?;
    }
    Ok(opened)
}

/// Makes all coats of a scene wet. Its strands are those of [`open_dense`].
fn soak(path: &Path, options: &Options, scene: &mut Scene) -> Result<(), Error> {
    let first = || open_dense(path, &Options { frame: None, ..options.clone() }, Some(0.0));
    let rest = options.frame.map(|_| first()).transpose()?.map(|first| first.scene);
    for strands in scene.all_strands_mut() {
        let rest = rest.as_ref().and_then(|rest| rest.all_strands().find(|rest| rest.name == strands.name));
        vellus_groom::soak(strands, rest, options.wet);
        strands.varying.retain(|(parameter, _)| *parameter != Parameter::Wet);
    }
    for look in &mut scene.looks {
        look.fiber.wet = options.wet;
        look.textured.retain(|(parameter, _)| *parameter != Parameter::Wet);
    }
    Ok(())
}

fn has_no_width(strands: &Strands) -> bool {
    !strands.points.is_empty() && strands.points.iter().all(|point| point.w == 0.0)
}

/// Gives strands without widths a width that suits their size in `still`, or without it their size here.
fn suggest_widths(scene: &mut Scene, still: Option<&Scene>) -> Vec<Warning> {
    let mut warnings = Vec::new();
    for strands in scene.all_strands_mut().filter(|strands| has_no_width(strands)) {
        let first = still.and_then(|still| still.all_strands().find(|first| first.name == strands.name));
        let width = vellus_groom::suggested_width(first.unwrap_or(strands));
        strands.points.iter_mut().for_each(|point| point.w = 0.5 * width);
        warnings.push(Warning::SuggestedWidth { strands: strands.name.clone(), width });
    }
    warnings
}

fn open_all(path: &Path, options: &Options, missing: Option<f32>) -> Result<Opened, Error> {
    let file = path.display().to_string();
    let missing = options.width.or(missing);
    let (mut sources, mut header) = (Sources::new(), None);
    let mut strands = match check(path, options)? {
        Format::BuiltIn(name) => {
            let unknown = || Error::Unknown(path.to_owned());
            let mut scene = vellus_groom::scene(name, options.small).ok_or_else(unknown)?;
            if !options.instances {
                if scene.copied_points() > vellus_scene::MAX_COPIED {
                    return Err(Error::Copies(name.to_owned()));
                }
                scene.copy_instances();
            }
            return Ok(Opened { scene, sources, ..Opened::default() });
        }
        Format::Usd => return open_usd(path, options, missing),
        Format::Alembic => return alembic::open(path, options, missing),
        Format::Hair => {
            let bytes = read(path, ".hair", &mut sources)?;
            let own = vellus_groom::hair_header(&bytes, &file)?;
            header = Some(HairHeader { thickness: own.thickness.filter(|_| options.width.is_none()), ..own });
            match vellus_groom::read_hair(&bytes, &file, options.width) {
                Err(vellus_groom::Error::NoWidth { .. }) if missing.is_some() => {
                    vellus_groom::read_hair(&bytes, &file, missing)?
                }
                strands => strands?,
            }
        }
        Format::Tfx => vellus_groom::read_tfx(&read(path, ".tfx", &mut sources)?, &file, missing)?,
        Format::Research => {
            let bytes = read(path, "strands", &mut sources)?;
            vellus_groom::read_research(&bytes, &file, missing)?
        }
        Format::Obj => {
            let mut opened = open_mesh(path)?;
            opened.warnings.extend(options.fiber.is_some().then(|| Warning::unused_fiber(path, &[])));
            return Ok(opened);
        }
    };
    let mut warnings = Vec::new();
    if let Some(broken) = strands.remove_broken() {
        if strands.is_empty() {
            return Err(Error::Broken { path: path.to_owned(), broken });
        }
        warnings.push(Warning::Broken { strands: strands.name.clone(), broken });
    }
    let (name, fiber) = options.fiber();
    let scene = Scene { strands: vec![strands], looks: vec![Look::constant(name, fiber)], ..Scene::default() };
    let is_transparent = header.is_some_and(|header| header.transparency != Some(0.0));
    warnings.extend(is_transparent.then_some(Warning::Transparent(file)));
    Ok(Opened { scene, sources, warnings, header, ..Opened::default() })
}

/// Reads a file, and adds it to `sources` by `name`.
fn read(path: &Path, name: &str, sources: &mut Sources) -> Result<Vec<u8>, Error> {
    let bytes = vellus_io::read_at_most(path, vellus_groom::MAX_FILE_BYTES)
        .map_err(|source| Error::Read { path: path.to_owned(), source })?;
    sources.add(name, &bytes);
    Ok(bytes)
}

fn open_usd(path: &Path, options: &Options, width: Option<f32>) -> Result<Opened, Error> {
    let reader = vellus_usd::Options {
        default_width: width,
        frame: options.frame,
        camera: options.camera.clone(),
        shutter: options.shutter,
        earlier: options.earlier,
        fallback: options.fiber().1,
        instances: options.instances,
        custom: options.custom,
        network_base: options.fiber.as_ref().map_or_else(Fiber::hair, |(_, fiber)| *fiber),
    };
    let vellus_usd::Reading { scene, warnings, networks, settings, shot, earlier, sources } =
        vellus_usd::read(path, &reader)?;
    let mut warnings: Vec<Warning> = warnings.into_iter().map(Warning::Usd).collect();
    let is_own = |name: &&str| *name != FALLBACK_LOOK && !networks.iter().any(|network| network == name);
    let own: Vec<&str> = scene.looks.iter().map(|look| look.name.as_str()).filter(is_own).collect();
    if options.fiber.is_some() && (!own.is_empty() || scene.all_strands().next().is_none()) {
        warnings.push(Warning::unused_fiber(path, &own));
    }
    Ok(Opened { scene, sources, warnings, settings, shot: Some(shot), earlier, ..Opened::default() })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Like a USD file, a built-in scene has instances only if the caller can use them.
    #[test]
    fn instances_of_built_in_scenes_are_shared_or_copied() {
        let open = |instances| open("hamsters", &Options { small: true, instances, ..Options::default() });
        let (shared, copied) = (open(true).unwrap().scene, open(false).unwrap().scene);
        let segments = |scene: &Scene| scene.strands.iter().map(vellus_scene::Strands::segments).sum::<usize>();
        assert_eq!((shared.instances.len() > 100, copied.instances.len(), segments(&shared)), (true, 0, 0));
        assert!(segments(&copied) > 100 * 14_500 * 15);
    }

    #[test]
    fn built_in_scenes_have_one_size() {
        for (name, _) in vellus_groom::SCENES {
            let scene = open(name, &Options { small: true, ..Options::default() }).unwrap();
            assert_eq!(scene.size(), BUILT_IN_SIZE, "{name}");
        }
    }

    /// The size is the resolution of the settings, or has the shape of the film. A camera that staging adds fits it.
    #[test]
    fn a_file_says_the_size_of_its_picture() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.usda");
        let of = |prims: &str, aspect: Option<f32>| {
            let hair = "def BasisCurves \"b\" { uniform token type = \"linear\" int[] curveVertexCounts = [2]
                point3f[] points = [(0, 0, 0), (0, 1, 0)] float[] widths = [0.1, 0.1] }";
            std::fs::write(&path, format!("#usda 1.0\n{hair}\n{prims}")).unwrap();
            open(&path, &Options { staging: Some(Staging::new(aspect)), ..Options::default() }).unwrap()
        };
        let camera = "def Camera \"c\" { float horizontalAperture = 36 float verticalAperture = 20.25 }";
        let settings = "def RenderSettings \"s\" { uniform int2 resolution = (300, 600)
            uniform float4 dataWindowNDC = (0, 0, 0.5, 0.5) }";
        let size = |prims: &str| of(prims, None).size();
        assert_eq!(
            (size(""), size(camera), size(&format!("{camera}\n{settings}"))),
            ([960, 640], [960, 540], [300, 600])
        );
        let opened = of(settings, None);
        assert_eq!((opened.size(), opened.crop([300, 600])), ([300, 600], Some([0, 300, 150, 300])));
        assert!((opened.scene.camera.unwrap().aspect() - 0.5).abs() < 1e-6);
        assert!((of(settings, Some(2.0)).scene.camera.unwrap().aspect() - 2.0).abs() < 1e-6);
        assert_eq!(of("", None).crop([960, 640]), None);
    }

    /// A groom without widths, camera and lights, which moves away: all frames have the widths, camera, lights and
    /// backdrop of the first one.
    #[test]
    fn frames_are_staged_alike() {
        const MOVING: &str = "#usda 1.0
(
    startTimeCode = 1
)
def BasisCurves \"hair\" {
    uniform token type = \"linear\"
    int[] curveVertexCounts = [2, 2]
    point3f[] points.timeSamples = {
        1: [(0, 0, 0), (0, 1, 0), (1, 0, 0), (1, 1, 0)],
        4: [(0, 5, 0), (0, 9, 0), (3, 5, 0), (3, 9, 0)],
    }
}
";
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("moving.usda");
        std::fs::write(&path, MOVING).unwrap();
        let at = |frame: Option<f64>, staging: Staging| {
            let options = Options { frame, staging: Some(staging), ..Options::default() };
            open(&path, &options).unwrap()
        };
        let turned = Staging { view: Some("80,10".parse().unwrap()), ..Staging::new(1.5) };
        for staging in [Staging::new(1.5), turned] {
            let [first, last] = [None, Some(4.0)].map(|frame| at(frame, staging.clone()));
            assert_ne!(first.scene.strands[0].points, last.scene.strands[0].points);
            assert_eq!(first.scene.strands[0].points[0].w, last.scene.strands[0].points[0].w);
            assert_eq!((&first.warnings, &first.staged), (&last.warnings, &last.staged));
            let staged = |opened: &Opened| Scene { strands: vec![], ..opened.scene.clone() };
            assert!(first.is_metered && staged(&first) == staged(&last));
        }
    }

    /// Two textures and a light that cannot be read share a line, and each is an error with `strict`.
    #[test]
    fn warnings_of_one_kind_share_a_line_and_may_be_errors() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.usda");
        let light = |name: &str| format!("def DomeLight \"{name}\" {{ asset inputs:texture:file = @{name}.hdr@ }}\n");
        let curves = "def BasisCurves \"c\" { uniform token type = \"linear\" int[] curveVertexCounts = [2, 1]
            point3f[] points = [(0,0,0), (1,0,0), (2,0,0)] float[] widths = [1, 1, 1] }";
        std::fs::write(&path, format!("#usda 1.0\n{}{}{}{curves}", light("x"), light("y"), light("z"))).unwrap();
        let opened = open(&path, &Options::default()).unwrap();
        let lines = Warning::lines(&opened.warnings);
        assert_eq!((opened.warnings.len(), lines.len()), (4, 2), "{lines:?}");
        assert!(
            lines[0].starts_with("3 textures could not be read: the first is /x: inputs:texture:file"),
            "{lines:?}"
        );
        assert!(lines[1].starts_with("/c: 1 of 2 strands are left out (strand 1)"), "{lines:?}");
        let strict = open(&path, &Options { strict: true, ..Options::default() }).unwrap_err();
        assert!(matches!(&strict, Error::Strict(warnings) if warnings.len() == 4));
        assert!(strict.to_string().starts_with("4 warnings are errors with --strict:\n  /x: "), "{strict}");
    }

    /// A .hair file with two strands, one of them with a single point, and one with that strand alone.
    #[test]
    fn broken_strands_of_hair_files_are_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let write = |segments: &[u16]| {
            let points: u32 = segments.iter().map(|n| u32::from(*n) + 1).sum();
            let mut bytes = b"HAIR".to_vec();
            for word in [segments.len() as u32, points, 3, 0, 1f32.to_bits()] {
                bytes.extend(word.to_le_bytes());
            }
            bytes.resize(128, 0);
            segments.iter().for_each(|n| bytes.extend(n.to_le_bytes()));
            (0..3 * points).for_each(|x| bytes.extend((x as f32).to_le_bytes()));
            let path = folder.path().join("a.hair");
            std::fs::write(&path, bytes).unwrap();
            path
        };
        let opened = open(write(&[1, 0]), &Options::default()).unwrap();
        assert_eq!((opened.scene.strands[0].len(), opened.warnings.len()), (1, 1));
        assert!(matches!(open(write(&[0]), &Options::default()), Err(Error::Broken { .. })));
    }

    #[test]
    fn options_that_do_not_fit_are_refused_before_reading() {
        let wide = Options { width: Some(1.0), ..Options::default() };
        let framed = Options { frame: Some(1.0), ..Options::default() };
        assert!(matches!(check("cat", &wide), Err(Error::BuiltIn(name)) if name == "cat"));
        assert!(matches!(check("missing.tfx", &framed), Err(Error::NotUsd(_))));
        assert!(matches!(check("missing.usda", &framed), Ok(Format::Usd)));
        assert!(matches!(check("missing.hair", &wide), Ok(Format::Hair)));
        let mut seen = Staging::new(1.5);
        seen.view = Some(Default::default());
        let seen = Options { camera: Some("a".to_owned()), staging: Some(seen), ..Options::default() };
        assert!(matches!(check("missing.usda", &seen), Err(Error::TwoCameras)));
        assert!(check("unicorn", &wide).unwrap_err().to_string().contains("raccoon"));
        assert!(matches!(open("missing.hair", &wide), Err(Error::Read { .. })));
    }
}
