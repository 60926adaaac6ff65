//! Writes scenes as Alembic archives: strands, meshes, instances and the camera.

use super::shape;
use crate::Error;
use glam::{Mat4, Vec3};
use std::collections::HashMap;
use std::io::{self, Seek, Write};
use std::path::Path;
use vellus::Parameter;
use vellus_alembic::{
    Attribute, Camera, CurveBasis, CurveType, Curves, Geometry, Mesh, ObjectId, Op, Owner, Pod, Scope, TimeSampling,
    Values, Writer, Xform,
};
use vellus_scene::{self as scene, Basis, Custom, CustomValues, Per, Scene, Strands};

/// Frames per second of the times that are written.
const FRAMES_PER_SECOND: f64 = 24.0;

/// The focal length of cameras, in millimetres.
const FOCAL_LENGTH: f64 = 50.0;

/// Names and types of attributes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Flavor {
    /// As this crate reads them: the names of the groom specification, on the objects of the scene.
    #[default]
    Plain,
    /// Unreal's groom specification 1.5: its version on an object above all others, groups and ids for each strand, and
    /// no meshes and no camera.
    Unreal,
}

/// Writes a scene. Motion is from frame 0 to 1, which is also the shutter of the camera.
///
/// # Errors
/// [`Error::Write`] if the file cannot be written.
pub(crate) fn write(scene: &Scene, path: &Path, flavor: Flavor) -> Result<(), Error> {
    let written = vellus_io::write_with(path, |out| {
        // The container needs the position of its root at the beginning of the file.
        let mut bytes = io::Cursor::new(Vec::new());
        archive(scene, flavor, &mut bytes)?;
        out.write_all(bytes.get_ref())
    });
    written.map_err(|source| Error::Write { path: path.to_owned(), source })
}

fn archive<W: Write + Seek>(scene: &Scene, flavor: Flavor, out: W) -> io::Result<()> {
    let mut writer = Writer::new(out)?;
    let times = writer.times(&TimeSampling::Uniform { start: 0.0, step: 1.0 / FRAMES_PER_SECOND });
    let top = match flavor {
        Flavor::Plain => Writer::<W>::ROOT,
        Flavor::Unreal => {
            let mut groom = Geometry::xform(&mut writer, Writer::<W>::ROOT, "groom", 0)?;
            groom.add_xform(&mut writer, &Xform { inherits: true, ops: Vec::new() })?;
            for (name, number) in [("groom_version_major", 1), ("groom_version_minor", 5)] {
                let version = attribute(name, Scope::Constant, 1, Pod::I16, Values::Whole(vec![number]));
                groom.user_property(&mut writer, &version)?;
            }
            let tool = Values::Text(vec![format!("Vellus {}", env!("CARGO_PKG_VERSION"))]);
            groom.user_property(&mut writer, &attribute("groom_tool", Scope::Constant, 1, Pod::Text, tool))?;
            groom.object
        }
    };
    let mut file = File { writer, times, flavor, folders: HashMap::from([(String::new(), top)]), used: HashMap::new() };
    for (group, strands) in scene.strands.iter().enumerate() {
        let custom: Vec<&Custom> = scene.custom.iter().filter(|custom| custom.strands == group).collect();
        file.strands(top, strands, &custom, group)?;
    }
    if flavor == Flavor::Plain {
        scene.meshes.iter().try_for_each(|mesh| file.mesh(top, mesh))?;
        if let Some(camera) = &scene.camera {
            file.camera(camera)?;
        }
    }
    file.instances(scene)?;
    let rate = FRAMES_PER_SECOND.to_string();
    let application = format!("Vellus {}", env!("CARGO_PKG_VERSION"));
    file.writer.finish(&[("_ai_Application", &application), ("FramesPerTimeUnit", &rate)])?;
    Ok(())
}

struct File<W> {
    writer: Writer<W>,
    /// The times of what moves.
    times: u32,
    flavor: Flavor,
    /// The objects above others, by their paths.
    folders: HashMap<String, ObjectId>,
    /// The names below each object.
    used: HashMap<(usize, String), usize>,
}

fn attribute(name: &str, scope: Scope, lanes: usize, pod: Pod, values: Values) -> Attribute {
    Attribute { name: name.to_owned(), scope, lanes, pod, interpretation: String::new(), values, indices: None }
}

/// An attribute that a reader kept. `rows` are those of the points of the file.
fn kept(custom: &Custom, rows: &[usize]) -> Attribute {
    let (scope, custom) = match custom.per {
        Per::Set => (Scope::Constant, (*custom).clone()),
        Per::Strand => (Scope::Uniform, (*custom).clone()),
        Per::Point => (Scope::Vertex, custom.with_rows(rows)),
    };
    let (pod, values) = match custom.values {
        CustomValues::F32(values) => (Pod::F32, Values::Single(values)),
        CustomValues::F64(values) => (Pod::F64, Values::Double(values)),
        CustomValues::I32(values) => (Pod::I32, Values::Whole(values.into_iter().map(i64::from).collect())),
        CustomValues::Text(values) => (Pod::Text, Values::Text(values)),
    };
    attribute(&custom.name, scope, custom.lanes, pod, values)
}

fn matrix(of: Mat4) -> Xform {
    // A point is a row on the left.
    Xform { inherits: true, ops: vec![Op::Matrix(of.to_cols_array_2d().map(|column| column.map(f64::from)))] }
}

impl<W: Write> File<W> {
    /// The object in which something with a name is written, and a name that is not used there. The parts of a path
    /// are objects inside each other.
    fn place(&mut self, top: ObjectId, name: &str) -> io::Result<(ObjectId, String)> {
        let parts: Vec<&str> = name.split('/').filter(|part| !part.is_empty()).collect();
        let (last, above) = parts.split_last().map_or(("strands", &[][..]), |(last, above)| (*last, above));
        let (mut parent, mut path) = (top, format!("{top:?}"));
        for part in above {
            path = format!("{path}/{part}");
            parent = match self.folders.get(&path) {
                Some(&known) => known,
                None => {
                    let name = self.unused(parent, part);
                    let mut folder = Geometry::xform(&mut self.writer, parent, &name, 0)?;
                    folder.add_xform(&mut self.writer, &Xform { inherits: true, ops: Vec::new() })?;
                    self.folders.insert(path.clone(), folder.object);
                    folder.object
                }
            };
        }
        let name = self.unused(parent, last);
        Ok((parent, name))
    }

    fn unused(&mut self, parent: ObjectId, name: &str) -> String {
        let mut free = name.to_owned();
        loop {
            let count = self.used.entry((parent.index(), free.clone())).or_insert(0);
            *count += 1;
            if *count == 1 {
                return free;
            }
            free = format!("{name}_{count}");
        }
    }

    fn strands(&mut self, top: ObjectId, strands: &Strands, custom: &[&Custom], group: usize) -> io::Result<()> {
        let (parent, name) = self.place(top, &strands.name)?;
        let authored = shape::authored(strands);
        let counts: Vec<u32> = authored.strands.starts.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let of_points = |values: Vec<f32>, name: &str, lanes| {
            attribute(name, Scope::Vertex, lanes, Pod::F32, Values::Single(values))
        };
        let widths: Vec<f32> = authored.strands.points.iter().map(|p| 2.0 * p.w).collect();
        let is_constant = widths.iter().all(|width| *width == widths[0]);
        let widths = match is_constant {
            true => attribute("width", Scope::Constant, 1, Pod::F32, Values::Single(widths[..1].to_vec())),
            false => of_points(widths, "width", 1),
        };
        let mut attributes = Vec::new();
        if let Some(uv) = &strands.root_uv {
            let values = Values::Single(uv.iter().flat_map(|uv| uv.to_array()).collect());
            let uv = attribute("groom_root_uv", Scope::Uniform, 2, Pod::F32, values);
            attributes.push(Attribute { interpretation: "vector".to_owned(), ..uv });
        }
        for (parameter, values) in &authored.strands.varying {
            let name = match parameter {
                Parameter::Reflectance => "groom_color".to_owned(),
                other => format!("vellus:{}", other.name()),
            };
            let lanes = parameter.channels();
            let unit = parameter.unit();
            let flat = |rows: &[[f32; 3]]| -> Vec<f32> {
                rows.iter().flat_map(|row| row[..lanes].iter().map(|x| unit.from_stored(*x))).collect()
            };
            let (scope, values) = match values {
                scene::Values::Constant(value) => (Scope::Constant, flat(&[*value])),
                scene::Values::PerStrand(values) => (Scope::Uniform, flat(values)),
                scene::Values::PerPoint(values) => (Scope::Vertex, flat(values)),
            };
            let found = attribute(&name, scope, lanes, Pod::F32, Values::Single(values));
            let interpretation = if lanes == 3 { "rgb" } else { "" };
            attributes.push(Attribute { interpretation: interpretation.to_owned(), ..found });
        }
        if self.flavor == Flavor::Unreal {
            let all = |name: &str, value: &dyn Fn(usize) -> i64| {
                let values = Values::Whole((0..strands.len()).map(value).collect());
                attribute(name, Scope::Uniform, 1, Pod::I32, values)
            };
            attributes.push(all("groom_group_id", &|_| group as i64));
            attributes.push(all("groom_id", &|strand| strand as i64));
            attributes.push(all("groom_guide", &|_| 0));
        }
        for custom in custom {
            // Points of other curves have no values.
            let fits = custom.per != Per::Point || authored.rows.len() == authored.strands.points.len();
            if fits && attributes.iter().all(|known| known.name != custom.name) && !custom.name.contains('/') {
                attributes.push(kept(custom, &authored.rows));
            }
        }
        let (kind, basis) = match authored.strands.basis {
            Basis::Linear => (CurveType::Linear, CurveBasis::None),
            Basis::Bezier => (CurveType::Cubic, CurveBasis::Bezier),
            Basis::BSpline => (CurveType::Cubic, CurveBasis::BSpline),
            Basis::CatmullRom => (CurveType::Cubic, CurveBasis::CatmullRom),
        };
        let open: Vec<Vec3> = authored.strands.points.iter().map(|p| p.truncate()).collect();
        let normals = authored.strands.normals.as_ref().map(|all| {
            let values = of_points(all.iter().flat_map(|n| n.to_array()).collect(), "N", 3);
            Attribute { interpretation: "normal".to_owned(), ..values }
        });
        let times = if authored.strands.moved.is_some() { self.times } else { 0 };
        let mut curves = Geometry::curves(&mut self.writer, parent, &name, times)?;
        for positions in [Some(open), authored.strands.moved].into_iter().flatten() {
            let sample = Curves {
                kind,
                periodic: false,
                basis,
                counts: counts.clone(),
                positions: positions.into_iter().map(|p| p.to_array()).collect(),
                weights: None,
                velocities: None,
                orders: Vec::new(),
                knots: Vec::new(),
                widths: Some(widths.clone()),
                uv: None,
                normals: normals.clone(),
            };
            curves.add_curves(&mut self.writer, &sample, &attributes)?;
        }
        Ok(())
    }

    fn mesh(&mut self, top: ObjectId, mesh: &scene::Mesh) -> io::Result<()> {
        let (parent, name) = self.place(top, &mesh.name)?;
        // Corners of Alembic are clockwise.
        let turned = |[a, b, c]: [u32; 3]| [a, c, b];
        let by_corner = |name: &str, lanes, values: Vec<f32>, interpretation: &str| {
            let found = attribute(name, Scope::FaceVarying, lanes, Pod::F32, Values::Single(values));
            Attribute { interpretation: interpretation.to_owned(), ..found }
        };
        let uv = mesh.uv.as_ref().map(|uv| {
            let values = uv.iter().flat_map(|[a, b, c]| [a, c, b].map(|uv| uv.to_array())).flatten().collect();
            by_corner("uv", 2, values, "vector")
        });
        let normals = mesh.normals.as_ref().map(|normals| {
            let values = normals.iter().flat_map(|[a, b, c]| [a, c, b].map(|n| n.to_array())).flatten().collect();
            by_corner("N", 3, values, "normal")
        });
        let times = if mesh.moved.is_some() { self.times } else { 0 };
        let mut polygons = Geometry::polygons(&mut self.writer, parent, &name, times)?;
        for positions in [Some(&mesh.positions), mesh.moved.as_ref()].into_iter().flatten() {
            let sample = Mesh {
                scheme: None,
                positions: positions.iter().map(|p| p.to_array()).collect(),
                counts: vec![3; mesh.triangles.len()],
                indices: mesh.triangles.iter().flat_map(|corners| turned(*corners)).collect(),
                velocities: None,
                uv: uv.clone(),
                normals: normals.clone(),
            };
            polygons.add_mesh(&mut self.writer, &sample, &[])?;
        }
        Ok(())
    }

    fn camera(&mut self, camera: &scene::Camera) -> io::Result<()> {
        let times = if camera.moved.is_some() { self.times } else { 0 };
        let name = self.unused(Writer::<W>::ROOT, "camera");
        let mut place = Geometry::xform(&mut self.writer, Writer::<W>::ROOT, &name, times)?;
        for to_world in [Some(camera.to_world), camera.moved].into_iter().flatten() {
            place.add_xform(&mut self.writer, &matrix(to_world))?;
        }
        // Focal lengths are in millimetres, films in centimetres.
        let film = |share: f32| f64::from(share) * FOCAL_LENGTH / 10.0;
        let mut shape = Geometry::camera(&mut self.writer, place.object, "shape", 0)?;
        let shutter = if camera.moved.is_some() { 1.0 / FRAMES_PER_SECOND } else { 0.0 };
        let sample = Camera {
            focal_length: FOCAL_LENGTH,
            horizontal_aperture: film(camera.film_width),
            horizontal_film_offset: film(camera.shift[0]),
            vertical_aperture: film(camera.film_height),
            vertical_film_offset: film(camera.shift[1]),
            lens_squeeze_ratio: 1.0,
            overscan: [0.0; 4],
            f_stop: 5.6,
            focus_distance: f64::from(camera.focus_distance),
            shutter: [0.0, shutter],
            clipping: [0.1, 1e5],
        };
        shape.add_camera(&mut self.writer, &sample)
    }

    /// Writes each prototype below its first instance; the others are instances of what is there.
    fn instances(&mut self, scene: &Scene) -> io::Result<()> {
        let top = self.folders[""];
        let mut known: HashMap<usize, (String, Vec<String>)> = HashMap::new();
        for instance in &scene.instances {
            let prototype = &scene.prototypes[instance.prototype];
            let base = prototype.name.rsplit('/').next().filter(|name| !name.is_empty()).unwrap_or("instance");
            let name = self.unused(top, base);
            let mut place = Geometry::xform(&mut self.writer, top, &name, 0)?;
            place.add_xform(&mut self.writer, &matrix(instance.to_world))?;
            if let Some((first, parts)) = known.get(&instance.prototype) {
                for part in parts {
                    let above = if self.flavor == Flavor::Unreal { "/groom" } else { "" };
                    let source = format!("{above}/{first}/{part}");
                    let object = self.writer.object(place.object, part, &[("isInstance", "1")])?;
                    let form = vellus_alembic::Form::scalar(Pod::Text, 1, 0);
                    let property = self.writer.property(Owner::Object(object), ".instanceSource", &[], form)?;
                    self.writer.sample_text(property, &[&source])?;
                }
                continue;
            }
            let mut parts = Vec::new();
            for (i, strands) in prototype.strands.iter().enumerate() {
                let own = Strands { name: format!("strands_{i}"), ..strands.clone() };
                self.strands(place.object, &own, &[], i)?;
                parts.push(own.name);
            }
            let meshes = if self.flavor == Flavor::Plain { &prototype.meshes[..] } else { &[] };
            for (i, mesh) in meshes.iter().enumerate() {
                let own = scene::Mesh { name: format!("mesh_{i}"), ..mesh.clone() };
                self.mesh(place.object, &own)?;
                parts.push(own.name);
            }
            known.insert(instance.prototype, (name, parts));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Options, open};
    use glam::{Vec2, Vec4};
    use vellus_scene::{Instance, Look, Prototype};

    fn strands(name: &str, basis: Basis, counts: &[usize]) -> Strands {
        let mut points: Vec<Vec4> = Vec::new();
        let mut starts = vec![0];
        let spline = matches!(basis, Basis::BSpline | Basis::CatmullRom);
        for (strand, count) in counts.iter().enumerate() {
            let at = |i: usize| {
                let t = i as f32;
                Vec4::new(strand as f32 + 0.125 * t, (0.7 * t).sin(), 0.25 * t * t, 0.01 + 0.002 * t)
            };
            let own: Vec<Vec4> = (0..*count).map(at).collect();
            let beyond = |end: Vec4, next: Vec4| 2.0 * end - next;
            points.extend(spline.then(|| beyond(own[0], own[1])));
            points.extend(&own);
            points.extend(spline.then(|| beyond(own[count - 1], own[count - 2])));
            starts.push(points.len() as u32);
        }
        let total = points.len();
        let shade = |i: usize| [0.5, 0.25, 0.125 + 0.001 * i as f32];
        Strands {
            name: name.to_owned(),
            basis,
            starts,
            // Exact in single precision, also beyond the ends.
            moved: Some(points.iter().map(|p| p.truncate() + Vec3::new(0.5, 0.0, 0.0)).collect()),
            points,
            normals: Some(vec![Vec3::Z; total]),
            root_uv: Some((0..counts.len()).map(|i| Vec2::new(0.1 * i as f32, 0.7)).collect()),
            look: 0,
            varying: vec![
                (Parameter::Reflectance, scene::Values::PerPoint((0..total).map(shade).collect())),
                (
                    Parameter::BetaM,
                    scene::Values::PerStrand((0..counts.len()).map(|i| [0.1 + 0.1 * i as f32; 3]).collect()),
                ),
                (Parameter::Kappa, scene::Values::Constant([0.5; 3])),
            ],
        }
    }

    fn reopened(scene: &Scene, flavor: Flavor) -> Scene {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.abc");
        write(scene, &path, flavor).unwrap();
        let options = Options { shutter: Some([0.0, 1.0]), strict: true, ..Options::default() };
        open(&path, &options).unwrap().scene
    }

    /// Positions, widths, uv, colours, parameters and motion, for each basis. Angles are in degrees in the file.
    #[test]
    fn strands_meshes_and_the_camera_are_read_as_written() {
        for basis in [Basis::Linear, Basis::Bezier, Basis::BSpline, Basis::CatmullRom] {
            let strands = strands("/fox/coat", basis, &[4, 7]);
            let mesh = scene::Mesh {
                name: "/fox/skin".to_owned(),
                positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
                moved: Some(vec![Vec3::Z, Vec3::X, Vec3::Y]),
                triangles: vec![[0, 1, 2]],
                normals: Some(vec![[Vec3::Z, Vec3::Z, Vec3::X]]),
                uv: Some(vec![[Vec2::ZERO, Vec2::X, Vec2::Y]]),
                surface: 0,
            };
            let camera = scene::Camera {
                shift: [0.125, -0.25],
                ..scene::Camera::look_at(Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO, Vec3::Y, 0.5, 1.5)
            };
            let scene = Scene {
                strands: vec![strands.clone(), strands.clone()],
                meshes: vec![mesh.clone()],
                surfaces: vec![scene::Surface::diffuse("skin", [0.5; 3])],
                looks: vec![Look::constant("fox", vellus::Fiber::hair())],
                camera: Some(camera),
                ..Scene::default()
            };
            let found = reopened(&scene, Flavor::Plain);
            let [first, second] = &found.strands[..] else { panic!("{basis:?}: {} sets", found.strands.len()) };
            assert_eq!((first.name.as_str(), second.name.as_str()), ("/fox/coat", "/fox/coat_2"));
            assert_eq!((first.basis, &first.starts, &first.points), (basis, &strands.starts, &strands.points));
            assert_eq!((&first.moved, &first.root_uv), (&strands.moved, &strands.root_uv));
            assert_eq!(first.normals, strands.normals, "{basis:?}");
            for ((parameter, a), (expected, b)) in first.varying.iter().zip(&strands.varying) {
                let flat = |values: &scene::Values<[f32; 3]>| match values {
                    scene::Values::Constant(value) => vec![*value],
                    scene::Values::PerStrand(all) | scene::Values::PerPoint(all) => all.clone(),
                };
                assert_eq!((parameter, flat(a).len()), (expected, flat(b).len()));
                let near = |(a, b): (&f32, &f32)| (a - b).abs() <= 2e-7;
                assert!(flat(a).as_flattened().iter().zip(flat(b).as_flattened()).all(near), "{basis:?} {parameter:?}");
            }
            assert_eq!(found.meshes, [scene::Mesh { surface: found.meshes[0].surface, ..mesh }]);
            let seen = found.camera.unwrap();
            let near = |a: f32, b: f32| (a - b).abs() < 1e-6;
            assert!(near(seen.film_width, camera.film_width) && near(seen.film_height, camera.film_height));
            assert!((0..2).all(|k| near(seen.shift[k], camera.shift[k])));
            assert!(seen.to_world.abs_diff_eq(camera.to_world, 1e-6));
        }
    }

    /// Attributes that rendering does not use, of each type and for each of what has values: from USD to an archive, to
    /// another archive, and back to USD, everything is bit-equal. A warning names them where they are not kept.
    #[test]
    fn conversions_keep_every_attribute() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let basis = |kind: &str| match kind {
            "linear" => "uniform token type = \"linear\"",
            "bspline" => "uniform token basis = \"bspline\" uniform token wrap = \"pinned\"",
            _ => "uniform token basis = \"catmullRom\" uniform token wrap = \"pinned\"",
        };
        for kind in ["linear", "bspline", "catmullRom"] {
            let text = format!(
                "#usda 1.0
def BasisCurves \"coat\" {{ {} int[] curveVertexCounts = [4, 4]
    point3f[] points = [(0,0,0), (0,1,.1), (0,2,.3), (.1,3,.7), (1,0,0), (1,1,.1), (1,2,.3), (1.1,3,.7)]
    float[] widths = [.1, .09, .05, .01, .2, .15, .1, .02] (interpolation = \"vertex\")
    texCoord2f[] primvars:st = [(.1, .2), (.3, .4)] (interpolation = \"uniform\")
    int[] primvars:clump = [7, -1] (interpolation = \"uniform\")
    string[] primvars:name = [\"left \\\"a\\\"\", \"right\"] (interpolation = \"uniform\")
    double2[] primvars:precise = [(.1, .2), (.3, .4)] (interpolation = \"uniform\")
    float3[] primvars:rest = [(0,0,.7), (0,1,0), (0,2,0), (0,3,0), (1,0,0), (1,1,0)] (interpolation = \"vertex\")
    int[] primvars:rest:indices = [0, 1, 2, 3, 4, 5, 5, 5]
    float primvars:amount = 0.3
}}",
                basis(kind)
            );
            std::fs::write(at("a.usda"), text).unwrap();
            let keep = Options { custom: true, strict: true, ..Options::default() };
            let first = open(at("a.usda"), &keep).unwrap().scene;
            let names: Vec<&str> = first.custom.iter().map(|custom| custom.name.as_str()).collect();
            assert_eq!(names, ["clump", "name", "precise", "rest", "amount"]);
            write(&first, &at("b.abc"), Flavor::Plain).unwrap();
            let second = open(at("b.abc"), &keep).unwrap().scene;
            write(&second, &at("c.abc"), Flavor::Plain).unwrap();
            let third = open(at("c.abc"), &keep).unwrap().scene;
            vellus_usd::write(&third, &at("d.usdc")).unwrap();
            let last = open(at("d.usdc"), &keep).unwrap().scene;
            for scene in [&second, &third, &last] {
                let sorted = |scene: &Scene| {
                    let mut all = scene.custom.clone();
                    all.sort_by(|a, b| a.name.cmp(&b.name));
                    all
                };
                assert_eq!(sorted(scene), sorted(&first), "{kind}");
                let geometry = |scene: &Scene| {
                    let Strands { basis, starts, points, root_uv, .. } = scene.strands[0].clone();
                    (basis, starts, points, root_uv)
                };
                assert_eq!(geometry(scene), geometry(&first), "{kind}");
            }
            let bare = open(at("b.abc"), &Options::default()).unwrap();
            assert!(bare.scene.custom.is_empty());
            let said: Vec<String> = bare.warnings.iter().map(ToString::to_string).collect();
            assert!(said[0].contains("not used: amount, clump, precise, rest"), "{said:?}");
        }
    }

    /// A spline whose ends are anywhere becomes Bézier curves with the same course.
    #[test]
    fn splines_without_pinned_ends_keep_their_course() {
        for basis in [Basis::BSpline, Basis::CatmullRom] {
            let mut all = strands("a", basis, &[5]);
            all.points[0].x += 1.0;
            all.moved = None;
            let scene = Scene {
                strands: vec![all.clone()],
                looks: vec![Look::constant("fox", vellus::Fiber::hair())],
                ..Scene::default()
            };
            let found = &reopened(&scene, Flavor::Plain).strands[0];
            assert_eq!(found.basis, Basis::Bezier);
            let flat = |strands: &Strands| vellus_groom::flatten(strands, 8).points;
            let (a, b) = (flat(found), flat(&all));
            assert_eq!(a.len(), b.len());
            assert!(a.iter().zip(b).all(|(a, b)| a.abs_diff_eq(b, 1e-5)), "{basis:?}");
        }
    }

    #[test]
    fn instances_are_where_they_were() {
        let prototype = Prototype {
            name: "tuft".to_owned(),
            strands: vec![Strands { moved: None, ..strands("s", Basis::Linear, &[2]) }],
            meshes: Vec::new(),
        };
        let places = [Vec3::ZERO, Vec3::new(5.0, 0.0, 1.0), Vec3::new(-3.0, 2.0, 0.0)];
        let scene = Scene {
            looks: vec![Look::constant("fox", vellus::Fiber::hair())],
            instances: places.map(|at| Instance::new(0, Mat4::from_translation(at))).to_vec(),
            prototypes: vec![prototype.clone()],
            ..Scene::default()
        };
        for flavor in [Flavor::Plain, Flavor::Unreal] {
            let found = reopened(&scene, flavor);
            let roots: Vec<Vec3> = found.strands.iter().map(|strands| strands.points[0].truncate()).collect();
            let root = prototype.strands[0].points[0].truncate();
            assert_eq!(roots, places.map(|at| at + root));
        }
    }

    /// The version is on the object above all others, and each strand has its group, its number, and is no guide.
    #[test]
    fn unreal_gets_its_groom_specification() {
        let scene = Scene {
            strands: vec![strands("a", Basis::Linear, &[2, 3]), strands("b", Basis::Linear, &[2])],
            looks: vec![Look::constant("fox", vellus::Fiber::hair())],
            ..Scene::default()
        };
        let mut bytes = io::Cursor::new(Vec::new());
        archive(&scene, Flavor::Unreal, &mut bytes).unwrap();
        let archive = vellus_alembic::Archive::open(bytes.into_inner()).unwrap();
        let object = |path: &str| &archive.objects[archive.find(path).unwrap()];
        let read = |property| vellus_alembic::Attribute::read(&archive, property, 0.0).unwrap();
        let user: Vec<_> = vellus_alembic::user_properties(object("/groom")).iter().map(read).collect();
        let version =
            |name: &str| user.iter().find(|found| found.name == name).map(|found| (found.pod, found.number(0, 0)));
        assert_eq!(version("groom_version_major"), Some((Pod::I16, Some(1.0))));
        assert_eq!(version("groom_version_minor"), Some((Pod::I16, Some(5.0))));
        let of = |path: &str, name: &str| {
            let all = vellus_alembic::attributes(object(path));
            let found = read(all.iter().find(|property| property.name == name).unwrap());
            (found.scope, found.pod, (0..found.rows()).map(|row| found.number(row, 0).unwrap()).collect::<Vec<_>>())
        };
        assert_eq!(of("/groom/a", "groom_id"), (Scope::Uniform, Pod::I32, vec![0.0, 1.0]));
        assert_eq!(of("/groom/b", "groom_group_id"), (Scope::Uniform, Pod::I32, vec![1.0]));
        assert_eq!(of("/groom/a", "groom_guide"), (Scope::Uniform, Pod::I32, vec![0.0, 0.0]));
        assert_eq!(of("/groom/a", "groom_root_uv").1, Pod::F32);
    }
}
