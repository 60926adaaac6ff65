//! Scenes: from files, or built from arrays.

use super::arrays::{Floats, indices, one_of, required};
use super::values::{BASES, WRAPS, corners, parameter, position, varying};
use super::world::{Prepared, Setup};
use crate::checks::{positive, within};
use crate::error::{value, with_causes};
use crate::fiber;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::{PyDict, PyString};
use std::fmt::Display;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use vellus::glam::{Vec2, Vec3, Vec4};
use vellus_open::{Backdrop, Markings, Staging, Tips, Warning};
use vellus_scene::{Instance, Look, Mesh, Opacity, Prototype, Strands, Surface, Texture};
use vellus_scene::{MAX_COORDINATE, Tint, Value};

/// What a scene consists of, and its last preparation for rays.
#[derive(Default)]
pub struct State {
    pub scene: vellus_scene::Scene,
    pub warnings: Vec<String>,
    /// Whether the lights are set from the picture, because the file had none.
    pub is_metered: bool,
    pub is_transparent: bool,
    pub prepared: Option<(Setup, Arc<Prepared>)>,
}

impl State {
    /// To change the scene. What was prepared is no longer valid.
    pub fn change(&mut self) -> &mut vellus_scene::Scene {
        self.prepared = None;
        &mut self.scene
    }
}

/// An argument that is a text, as something else.
pub(super) fn parsed<T: FromStr<Err: Display>>(name: &str, text: Option<String>) -> PyResult<Option<T>> {
    let parse = |text: String| text.parse().map_err(|e| PyValueError::new_err(format!("{name} = {text:?}: {e}")));
    text.map(parse).transpose()
}

/// A colour, RGB in [0, 1] or its name.
fn reflectance_argument(name: &str, color: &Bound<'_, PyAny>) -> PyResult<[f32; 3]> {
    let color = match color.is_instance_of::<PyString>() {
        true => vellus_open::color(&color.extract::<String>()?)
            .map_err(|error| PyValueError::new_err(format!("{name} = {error}")))?,
        false => color
            .extract::<[f32; 3]>()
            .map_err(|_| PyTypeError::new_err(format!("{name} must be three numbers or the name of a colour")))?,
    };
    color.iter().try_for_each(|&c| within(name, f64::from(c), 0.0..=1.0))?;
    Ok(color)
}

/// The number of points of each strand. `grid`: those of strands that all have as many, whose points are (S, K, 3).
fn counts_of(counts: Option<&Bound<'_, PyAny>>, grid: Option<[usize; 2]>) -> PyResult<Vec<u32>> {
    match (counts, grid) {
        (None, Some([strands, each])) => Ok(vec![u32::try_from(each).map_err(value)?; strands]),
        (Some(_), Some([strands, each])) => Err(PyValueError::new_err(format!(
            "points has the shape ({strands}, {each}, 3), which says how many points each strand has: leave counts out"
        ))),
        (counts, None) => {
            let (shape, counts) = indices(&required(counts.cloned(), "counts", "add_strands")?, "counts")?;
            if shape.len() == 1 {
                return Ok(counts);
            }
            let shape = crate::arrays::text(&shape);
            Err(PyValueError::new_err(format!("counts has the shape {shape}: it must be (strands,)")))
        }
    }
}

/// Strands, meshes, lights and a camera.
///
/// `Scene()` is empty; `Scene.open` reads one. Lengths have any unit, z or y may be up. Arrays are copied into single
/// precision. Indices that the methods return are valid in this scene only.
///
/// A scene may be used from several threads. Each change waits for the others.
#[pyclass(frozen, module = "vellus", name = "Scene")]
pub struct Scene(Mutex<State>);

impl Scene {
    /// The state. While this waits, it releases the interpreter's lock: the thread that has the state may need that.
    pub fn lock(&self) -> MutexGuard<'_, State> {
        Python::attach(|py| self.0.lock_py_attached(py)).unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl Scene {
    #[new]
    fn new() -> Self {
        Scene(Mutex::default())
    }

    /// Reads a scene.
    ///
    /// `path`: a USD or Alembic file, strands as .hair, .tfx, .data, .ply, .npy or .npz, a mesh as .obj, or the name of
    /// a built-in scene: `vellus scene list` has them. `small`: the small version of a built-in scene. `fiber`: for
    /// strands without a look. `width`: diameter of strands without widths. `strands`: their number, as a multiple of
    /// those of the file, in (0, 100]: below 1 the others are left out, above 1 there are more between them. `camera`,
    /// `frame`: of a USD or Alembic file. `strict`: whether a warning is an error. `aspect`: width over height of the
    /// picture, for a camera that is added. `reflectance_of`: whether a reflectance is the colour that this groom shows
    /// (`groom`) or that of a dense coat (`dense`). `tip_color`: colour of the tips of all strands, RGB or a name, over
    /// the share `tips` of their length, in (0, 1]. `ramp`: colours from root to tip, `"black fawn@40% white"`.
    /// `belly`: the colour where the skin faces down. `mix`: strands of other colours, `["white:30%"]`. `coat`: the
    /// coat of a species, such as `red-fox`, whose parts these replace; its fibre is the default of `fiber`. `wet`: how
    /// wet the coat is, in [0, 1]. `shutter`: when the shutter of a USD file opens and closes, in frames relative to
    /// the frame; `(0, 0)` is no motion blur, and `None` the shutter of the camera.
    ///
    /// Without `stage=False` a scene without camera or lights gets them. `light` (`studio`, `sun`, `sky` or an image
    /// file), `background` (`transparent`, `black`, `white`, `grey`, `#rrggbb` or an image file), `view`
    /// (`"YAW,PITCH[,ZOOM]"` in degrees) and `body` (a mesh file) change the staging.
    ///
    /// Raises `FileNotFoundError` or `PermissionError` for a file that cannot be opened, and `ValueError` with the file
    /// and the reason. `warnings` has everything that was left out.
    #[staticmethod]
    #[pyo3(signature = (path, *, small=false, fiber=None, width=None, strands=None, camera=None, frame=None,
        strict=false, stage=true, aspect=1.5, light=None, background=None, view=None, body=None,
        reflectance_of="groom", tip_color=None, tips=0.3, ramp=None, belly=None, mix=vec![], coat=None, wet=0.0,
        shutter=None))]
    fn open(
        py: Python<'_>,
        path: PathBuf,
        small: bool,
        fiber: Option<&Bound<'_, PyAny>>,
        width: Option<f32>,
        strands: Option<f32>,
        camera: Option<String>,
        frame: Option<f64>,
        strict: bool,
        stage: bool,
        aspect: f32,
        light: Option<String>,
        background: Option<String>,
        view: Option<String>,
        body: Option<PathBuf>,
        reflectance_of: &str,
        tip_color: Option<&Bound<'_, PyAny>>,
        tips: f32,
        ramp: Option<String>,
        belly: Option<&Bound<'_, PyAny>>,
        mix: Vec<String>,
        coat: Option<String>,
        wet: f32,
        shutter: Option<[f64; 2]>,
    ) -> PyResult<Self> {
        positive("aspect", aspect.into(), 1e6)?;
        within("tips", f64::from(tips), 1e-3..=1.0)?;
        within("wet", f64::from(wet), 0.0..=1.0)?;
        strands.map_or(Ok(()), |factor| positive("strands", factor.into(), 100.0))?;
        width.map_or(Ok(()), |width| within("width", width.into(), 0.0..=2e9))?;
        if !stage && (light.is_some() || background.is_some() || view.is_some() || body.is_some()) {
            return Err(PyValueError::new_err("light, background, view and body need stage=True"));
        }
        if let Some([open, close]) = shutter {
            within("shutter", open, f64::MIN..=close.min(f64::MAX))?;
        }
        let light = parsed("light", light)?;
        let background: Option<Backdrop> = parsed("background", background)?;
        let view = parsed("view", view)?;
        let fiber = match fiber {
            Some(given) => {
                let name = given.cast::<PyString>().map_or_else(|_| "fiber".to_owned(), |name| name.to_string());
                Some((name, fiber::argument(given)?))
            }
            None => None,
        };
        let is_transparent = background == Some(Backdrop::Transparent);
        let staging = stage.then(|| Staging { view, light, background, body, ..Staging::new(aspect) });
        let options = vellus_open::Options {
            small,
            fiber,
            markings: Markings {
                ramp: parsed("ramp", ramp)?,
                belly: belly.map(|color| reflectance_argument("belly", color)).transpose()?,
                tips: tip_color
                    .map(|color| reflectance_argument("tip_color", color))
                    .transpose()?
                    .map(|color| Tips { color, share: tips }),
                mix: mix
                    .into_iter()
                    .map(|mix| mix.parse().map_err(|e| PyValueError::new_err(format!("mix = {e}"))))
                    .collect::<PyResult<_>>()?,
            },
            coat: parsed("coat", coat)?,
            wet,
            reflectance_of: parsed("reflectance_of", Some(reflectance_of.to_owned()))?.unwrap_or_default(),
            width,
            strands,
            camera,
            frame,
            shutter,
            instances: true,
            strict,
            staging,
            ..vellus_open::Options::default()
        };
        let opened = crate::threads::run(py, |_| vellus_open::open(&path, &options))?.map_err(|e| with_causes(&e))?;
        let warnings = Warning::lines(&opened.warnings).into_iter().chain(opened.notes()).collect();
        let is_metered = opened.is_metered;
        Ok(Scene(Mutex::new(State { scene: opened.scene, warnings, is_metered, is_transparent, prepared: None })))
    }

    /// What was left out or added when the scene was read, in words.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.lock().warnings.clone()
    }

    /// The number of strands, without those of instances.
    #[getter]
    fn strand_count(&self) -> usize {
        self.lock().scene.strands.iter().map(Strands::len).sum()
    }

    /// The names of the light groups, in the order of the layer `lights`.
    #[getter]
    fn light_groups(&self) -> Vec<String> {
        self.lock().scene.light_group_names()
    }

    /// The smallest and the largest coordinates, or `None` for an empty scene.
    #[getter]
    fn bounds(&self) -> Option<([f32; 3], [f32; 3])> {
        self.lock().scene.bounds().map(|(low, high)| (low.to_array(), high.to_array()))
    }

    /// Adds a kind of fibre and returns its index.
    ///
    /// `fiber`: a `Fiber`, or the name of a preset. `name`: for Cryptomatte and messages. `textures`: images for
    /// parameters at the roots' `uv`, by the name of the parameter; each is an index of `add_texture`.
    #[pyo3(signature = (fiber, *, name="", textures=None))]
    fn add_look(&self, fiber: &Bound<'_, PyAny>, name: &str, textures: Option<&Bound<'_, PyDict>>) -> PyResult<usize> {
        let mut look = Look::constant(name, fiber::argument(fiber)?);
        let mut state = self.lock();
        let all = state.scene.textures.len();
        for (name, texture) in textures.into_iter().flatten() {
            let parameter = parameter(&name.extract::<String>()?)?;
            let texture = position(all, texture.extract()?, "texture")?;
            look.textured.push((parameter, Value { texture, scale: [1.0; 3] }));
        }
        let looks = &mut state.change().looks;
        if look.name.is_empty() {
            look.name = format!("look {}", looks.len());
        }
        looks.push(look);
        Ok(looks.len() - 1)
    }

    /// Adds an image and returns its index.
    ///
    /// `image`: RGB of the shape (height, width, 3), linear, not negative, the top row first; or a .png, .jpg, .hdr or
    /// .exr file. `wrap`: outside of [0, 1]², `repeat`, `clamp`, `mirror` or `black`. `linear`: the file has numbers,
    /// not colours. `name`: for messages.
    ///
    /// Raises `FileNotFoundError` or `PermissionError` for a file that cannot be opened, and `ValueError` for a bad
    /// image.
    #[pyo3(signature = (image, *, wrap="repeat", linear=false, name=""))]
    fn add_texture(&self, image: &Bound<'_, PyAny>, wrap: &str, linear: bool, name: &str) -> PyResult<usize> {
        let wrap = [one_of("wrap", wrap, &WRAPS)?; 2];
        let texture = if let Ok(path) = image.extract::<PathBuf>() {
            let load = if linear { vellus_usd::load_map } else { vellus_usd::load_texture };
            let (texture, warning) = load(&path).map_err(|e| with_causes(&e))?;
            self.lock().warnings.extend(warning.map(|warning| warning.to_string()));
            Texture { wrap, ..texture }
        } else {
            let image = Floats::new(image, "image")?;
            let [height, width, 3] = image.shape[..] else {
                let shape = crate::arrays::text(&image.shape);
                return Err(PyValueError::new_err(format!(
                    "image has the shape {shape}: it must be (height, width, 3)"
                )));
            };
            let name = if name.is_empty() { "image" } else { name }.to_owned();
            Texture { name, width, height, pixels: image.values.as_chunks::<3>().0.to_vec().into(), wrap }
        };
        texture.validate().map_err(value)?;
        let mut state = self.lock();
        let textures = &mut state.change().textures;
        textures.push(texture);
        Ok(textures.len() - 1)
    }

    /// Adds strands.
    ///
    /// `points`: control points of all strands from root to tip, (P, 3), with `counts`: points of each strand, (S,). Or
    /// without counts: (S, K, 3), strands of K points each; P is then S·K. `radii`: one number, (S,), (P,) or (S, K).
    /// `basis`: `linear`, `bspline`, `catmull-rom` or `bezier`. B-splines and Catmull–Rom curves of n points have n − 3
    /// segments, Bézier curves have 3 k + 1 points. `look`: from `add_look`. `uv`: texture coordinates of the roots,
    /// (S, 2). `moved`: the points when the shutter closes, (P, 3) or (S, K, 3). `normals`: directions of the shorter
    /// axis of flat fibres (`aspect_ratio`), (P, 3) or (S, K, 3); the part along the strand does not count. Without
    /// them, each strand has a direction of its own. `parameters`: values that replace those of the look, by name: one,
    /// or for each strand, or for each of the P points, with one number or RGB; angles in degrees. `name`: for
    /// Cryptomatte and messages. `prototype`: strands of this prototype, for instances.
    ///
    /// Raises `ValueError` that names the argument or the strand.
    #[pyo3(signature = (points, counts=None, radii=None, *, look=0, basis="linear", uv=None, moved=None,
        normals=None, parameters=None, name="", prototype=None))]
    fn add_strands(
        &self,
        points: &Bound<'_, PyAny>,
        counts: Option<&Bound<'_, PyAny>>,
        radii: Option<&Bound<'_, PyAny>>,
        look: i128,
        basis: &str,
        uv: Option<&Bound<'_, PyAny>>,
        moved: Option<&Bound<'_, PyAny>>,
        normals: Option<&Bound<'_, PyAny>>,
        parameters: Option<&Bound<'_, PyDict>>,
        name: &str,
        prototype: Option<i128>,
    ) -> PyResult<()> {
        let basis = one_of("basis", basis, &BASES)?;
        let points = Floats::new(points, "points")?;
        let grid = match points.shape[..] {
            [_, 3] => None,
            [strands, each, 3] => Some([strands, each]),
            _ => return Err(points.wrong_shape("(points, 3) or (strands, points, 3)")),
        };
        let counts = counts_of(counts, grid)?;
        let points = points.merged(grid).points("points")?;
        let total: u64 = counts.iter().map(|n| u64::from(*n)).sum();
        if total != points.len() as u64 {
            let what = format!("counts sums to {total}, but points has {} rows", points.len());
            return Err(PyValueError::new_err(what));
        }
        let radii = Floats::new(&required(radii.cloned(), "radii", "add_strands")?, "radii")?.merged(grid);
        if let Some(i) = radii.values.iter().position(|r| !(0.0..=MAX_COORDINATE).contains(r)) {
            let what = format!("radii has {} at position {i}: it must be in [0, {MAX_COORDINATE:e}]", radii.values[i]);
            return Err(PyValueError::new_err(what));
        }
        let radii = if radii.shape[..] == [counts.len()] && counts.len() != points.len() {
            counts.iter().zip(&radii.values).flat_map(|(n, r)| std::iter::repeat_n(*r, *n as usize)).collect()
        } else {
            radii.each(points.len())?
        };
        let name = if name.is_empty() { "strands" } else { name }.to_owned();
        let mut starts = vec![0];
        for (i, n) in counts.iter().enumerate() {
            let first = starts[i] as usize;
            let own = &points[first..first + *n as usize];
            if own.windows(2).all(|pair| pair[0] == pair[1]) {
                return Err(PyValueError::new_err(format!(
                    "strand {i} of {name} has no length: all its points are equal"
                )));
            }
            starts.push(starts[i] + n);
        }
        let uv = uv.map(|uv| Floats::new(uv, "uv")?.rows_of::<2>(counts.len())).transpose()?;
        let vectors = |given: Option<&Bound<'_, PyAny>>, name: &str| -> PyResult<Option<Vec<Vec3>>> {
            let rows = given.map(|given| Floats::new(given, name)?.merged(grid).rows_of::<3>(points.len()));
            Ok(rows.transpose()?.map(|rows| rows.into_iter().map(Vec3::from).collect()))
        };
        let (moved, normals) = (vectors(moved, "moved")?, vectors(normals, "normals")?);
        let mut values = Vec::new();
        for (name, given) in parameters.into_iter().flatten() {
            let name: String = name.extract()?;
            let given = Floats::new(&given, &format!("parameters[{name:?}]"))?;
            let parameter = parameter(&name)?;
            values.push((parameter, varying(parameter, &given, counts.len(), points.len())?));
        }
        let look = position(self.lock().scene.looks.len(), look, "look")?;
        let strands = Strands {
            name,
            basis,
            starts,
            points: points.into_iter().zip(radii).map(|(p, r): (Vec3, f32)| p.extend(r)).collect::<Vec<Vec4>>(),
            moved,
            normals,
            root_uv: uv.map(|uv| uv.into_iter().map(Vec2::from).collect()),
            look,
            varying: values,
        };
        strands.validate().map_err(value)?;
        let mut state = self.lock();
        let scene = state.change();
        match prototype {
            None => scene.strands.push(strands),
            Some(i) => {
                let i = position(scene.prototypes.len(), i, "prototype")?;
                scene.prototypes[i].strands.push(strands);
            }
        }
        Ok(())
    }

    /// Adds the surface of meshes and returns its index: a diffuse base under a rough coat, or metal, as in
    /// UsdPreviewSurface.
    ///
    /// `color`: linear RGB in [0, 1], times the image `texture`. `emission`: radiance, RGB or one number, at least 0.
    /// `roughness`, `metallic`: in [0, 1]. `ior`: of the coat, in [1, 4]; 1 means no coat. `name`: for messages.
    #[pyo3(signature = (*, color=None, texture=None, emission=None, roughness=0.5, metallic=0.0, ior=1.5,
        name=""))]
    fn add_surface(
        &self,
        color: Option<&Bound<'_, PyAny>>,
        texture: Option<i128>,
        emission: Option<&Bound<'_, PyAny>>,
        roughness: f32,
        metallic: f32,
        ior: f32,
        name: &str,
    ) -> PyResult<usize> {
        let color = color.map_or(Ok([1.0; 3]), |color| Floats::new(color, "color")?.color())?;
        let emission = emission.map_or(Ok([0.0; 3]), |emission| Floats::new(emission, "emission")?.color())?;
        for (name, x, low, high) in
            [("roughness", roughness, 0.0, 1.0), ("metallic", metallic, 0.0, 1.0), ("ior", ior, 1.0, 4.0)]
        {
            if !(low..=high).contains(&x) {
                let what = format!("{name} = {x} is out of range: it must be in [{low}, {high}]");
                return Err(PyValueError::new_err(what));
            }
        }
        if !color.iter().all(|x| (0.0..=1.0).contains(x)) {
            return Err(PyValueError::new_err(format!("color = {color:?} is out of range: it must be in [0, 1]")));
        }
        if emission.iter().any(|x| *x < 0.0) {
            return Err(PyValueError::new_err(format!(
                "emission = {emission:?} is out of range: it must be at least 0"
            )));
        }
        let mut state = self.lock();
        let all = state.scene.textures.len();
        let texture = texture.map(|texture| position(all, texture, "texture")).transpose()?;
        let surfaces = &mut state.change().surfaces;
        let name = if name.is_empty() { format!("surface {}", surfaces.len()) } else { name.to_owned() };
        surfaces.push(Surface {
            name,
            color: Tint { color, texture },
            emission,
            roughness,
            metallic,
            ior,
            opacity: Opacity::FULL,
            normals: None,
            skin: false,
        });
        Ok(surfaces.len() - 1)
    }

    /// Adds a mesh.
    ///
    /// `points`: (V, 3). `triangles`: vertices, counterclockwise from outside, (T, 3). `surface`: from `add_surface`.
    /// `normals`: (V, 3) or of each corner (T, 3, 3); flat without. `uv`: (V, 2) or (T, 3, 2). `moved`: the points when
    /// the shutter closes, (V, 3). `name`: for Cryptomatte and messages. `prototype`: a mesh of this prototype, for
    /// instances.
    #[pyo3(signature = (points, triangles, *, surface, normals=None, uv=None, moved=None, name="",
        prototype=None))]
    fn add_mesh(
        &self,
        points: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
        surface: i128,
        normals: Option<&Bound<'_, PyAny>>,
        uv: Option<&Bound<'_, PyAny>>,
        moved: Option<&Bound<'_, PyAny>>,
        name: &str,
        prototype: Option<i128>,
    ) -> PyResult<()> {
        let positions = Floats::new(points, "points")?.points("vertices")?;
        let (shape, flat) = indices(triangles, "triangles")?;
        if shape.len() != 2 || shape[1] != 3 {
            let shape = crate::arrays::text(&shape);
            return Err(PyValueError::new_err(format!("triangles has the shape {shape}: it must be (triangles, 3)")));
        }
        let triangles = flat.as_chunks::<3>().0.to_vec();
        if let Some(i) = triangles.iter().position(|t| t.iter().any(|v| *v as usize >= positions.len())) {
            let what = format!("triangles[{i}] has a vertex out of range: there are {} points", positions.len());
            return Err(PyValueError::new_err(what));
        }
        let normals = corners::<3>(normals, "normals", &triangles, positions.len())?;
        let uv = corners::<2>(uv, "uv", &triangles, positions.len())?;
        let moved = moved.map(|moved| Floats::new(moved, "moved")?.rows_of::<3>(positions.len())).transpose()?;
        let surface = position(self.lock().scene.surfaces.len(), surface, "surface")?;
        let mesh = Mesh {
            name: if name.is_empty() { "mesh" } else { name }.to_owned(),
            positions,
            moved: moved.map(|moved| moved.into_iter().map(Vec3::from).collect()),
            triangles,
            normals: normals.map(|all| all.into_iter().map(|n| n.map(Vec3::from)).collect()),
            uv: uv.map(|all| all.into_iter().map(|uv| uv.map(Vec2::from)).collect()),
            surface,
        };
        mesh.validate().map_err(value)?;
        let mut state = self.lock();
        let scene = state.change();
        match prototype {
            None => scene.meshes.push(mesh),
            Some(i) => {
                let i = position(scene.prototypes.len(), i, "prototype")?;
                scene.prototypes[i].meshes.push(mesh);
            }
        }
        Ok(())
    }

    /// Adds an empty prototype and returns its index. Only its instances are seen. `name`: for messages.
    #[pyo3(signature = (name=""))]
    fn add_prototype(&self, name: &str) -> usize {
        let mut state = self.lock();
        let prototypes = &mut state.change().prototypes;
        let name = if name.is_empty() { format!("prototype {}", prototypes.len()) } else { name.to_owned() };
        prototypes.push(Prototype { name, ..Prototype::default() });
        prototypes.len() - 1
    }

    /// Adds an instance of a prototype. All instances share its memory.
    ///
    /// `prototype`: from `add_prototype`. `matrix`: (4, 4), to world space, for column vectors; it must only rotate,
    /// mirror, move and scale uniformly.
    fn add_instance(&self, prototype: i128, matrix: &Bound<'_, PyAny>) -> PyResult<()> {
        let to_world = Floats::new(matrix, "matrix")?.matrix()?;
        let mut state = self.lock();
        let prototype = position(state.scene.prototypes.len(), prototype, "prototype")?;
        let instance = Instance::new(prototype, to_world);
        if instance.scale().is_none() {
            return Err(PyValueError::new_err("matrix must only rotate, mirror, move and scale uniformly"));
        }
        state.change().instances.push(instance);
        Ok(())
    }

    /// What the camera sees where there is no object: linear RGB, or `None` for the domes and distant lights.
    #[getter]
    fn background(&self) -> Option<[f32; 3]> {
        self.lock().scene.background.map(|tint| tint.color)
    }

    #[setter]
    fn set_background(&self, color: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let color = color.map(|color| Floats::new(color, "background")?.color()).transpose()?;
        color.iter().flatten().try_for_each(|x| within("background", (*x).into(), 0.0..=1.0))?;
        self.lock().change().background = color.map(|color| Tint { color, texture: None });
        Ok(())
    }

    fn __repr__(&self) -> String {
        let state = self.lock();
        let scene = &state.scene;
        let strands: usize = scene.strands.iter().map(Strands::len).sum();
        let (meshes, lights, instances) = (scene.meshes.len(), scene.lights.len(), scene.instances.len());
        format!("<vellus.Scene: {strands} strands, {meshes} meshes, {instances} instances, {lights} lights>")
    }
}
