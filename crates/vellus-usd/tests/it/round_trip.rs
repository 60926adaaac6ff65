//! A written scene reads back unchanged, with our reader and with Pixar's library.

use crate::common::read;
use glam::{Mat3, Mat4, Quat, Vec2, Vec3, Vec4};
use std::f32::consts::PI;
use vellus::{Fiber, Species};
use vellus_scene::{
    Basis, Camera, Custom, CustomValues, Fit, Ground, Instance, Light, LightShape, Link, Look, Mesh, NormalMap,
    Objects, Opacity, Parameter, Per, Profile, Prototype, ReflectanceOf, Scene, Shaping, Strands, Surface, Texture,
    Tint, Units, Value, Values, Wrap,
};
use vellus_usd::{Format, Options, write, write_to};

/// Numbers without a pattern, the same in each run.
fn noise(i: usize) -> f32 {
    let x = (i as u32).wrapping_mul(2_654_435_761).rotate_left(13).wrapping_mul(0x9e37_79b9);
    (x >> 8) as f32 / (1 << 24) as f32
}

fn texture(name: &str, width: usize, height: usize) -> Texture {
    let pixels =
        (0..width * height).map(|i| [noise(3 * i), 40.0 * noise(3 * i + 1), 1e-3 * noise(3 * i + 2)]).collect();
    Texture { name: name.to_owned(), width, height, pixels, wrap: [Wrap::Mirror, Wrap::Clamp] }
}

fn strands(name: &str, basis: Basis, counts: &[u32], look: usize) -> Strands {
    let mut starts = vec![0];
    for count in counts {
        starts.push(starts.last().unwrap() + count);
    }
    let total = *starts.last().unwrap() as usize;
    let at = |i: usize| Vec3::new(noise(i) - 0.5, 30.0 * noise(i + 1), -1e-5 * noise(i + 2));
    let points = (0..total).map(|i| at(4 * i).extend(1e-3 * noise(4 * i + 3))).collect();
    Strands {
        name: name.to_owned(),
        basis,
        starts,
        points,
        moved: None,
        normals: None,
        root_uv: None,
        look,
        varying: Vec::new(),
    }
}

/// The index of the profile of a lamp, and its image.
const PROFILE: usize = 4;

fn lamp() -> Texture {
    let pixels = (0..721).map(|i| [30.0 * noise(i); 3]).collect();
    Texture { name: "lamp.ies".to_owned(), width: 1, height: 721, pixels, wrap: [Wrap::Repeat; 2] }
}

/// A scene with every feature, and no value at its default.
fn scene() -> Scene {
    let pose = |t: f32| Mat4::from_rotation_translation(Quat::from_rotation_y(t), Vec3::new(t, 2.0, -3.5));
    let mut fox = strands("fox fur 'é'", Basis::BSpline, &[4, 7, 5], 0);
    fox.moved = Some(fox.points.iter().enumerate().map(|(i, p)| p.truncate() + 0.1 * noise(i)).collect());
    fox.normals = Some((0..16).map(|i| [Vec3::X, Vec3::Y, Vec3::Z][i % 3]).collect());
    fox.root_uv = Some((0..3).map(|i| Vec2::new(noise(i), noise(i + 50))).collect());
    let per_point = (0..16).map(|i| [noise(i), noise(i + 1), noise(i + 2)]).collect();
    fox.varying = vec![
        (Parameter::BetaM, Values::PerStrand(vec![[0.1; 3], [0.2; 3], [0.33; 3]])),
        (Parameter::SigmaCa, Values::PerPoint(per_point)),
        (Parameter::G, Values::Constant([0.3; 3])),
        (Parameter::Melanin, Values::PerStrand((0..3).map(|i| [noise(i), noise(i + 9), 0.0]).collect())),
    ];
    let mut hare = strands("hare", Basis::Linear, &[2, 5], 1);
    hare.varying = vec![(Parameter::SigmaMs, Values::PerPoint((0..7).map(|i| [noise(i); 3]).collect()))];
    let textured = vec![
        (Parameter::BetaN, Value { texture: 0, scale: [0.25, 0.5, 0.75] }),
        (Parameter::Reflectance, Value { texture: 1, scale: [0.9, 0.8, 0.7] }),
    ];
    let fiber = Fiber { sigma_ma: [0.1, 0.2, 0.3], ..Fiber::preset(Species::RedFox) }.with_absorption([0.5, 0.6, 7.0]);
    let hair =
        Fiber { alpha: -0.05, layers: 1.5, aspect_ratio: 0.6, medulla_air: 0.5, ..Fiber::preset(Species::Human) };
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.125), Vec3::new(0.1, 1.0 / 3.0, 7e-9)];
    let triangles = vec![[0, 1, 2], [0, 2, 3]];
    let turned = Mat3::from_rotation_z(0.4) * Mat3::from_rotation_x(1.1);
    Scene {
        reflectance: ReflectanceOf::Groom,
        prototypes: vec![],
        instances: vec![],
        strands: vec![
            fox,
            hare,
            strands("hare", Basis::CatmullRom, &[6], 1),
            strands("/world/bezier", Basis::Bezier, &[4, 10], 0),
        ],
        meshes: vec![
            Mesh {
                name: "skin".to_owned(),
                normals: Some((0..2).map(|i| [Vec3::Z, Vec3::new(0.6, 0.0, 0.8), noise(i) * Vec3::Y]).collect()),
                uv: Some((0..2).map(|i| [Vec2::ZERO, Vec2::X, Vec2::new(noise(i), 3.0)]).collect()),
                moved: Some(positions.iter().enumerate().map(|(i, p)| p + 0.1 * noise(i)).collect()),
                positions: positions.clone(),
                triangles: triangles.clone(),
                surface: 0,
            },
            Mesh { name: "floor".to_owned(), normals: None, uv: None, positions, triangles, surface: 1, moved: None },
        ],
        looks: vec![Look { name: "fox".to_owned(), fiber, textured }, Look::constant("1 of those", hair)],
        surfaces: vec![
            Surface {
                name: "leather".to_owned(),
                color: Tint { color: [0.5, 0.25, 1.0 / 3.0], texture: Some(3) },
                emission: [0.0, 0.125, 3.0],
                roughness: 0.3,
                metallic: 0.7,
                ior: 1.4,
                opacity: Opacity { value: 0.75, texture: Some(5), threshold: 0.25 },
                normals: Some(NormalMap { texture: 6, scale: [1.5, -2.0, 2.0], bias: [-0.75, 1.0, -1.0] }),
                skin: true,
            },
            Surface::diffuse("chalk", [0.8, 0.7, 0.6]),
        ],
        // In the order in which they are read. Lights, meshes and strands are read in the order in which they are
        // written.
        textures: vec![
            texture("b.exr", 3, 2),
            texture("roots.exr", 1, 4),
            Texture { wrap: [Wrap::Repeat; 2], ..texture("sky.exr", 4, 2) },
            texture("leather.exr", 2, 2),
            lamp(),
            Texture { pixels: vec![[0.5; 3], [0.125; 3]].into(), ..texture("holes.exr", 2, 1) },
            texture("bumps.exr", 2, 2),
        ],
        lights: [
            LightShape::Dome {
                radiance: [0.5, 0.6, 0.7],
                texture: Some(2),
                rotation: turned,
                ground: Some(Ground { origin: Vec3::new(0.5, -0.25, 2.0), height: 1.5, radius: 30.0 }),
            },
            LightShape::Distant {
                direction: Vec3::new(0.48, 0.64, -0.6),
                half_angle: 0.05,
                irradiance: [3.0, 2.0, 1.0],
            },
            LightShape::Rect {
                to_world: pose(0.3) * Mat4::from_scale(Vec3::new(2.0, 0.5, 1.0)),
                radiance: [5.0; 3],
                texture: None,
            },
            LightShape::Disk { to_world: pose(0.7) * Mat4::from_scale(Vec3::splat(0.1)), radiance: [1.0, 0.0, 9.0] },
            LightShape::Sphere { center: Vec3::new(0.1, 0.2, 0.3), radius: 0.7, radiance: [0.1; 3] },
            LightShape::Cylinder {
                center: Vec3::new(-0.5, 0.25, 1.0),
                half_axis: Vec3::new(0.0, 0.0, 1.5),
                radius: 0.125,
                radiance: [1.0, 2.0, 3.0],
            },
            LightShape::Point { position: Vec3::new(1.0, 0.5, 0.25), intensity: [0.5, 1.0, 2.0] },
        ]
        .into_iter()
        .zip(["sky", "sun", "key", "key", "lamp-2", "tube", "spot"])
        .enumerate()
        .map(|(i, (shape, group))| Light {
            shape,
            group: Some(group.to_owned()),
            visible: ![0, 3].contains(&i),
            shaping: shaping(i),
            link: link(i),
        })
        .collect(),
        background: None,
        camera: Some(Camera {
            to_world: pose(0.2),
            moved: Some(pose(0.25)),
            film_width: 0.36,
            film_height: 0.24,
            shift: [0.0, -0.125],
            fit: Fit::Crop,
            lens_radius: 0.013,
            focus_distance: 4.3,
        }),
        units: Some(Units { meters_per_unit: 1.0 / 3.0, z_up: true }),
        custom: custom(),
    }
}

/// The shaping of a light of the scene.
fn shaping(light: usize) -> Option<Shaping> {
    let wide = Shaping { axis: Vec3::NEG_Y, cone: PI / 3.0, softness: 0.0, focus: 0.0, tint: [0.0; 3], profile: None };
    let profile = Some(Profile { texture: PROFILE, side: Vec3::X });
    match light {
        5 => Some(wide),
        6 => Some(Shaping { cone: PI / 6.0, softness: 0.25, focus: 2.0, tint: [0.5, 0.25, 0.0], profile, ..wide }),
        _ => None,
    }
}

/// The link of a light of the scene.
fn link(light: usize) -> Option<Link> {
    let skin = || Objects::Only(vec!["skin".into()]);
    match light {
        1 => Some(Link { lit: Objects::Except(vec!["/world/bezier".into(), "floor".into()]), ..Link::default() }),
        2 => Some(Link { casters: skin(), diffuse: 0.5, ..Link::default() }),
        4 => Some(Link { lit: skin(), casters: Objects::NONE, specular: 2.0, diffuse: 0.0 }),
        _ => None,
    }
}

/// Attributes of the first set of strands, of each type and for each of what may have values, and of the last one.
fn custom() -> Vec<Custom> {
    let one = |strands, name: &str, per, lanes, values| Custom { strands, name: name.to_owned(), per, lanes, values };
    let texts = ["", "a \"b\" \\\n", "é"].map(str::to_owned).to_vec();
    let mut all = vec![
        one(0, "clump:id", Per::Strand, 1, CustomValues::I32(vec![-7, 0, i32::MAX])),
        one(0, "maker", Per::Set, 1, CustomValues::Text(vec!["me".to_owned()])),
        one(0, "names", Per::Strand, 1, CustomValues::Text(texts)),
        one(0, "rest", Per::Point, 3, CustomValues::F32((0..48).map(noise).collect())),
        one(0, "weights", Per::Strand, 2, CustomValues::F64((0..6).map(|i| 0.1 * f64::from(i)).collect())),
    ];
    all.push(one(1, "age", Per::Point, 1, CustomValues::F32((0..7).map(noise).collect())));
    all
}

/// Reading collects textures in the order in which lights, meshes and strands use them. This function reorders them.
fn in_order_of_use(mut scene: Scene) -> Scene {
    let order = [2, PROFILE, 3, 5, 6, 0, 1];
    let new = |old: usize| order.iter().position(|&o| o == old).unwrap();
    scene.textures = order.iter().map(|&o| scene.textures[o].clone()).collect();
    for light in &mut scene.lights {
        if let LightShape::Dome { texture, .. } | LightShape::Rect { texture, .. } = &mut light.shape {
            *texture = texture.map(new);
        }
        if let Some(shaping) = &mut light.shaping {
            shaping.profile = shaping.profile.map(|profile| Profile { texture: new(profile.texture), ..profile });
        }
    }
    for surface in &mut scene.surfaces {
        surface.color.texture = surface.color.texture.map(new);
        surface.opacity.texture = surface.opacity.texture.map(new);
        surface.normals = surface.normals.map(|map| NormalMap { texture: new(map.texture), ..map });
    }
    scene.looks.iter_mut().flat_map(|l| &mut l.textured).for_each(|(_, value)| value.texture = new(value.texture));
    scene
}

/// Conversions of angles, and quotients, may change the last bit. If two numbers only differ in it, the second becomes
/// the first.
fn forgive(a: f32, b: &mut f32) {
    if (a - *b).abs() <= 1.5e-7 * a.abs() {
        *b = a;
    }
}

fn forgive_last_bits(expected: &Scene, found: &mut Scene) {
    for (a, b) in expected.looks.iter().zip(&mut found.looks) {
        forgive(a.fiber.alpha, &mut b.fiber.alpha);
        forgive(a.fiber.beta_m, &mut b.fiber.beta_m);
        forgive(a.fiber.beta_n, &mut b.fiber.beta_n);
        for ((_, a), (_, b)) in a.textured.iter().zip(&mut b.textured) {
            (0..3).for_each(|c| forgive(a.scale[c], &mut b.scale[c]));
        }
    }
    for (a, b) in expected.strands.iter().zip(&mut found.strands) {
        for ((parameter, a), (_, b)) in a.varying.iter().zip(&mut b.varying) {
            if let (true, Values::PerStrand(a), Values::PerStrand(b)) = (parameter.is_angle(), a, b) {
                a.iter().flatten().zip(b.iter_mut().flatten()).for_each(|(a, b)| forgive(*a, b));
            }
        }
    }
    for (a, b) in expected.lights.iter().zip(&mut found.lights) {
        if let (LightShape::Distant { half_angle: a, .. }, LightShape::Distant { half_angle: b, .. }) =
            (&a.shape, &mut b.shape)
        {
            forgive(*a, b);
        }
    }
    if let (Some(a), Some(b)) = (&expected.camera, &mut found.camera) {
        forgive(a.lens_radius, &mut b.lens_radius);
    }
}

#[test]
fn written_scenes_read_back_equal() {
    for name in ["all.usda", "all.usdc"] {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(name);
        let expected = in_order_of_use(scene());
        write(&expected, &file).unwrap();
        let options = Options { custom: true, ..Options::default() };
        let (mut found, warnings) = read(&file, &options).unwrap();
        // One of its looks has textures, and the strands have no texture coordinates.
        let said: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        assert!(
            said.len() == 1 && said[0].contains("bezier: its material has textures, but it has no primvars:st"),
            "{said:?}"
        );
        forgive_last_bits(&expected, &mut found);
        assert_eq!(found.strands, expected.strands);
        assert_eq!(found.looks, expected.looks);
        assert_eq!(found, expected);

        // Only the stage and its textures remain.
        let mut files: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|f| f.unwrap().file_name()).collect();
        files.sort();
        assert_eq!(files, ["all-textures", name]);
        // Half of the motion while the shutter is open.
        let (half, _) = read(&file, &Options { shutter: Some([0.0, 0.5]), ..Options::default() }).unwrap();
        let (a, b, c) = (&expected.strands[0], &half.strands[0], 5);
        let middle = 0.5 * (a.points[c].truncate() + a.moved.as_ref().unwrap()[c]);
        assert!(b.moved.as_ref().unwrap()[c].abs_diff_eq(middle, 1e-5));
        let closed = Options { frame: Some(1.0), shutter: Some([0.0; 2]), ..Options::default() };
        let (closed, _) = read(&file, &closed).unwrap();
        assert_eq!(closed.strands[0].points[c].truncate(), a.moved.as_ref().unwrap()[c]);
        assert!(closed.strands.iter().all(|s| s.moved.is_none()) && closed.camera.unwrap().moved.is_none());
    }
}

/// Arrays that crate files compress, or do not: whole numbers, few and many different numbers, few and no elements.
fn compressible() -> Scene {
    let plain = strands("plain", Basis::Linear, &[2; 40], 0);
    let with = |name: &str, radius: &dyn Fn(usize) -> f32| {
        let points = plain.points.iter().enumerate().map(|(i, p)| p.truncate().extend(radius(i))).collect();
        Strands { name: name.to_owned(), points, ..plain.clone() }
    };
    let all = vec![
        with("whole", &|i| (i % 3) as f32),
        with("few", &|i| [0.1, 0.2, 1e-30][i % 3]),
        with("most", &|i| 0.1 + (i % 20) as f32),
        with("many", &|i| 0.1 + (i % 21) as f32),
        strands("uneven", Basis::Linear, &[2, 2, 2, 200, 2, 40_000, 2, 2, 90_000, 2, 2, 2, 3, 2, 2, 2, 2], 0),
        strands("empty", Basis::Linear, &[], 0),
    ];
    Scene { strands: all, looks: vec![Look::constant("fox", Fiber::preset(Species::RedFox))], ..Scene::default() }
}

#[test]
fn compressed_arrays_read_back_to_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let expected = compressible();
    let [text, binary] = ["a.usda", "a.usdc"].map(|name| folder.path().join(name));
    write(&expected, &text).unwrap();
    write(&expected, &binary).unwrap();
    let found = read(&binary, &Options::default()).unwrap();
    assert_eq!(found, read(&text, &Options::default()).unwrap());
    for found in &found.0.strands {
        let expected = expected.strands.iter().find(|one| one.name == found.name).unwrap();
        let bits = |s: &Strands| s.points.iter().map(|p| p.to_array().map(f32::to_bits)).collect::<Vec<_>>();
        assert!(bits(found) == bits(expected) && found.starts == expected.starts, "{}", found.name);
    }
    assert_eq!(found.0.strands.len(), 5);
    assert!(std::fs::metadata(&binary).unwrap().len() < std::fs::metadata(&text).unwrap().len() / 2);
}

/// Three instances of a prototype, strands with the name of a prim that every stage has, and a light that lights only
/// the instances.
fn herd() -> Scene {
    let fur = strands("fur", Basis::Linear, &[3, 4], 0);
    let lit = Objects::Only(vec!["fur".into()]);
    let at = |i: usize| Mat4::from_translation(i as f32 * Vec3::X);
    Scene {
        prototypes: vec![Prototype { name: "fox".to_owned(), strands: vec![fur], meshes: vec![] }],
        instances: (0..3).map(|i| Instance::new(0, at(i))).collect(),
        strands: ["Looks", "lone"].map(|name| strands(name, Basis::Linear, &[2], 0)).to_vec(),
        looks: vec![Look::constant("fox", Fiber::preset(Species::RedFox))],
        lights: vec![Light {
            link: Some(Link { lit, ..Link::default() }),
            ..LightShape::Point { position: Vec3::Y, intensity: [1.0; 3] }.into()
        }],
        ..Scene::default()
    }
}

#[test]
fn instances_read_back_from_both_formats() {
    let scene = herd();
    let folder = tempfile::tempdir().unwrap();
    for name in ["herd.usda", "herd.usdc"] {
        let file = folder.path().join(name);
        write(&scene, &file).unwrap();
        let (found, warnings) = read(&file, &Options { instances: true, ..Options::default() }).unwrap();
        assert_eq!(warnings, []);
        assert_eq!(
            (found.instances, &found.prototypes[0].strands),
            (scene.instances.clone(), &scene.prototypes[0].strands)
        );
        assert_eq!((found.strands, &found.lights[0].link), (scene.strands.clone(), &scene.lights[0].link));
    }
}

#[test]
fn a_stage_is_the_same_in_a_file_and_in_a_stream() {
    let folder = tempfile::tempdir().unwrap();
    for (name, format) in [("a.usda", Format::Text), ("a.usdc", Format::Crate)] {
        let file = folder.path().join(name);
        write(&compressible(), &file).unwrap();
        let mut stream = Vec::new();
        write_to(&compressible(), format, &mut stream).unwrap();
        assert!(std::fs::read(&file).unwrap() == stream);
        assert_eq!(Format::of(&file), Some(format));
    }
}

#[test]
fn a_failed_write_is_an_error_and_keeps_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("old.usda");
    std::fs::write(&file, "old").unwrap();
    let mut broken = scene();
    broken.strands[0].points[1] = Vec4::NAN;
    assert!(write(&broken, &file).unwrap_err().to_string().contains("must be finite"));
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "old");
    assert!(write(&scene(), &folder.path().join("a.usd")).unwrap_err().to_string().contains(".usda or .usdc"));
    let nowhere = folder.path().join("old.usda/a.usda");
    let error = write(&Scene { textures: Vec::new(), ..Scene::default() }, &nowhere).unwrap_err().to_string();
    assert!(error.contains("old.usda/a.usda"), "{error}");
}

/// Pixar's parser is stricter than ours.
#[test]
fn usd_core_opens_what_we_wrote() {
    const CHECK: &str = "
import sys
from pxr import Usd, UsdGeom, UsdShade, UsdLux, UsdUtils, Tf
stage = Usd.Stage.Open(sys.argv[1])
assert not stage.GetCompositionErrors(), stage.GetCompositionErrors()
kinds = [p.GetTypeName() for p in stage.Traverse()]
for p in stage.Traverse():
    assert p.IsA(Usd.Typed) and p.GetPrimTypeInfo().GetSchemaType() != Tf.Type.Unknown, p
    for a in p.GetAttributes():
        a.Get(0)
        for c in a.GetConnections(): assert stage.GetPropertyAtPath(c), (a, c)
        if a.GetTypeName() == 'asset' and a.Get(): assert a.Get().resolvedPath, a
    for r in p.GetRelationships():
        for t in r.GetTargets(): assert stage.GetPrimAtPath(t), (r, t)
    if p.IsA(UsdGeom.PointBased):
        assert UsdShade.MaterialBindingAPI(p).ComputeBoundMaterial()[0], p
    if p.IsA(UsdGeom.BasisCurves):
        c = UsdGeom.BasisCurves(p)
        n = c.GetCurveVertexCountsAttr().Get()
        assert sum(n) == len(c.GetPointsAttr().Get(0)) == len(c.GetWidthsAttr().Get())
        assert c.GetWidthsInterpolation() == 'vertex'
        for v in UsdGeom.PrimvarsAPI(p).GetPrimvarsWithAuthoredValues():
            size = {'constant': 1, 'uniform': len(n), 'vertex': sum(n)}[v.GetInterpolation()]
            assert v.Get() is not None and len(v.Get()) == size, (v.GetName(), v.Get())
    if p.IsA(UsdGeom.Mesh):
        m = UsdGeom.Mesh(p)
        indices, counts = m.GetFaceVertexIndicesAttr().Get(), m.GetFaceVertexCountsAttr().Get()
        ok, why = UsdGeom.Mesh.ValidateTopology(indices, counts, len(m.GetPointsAttr().Get(0)))
        assert ok, why
print(','.join(sorted(kinds)))
stage.Export(sys.argv[2])
assert UsdUtils.CreateNewUsdzPackage(sys.argv[1], sys.argv[3])
";
    let folder = tempfile::tempdir().unwrap();
    for name in ["all.usda", "all.usdc"] {
        let Some(mut python) = crate::common::pixar() else { return };
        let file = folder.path().join(name);
        write(&scene(), &file).unwrap();
        let [binary, package] = ["copy.usdc", "copy.usdz"].map(|name| folder.path().join(name));
        let run = python.arg("-c").arg(CHECK).args([&file, &binary, &package]).output().unwrap();
        let (out, err) = (String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
        assert!(run.status.success() && err.is_empty(), "{name}: {out}{err}");
        let count = |kind| out.trim().split(',').filter(|k| *k == kind).count();
        assert_eq!((count("BasisCurves"), count("Mesh"), count("Camera"), count("Material")), (4, 2, 1, 4));
        // The result of Pixar's library reads the same, in binary and with the textures in a package.
        let (written, _) = read(&file, &Options::default()).unwrap();
        for other in [binary, package] {
            assert_eq!(read(&other, &Options::default()).unwrap().0, written, "{name}: {}", other.display());
        }
    }
}

/// Pixar's library finds the same prims, fields and values in both formats, and the same order.
#[test]
fn usd_core_finds_the_same_layer_in_both_formats() {
    const CHECK: &str = "
import sys
from pxr import Sdf
text, binary = (Sdf.Layer.FindOrOpen(path) for path in sys.argv[1:])
assert (text.GetFileFormat().formatId, binary.GetFileFormat().formatId) == ('usda', 'usdc')
assert text.ExportToString() == binary.ExportToString(), binary.ExportToString()
";
    let folder = tempfile::tempdir().unwrap();
    for scene in [scene(), compressible(), herd(), Scene { camera: scene().camera, ..Scene::default() }] {
        let Some(mut python) = crate::common::pixar() else { return };
        let files = ["a.usda", "a.usdc"].map(|name| folder.path().join(name));
        files.iter().for_each(|file| write(&scene, file).unwrap());
        let run = python.arg("-c").arg(CHECK).args(files).output().unwrap();
        assert!(run.status.success() && run.stderr.is_empty(), "{}", String::from_utf8_lossy(&run.stderr));
    }
}
