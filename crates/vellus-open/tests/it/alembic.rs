//! Alembic archives as scenes.

use crate::writer::*;
use glam::Vec3;
use std::path::{Path, PathBuf};
use vellus::Parameter;
use vellus_open::{Error, Opened, Options, open};
use vellus_scene::{Basis, Scene, Strands, Values};

/// The archive of a test, in a folder of its own.
struct File {
    folder: tempfile::TempDir,
}

impl File {
    fn new(bytes: &[u8]) -> Self {
        let file = File { folder: tempfile::tempdir().unwrap() };
        std::fs::write(file.path(), bytes).unwrap();
        file
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("a.abc")
    }
}

fn open_all(objects: Vec<Obj>, options: &Options) -> Result<Opened, Error> {
    let file = File::new(&archive("FramesPerTimeUnit=10", &[1.0, 1.1], objects));
    open(file.path(), options)
}

fn opened(objects: Vec<Obj>) -> Opened {
    open_all(objects, &Options::default()).unwrap()
}

fn warnings(opened: &Opened) -> Vec<String> {
    opened.warnings.iter().map(ToString::to_string).collect()
}

/// Three linear strands of two points along y at x = 0, 1 and 2, with a width of 0.2, and more properties.
fn curves(name: &str, attributes: Vec<Prop>, more: Vec<Prop>) -> Obj {
    let points: Vec<f32> = (0..3).flat_map(|x| [x as f32, 0.0, 0.0, x as f32, 1.0, 0.0]).collect();
    curves_with(name, attributes, more, Prop::array("P", F32, 3, f32s(&points)))
}

/// The same with other points.
fn curves_with(name: &str, attributes: Vec<Prop>, more: Vec<Prop>, points: Prop) -> Obj {
    let mut own = vec![
        Prop::array("nVertices", I32, 1, i32s(&[2, 2, 2])),
        Prop::scalar("curveBasisAndType", U8, 4, vec![1, 0, 0, 0]),
        Prop::array("width", F32, 1, f32s(&[0.2])),
        Prop::compound(".arbGeomParams", attributes),
    ];
    own.extend(more);
    own.push(points);
    Obj::new(name, "AbcGeom_Curve_v2", vec![Prop::compound(".geom", own)], vec![])
}

fn xform(name: &str, ops: Vec<u8>, samples: Vec<Vec<u8>>, children: Vec<Obj>) -> Obj {
    let count = ops.len() as u32;
    let extent = samples[0].len() as u32 / 8;
    let values = Prop::scalar(".vals", F64, extent, vec![]).samples(samples);
    let own = Prop::compound(".xform", vec![Prop::scalar(".ops", U8, count, ops), values]);
    Obj::new(name, "AbcGeom_Xform_v3", vec![own], children)
}

fn roots(strands: &Strands) -> Vec<[f32; 3]> {
    (0..strands.len()).map(|i| strands.strand(i)[0].truncate().to_array()).collect()
}

/// The same curves as Blender writes them, in Alembic with y up and in USD with z up.
#[test]
fn a_file_of_blender_has_the_strands_of_its_usd() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../vellus-usd/tests/data/blender");
    let [abc, usd] = ["abc", "usda"].map(|extension| {
        let opened = open(folder.join("fur_catmull_rom").with_extension(extension), &Options::default()).unwrap();
        assert_eq!(opened.scene.strands.len(), 1);
        opened.scene.strands[0].clone()
    });
    assert_eq!((abc.basis, &abc.starts), (Basis::CatmullRom, &usd.starts));
    for (a, b) in abc.points.iter().zip(&usd.points) {
        // Both files have single precision, at most a few units large.
        assert!(a.truncate().distance(Vec3::new(b.x, b.z, -b.y)) < 1e-6, "{a} {b}");
        assert!((a.w - b.w).abs() < 1e-9);
    }
}

/// Guides are left out, groups are sets with their names, and colours, uv and widths follow their strands.
#[test]
fn attributes_of_grooms_are_used() {
    let colors: Vec<f32> = (0..18).map(|i| i as f32 / 64.0).collect();
    let attributes = vec![
        Prop::array("groom_guide", I8, 1, vec![0, 1, 0]).metadata("geoScope=uni"),
        Prop::compound(
            "groom_group_name",
            vec![
                Prop::array(".vals", TEXT, 1, texts(&["body", "tail"])),
                Prop::array(".indices", U32, 1, i32s(&[1, 0, 0])),
            ],
        ),
        Prop::array("groom_root_uv", F32, 2, f32s(&[0.1, 0.2, 0.3, 0.4, 0.5, 0.6])),
        Prop::array("groom_color", F32, 3, f32s(&colors)),
        Prop::array("groom_width", F32, 1, f32s(&[2.0, 4.0, 6.0])),
        Prop::array("groom_id", I32, 1, i32s(&[0, 1, 2])),
        Prop::array("clump", I32, 1, i32s(&[0, 1, 2])),
    ];
    let opened = opened(vec![curves("fox", attributes, vec![])]);
    let [tail, body] = &opened.scene.strands[..] else { panic!("{:?}", opened.scene.strands) };
    assert_eq!((tail.name.as_str(), roots(tail)), ("/fox/tail", vec![[0.0, 0.0, 0.0]]));
    assert_eq!((body.name.as_str(), roots(body)), ("/fox/body", vec![[2.0, 0.0, 0.0]]));
    assert_eq!((tail.points[0].w, body.points[1].w), (1.0, 3.0));
    assert_eq!(body.root_uv.as_ref().unwrap()[0].to_array(), [0.5, 0.6]);
    let colors = Values::PerPoint(
        vec![[12.0, 13.0, 14.0], [15.0, 16.0, 17.0]].into_iter().map(|c| c.map(|x| x / 64.0)).collect(),
    );
    assert_eq!(body.varying, [(Parameter::Reflectance, colors)]);
    let warnings = warnings(&opened);
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert_eq!(warnings[0], "/fox: its 1 guides are left out (groom_guide)");
    assert!(warnings[1].ends_with("a.abc: these attributes are not used: clump"), "{warnings:?}");
}

#[test]
fn guides_are_shown_if_there_is_nothing_else() {
    let guide = |value: u8| vec![Prop::scalar("groom_guide", I8, 1, vec![value])];
    let alone = opened(vec![curves("fox", guide(1), vec![])]);
    assert_eq!((alone.scene.strands[0].len(), warnings(&alone).len()), (3, 1));
    assert!(warnings(&alone)[0].contains("guides only"));
    let both = opened(vec![curves("fox", guide(1), vec![]), curves("cat", guide(0), vec![])]);
    assert_eq!((both.scene.strands.len(), both.scene.strands[0].name.as_str()), (1, "/cat"));
}

/// Attributes that do not fit are named; strands with NaN are left out; colours are held in their range.
#[test]
fn what_does_not_fit_is_named() {
    let attributes = vec![
        Prop::array("groom_root_uv", F32, 2, f32s(&[0.0; 8])),
        Prop::array("Cd", F32, 3, f32s(&[7.0, 0.0, 0.0])),
        Prop::array("groom_width", F32, 1, f32s(&[1.0, f32::NAN, 1.0])),
    ];
    let opened = opened(vec![curves("fox", attributes, vec![])]);
    let text = warnings(&opened).join("\n");
    assert!(text.contains("/fox: groom_root_uv has 4 rows of 2, which do not fit 3 strands with 6 points"), "{text}");
    assert!(text.contains("colours of Cd outside of"), "{text}");
    assert!(text.contains("1 of 3 strands are left out (strand 1)"), "{text}");
    assert_eq!((opened.scene.strands[0].len(), opened.scene.strands[0].root_uv.as_ref()), (2, None));
}

/// Two samples at frames 10 and 11, at ten frames a second, of a transform that moves by 4 along x and scales by 2.
#[test]
fn frames_and_shutters_choose_the_time() {
    let at = |x: f64| f64s(&[x, 0.0, 0.0, 2.0, 2.0, 2.0]);
    let scene = |frame, shutter| {
        let objects = vec![xform("x", vec![0x10, 0x00], vec![at(0.0), at(4.0)], vec![curves("fox", vec![], vec![])])];
        let opened = open_all(objects, &Options { frame, shutter, ..Options::default() }).unwrap();
        assert_eq!(opened.shot.map(|shot| (shot.frame, shot.frames_per_second)), Some((frame.or(Some(10.0)), 10.0)));
        opened.scene.strands[0].clone()
    };
    let near = |a: Vec3, x: f32| assert!(a.distance(Vec3::new(x, 0.0, 0.0)) < 1e-5, "{a}, not {x}");
    let first = scene(None, None);
    near(first.points[0].truncate(), 0.0);
    near(first.points[4].truncate(), 4.0);
    // Widths are diameters, and grow with the transform.
    assert_eq!((first.points[0].w, first.moved), (0.2, None));
    near(scene(Some(10.5), None).points[0].truncate(), 2.0);
    near(scene(Some(99.0), None).points[0].truncate(), 4.0);
    let blurred = scene(Some(10.0), Some([0.25, 0.75]));
    near(blurred.points[0].truncate(), 1.0);
    near(blurred.moved.unwrap()[0], 3.0);
}

/// Velocities are per second. They count where samples do not: if there is one, or if the curves change.
#[test]
fn velocities_move_curves() {
    let velocities = |x: f32| Prop::array(".velocities", F32, 3, f32s(&[[x, 0.0, 0.0]; 6].concat()));
    let read = |more: Vec<Prop>, frame: f64| {
        let options = Options { frame: Some(frame), shutter: Some([-0.5, 0.5]), ..Options::default() };
        open_all(vec![curves("fox", vec![], more)], &options).unwrap().scene.strands[0].clone()
    };
    let near = |a: f32, x: f32| assert!((a - x).abs() < 1e-5, "{a}, not {x}");
    // A tenth of a second is a frame.
    let one = read(vec![velocities(2.0)], 10.0);
    near(one.points[0].x, -0.1);
    near(one.moved.unwrap()[0].x, 0.1);
    assert_eq!(read(vec![], 10.0).moved, None);
    // Of curves with samples, the samples count.
    let points = |x: f32| f32s(&(0..6).flat_map(|i| [x + i as f32, 0.0, 0.0]).collect::<Vec<_>>());
    let sampled = Prop::array("P", F32, 3, vec![]).samples(vec![points(0.0), points(4.0)]);
    let both = open_all(
        vec![curves_with("fox", vec![], vec![velocities(2.0)], sampled)],
        &Options { frame: Some(10.0), shutter: Some([0.0, 1.0]), ..Options::default() },
    );
    let both = both.unwrap().scene.strands[0].clone();
    near(both.points[0].x, 0.0);
    near(both.moved.unwrap()[0].x, 4.0);
}

/// Hair without motion follows the guides that it names, as they moved since the first sample.
#[test]
fn hair_follows_its_guides() {
    // Guides whose tips move by 1, 2 and 3 along z, in a transform that scales by 2.
    let points = |z: f32| {
        let strand = |x: f32| [x, 0.0, 0.0, x, 1.0, z * (x + 1.0)];
        f32s(&(0..3).flat_map(|x| strand(x as f32)).collect::<Vec<_>>())
    };
    let guide = vec![Prop::scalar("groom_guide", I8, 1, vec![1]), Prop::array("groom_id", I32, 1, i32s(&[5, 6, 7]))];
    let moving = Prop::array("P", F32, 3, vec![]).samples(vec![points(0.0), points(1.0)]);
    let twice = f64s(&[2.0, 2.0, 2.0]);
    let guides =
        |guide| xform("x", vec![0x00], vec![twice.clone()], vec![curves_with("guides", guide, vec![], moving.clone())]);
    let bound = || {
        vec![
            Prop::array("groom_closest_guides", I32, 3, i32s(&[5, 0, 0, 5, 7, 0, 99, 0, 0])),
            Prop::array("groom_guide_weights", F32, 3, f32s(&[1.0, 0.0, 0.0, 0.5, 1.5, 0.0, 1.0, 0.0, 0.0])),
        ]
    };
    let read = |guide, frame: f64, shutter| {
        let options = Options { frame: Some(frame), shutter, ..Options::default() };
        open_all(vec![guides(guide), curves("fox", bound(), vec![])], &options).unwrap()
    };
    let still = read(guide.clone(), 10.0, None);
    assert_eq!(roots(&still.scene.strands[0]), [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    let tips = |strands: &Strands| [1, 3, 5].map(|i| strands.points[i].z);
    assert_eq!(tips(&still.scene.strands[0]), [0.0; 3]);
    let later = read(guide.clone(), 11.0, None);
    let near = |found: [f32; 3], expected: [f32; 3]| {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?}, not {expected:?}");
    };
    near(tips(&later.scene.strands[0]), [2.0, 0.25 * 2.0 + 0.75 * 6.0, 0.0]);
    assert_eq!(roots(&later.scene.strands[0]), roots(&still.scene.strands[0]));
    let text = warnings(&later).join("\n");
    assert!(text.contains("/fox: 1 of its strands do not move: the file does not have their guides"), "{text}");
    assert!(!text.contains("not used"), "{text}");
    let blurred = read(guide, 10.0, Some([0.0, 0.5])).scene.strands[0].clone();
    near(tips(&blurred), [0.0; 3]);
    near([1, 3, 5].map(|i| blurred.moved.as_ref().unwrap()[i].z), [1.0, 2.5, 0.0]);
    // Without numbers, guides are counted: no strand has guides 5 to 7, and the third weights of two are 0.
    let counted = read(vec![Prop::scalar("groom_guide", I8, 1, vec![1])], 11.0, None);
    near(tips(&counted.scene.strands[0]), [0.0; 3]);
}

/// A square seen from +z, whose corners are clockwise as in Alembic, becomes counterclockwise, also in a mirror.
#[test]
fn meshes_face_outwards() {
    let mesh = |schema| {
        let own = vec![
            Prop::array("P", F32, 3, f32s(&[0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 0.0])),
            Prop::array(".faceIndices", I32, 1, i32s(&[0, 1, 2, 3])),
            Prop::array(".faceCounts", I32, 1, i32s(&[4])),
            Prop::array("uv", F32, 2, f32s(&[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0])),
        ];
        Obj::new("skin", schema, vec![Prop::compound(".geom", own)], vec![])
    };
    let objects = vec![
        mesh("AbcGeom_PolyMesh_v1"),
        xform("mirror", vec![0x00], vec![f64s(&[-1.0, 1.0, 1.0])], vec![mesh("AbcGeom_SubD_v1")]),
    ];
    let opened = opened(objects);
    assert_eq!(opened.scene.meshes.len(), 2);
    for mesh in &opened.scene.meshes {
        assert_eq!(mesh.triangles.len(), 2);
        for (triangle, uv) in mesh.triangles.iter().zip(mesh.uv.as_ref().unwrap()) {
            let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize]);
            assert!((b - a).cross(c - a).z > 0.0, "{}", mesh.name);
            assert!(uv.iter().zip([a, b, c]).all(|(uv, p)| uv.to_array() == [p.x.abs(), p.y]));
        }
    }
    let warnings = warnings(&opened);
    assert_eq!(warnings, ["/mirror/skin: it is a subdivision surface: its control mesh is shown"]);
}

/// An instance below a transform, a hidden object, a camera, and objects of other kinds.
#[test]
fn objects_have_their_places() {
    let hidden = Prop::scalar("visible", I8, 1, vec![0]);
    let core = [50.0, 3.6, 0.0, 2.4, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 5.6, 500.0, 0.0, 0.0, 1.0, 1000.0];
    let eye = Obj::new(
        "cam",
        "AbcGeom_Camera_v1",
        vec![Prop::compound(".geom", vec![Prop::scalar(".core", F64, 16, f64s(&core))])],
        vec![],
    );
    let moved = |name, children| xform(name, vec![0x10], vec![f64s(&[0.0, 0.0, 5.0])], children);
    let objects = vec![
        curves("fox", vec![], vec![]),
        moved("twin", vec![Obj::instance("fox", "/fox")]),
        moved("gone", vec![Obj::instance("lost", "/nowhere"), Obj::instance("loop", "/gone")]),
        Obj::new("cat", "AbcGeom_Xform_v3", vec![hidden], vec![curves("fur", vec![], vec![])]),
        moved("eye", vec![eye]),
        Obj::new("lamp", "AbcGeom_Light_v1", vec![], vec![]),
    ];
    let opened = opened(objects.clone());
    let names: Vec<&str> = opened.scene.strands.iter().map(|strands| strands.name.as_str()).collect();
    assert_eq!(names, ["/fox", "/twin/fox"]);
    assert_eq!(roots(&opened.scene.strands[1])[1], [1.0, 0.0, 5.0]);
    let camera = opened.scene.camera.unwrap();
    assert_eq!(camera.to_world.w_axis.to_array(), [0.0, 0.0, 5.0, 1.0]);
    assert!((camera.film_width - 0.72).abs() < 1e-6 && (camera.film_height - 0.48).abs() < 1e-6);
    let text = warnings(&opened).join("\n");
    assert!(text.contains("left out: its source /nowhere does not exist"), "{text}");
    assert!(text.contains("instances are inside each other"), "{text}");
    assert!(text.contains("/lamp: left out: objects of the schema AbcGeom_Light_v1 are not supported"), "{text}");
    let named = |name: &str| open_all(objects.clone(), &Options { camera: Some(name.into()), ..Options::default() });
    assert!(named("cam").is_ok() && named("/eye/cam").is_ok());
    assert!(matches!(named("other"), Err(Error::NoCamera { name, .. }) if name == "other"));
}

#[test]
fn files_that_show_nothing_are_errors() {
    let message = |bytes: &[u8]| {
        let error = open(File::new(bytes).path(), &Options::default()).unwrap_err();
        let source = std::error::Error::source(&error).map(ToString::to_string).unwrap_or_default();
        format!("{error}: {source}")
    };
    assert!(message(b"\x89HDF\r\n\x1a\n").contains("abcconvert -toOgawa"));
    assert!(message(b"#usda 1.0").contains("a.abc: it is not an Alembic archive"));
    assert!(message(&archive("", &[0.0], vec![])).contains("it has no curves and no meshes that can be shown"));
    let bare = Obj::new("a", "AbcGeom_Curve_v2", vec![], vec![]);
    assert!(message(&archive("", &[0.0], vec![bare])).contains("\n  /a: left out: .geom is missing"));
    let own = vec![
        Prop::array("nVertices", I32, 1, i32s(&[2])),
        Prop::scalar("curveBasisAndType", U8, 4, vec![1, 0, 0, 0]),
        Prop::array("P", F32, 3, f32s(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0])),
    ];
    let thin = || vec![Obj::new("fox", "AbcGeom_Curve_v2", vec![Prop::compound(".geom", own.clone())], vec![])];
    assert!(open_all(thin(), &Options::default()).unwrap_err().to_string().contains("a.abc: /fox"));
    let wide = open_all(thin(), &Options { width: Some(0.5), ..Options::default() }).unwrap();
    assert_eq!(wide.scene.strands[0].points[0].w, 0.25);
}

/// A thousand archives with changed bytes: a scene or an error, and each scene is valid.
#[test]
fn changed_bytes_give_valid_scenes() {
    let attributes = vec![
        Prop::array("groom_guide", I8, 1, vec![0, 1, 0]),
        Prop::array("groom_group_id", I32, 1, i32s(&[1, 0, 0])),
        Prop::array("groom_root_uv", F32, 2, f32s(&[0.1, 0.2, 0.3, 0.4, 0.5, 0.6])),
        Prop::array("Cd", F32, 3, f32s(&[0.3; 18])),
    ];
    let knots = [0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 0, 1, 2, 3, 3, 3, 3].map(|knot| knot as f32);
    let spline = |name, kinds: Vec<u8>| {
        let own = vec![
            Prop::array("nVertices", I32, 1, i32s(&[4, 6])),
            Prop::scalar("curveBasisAndType", U8, 4, kinds),
            Prop::array(".knots", F32, 1, f32s(&knots)),
            Prop::array("P", F32, 3, f32s(&[0.5; 30])),
            Prop::array("width", F32, 1, f32s(&[0.1; 10])),
        ];
        Obj::new(name, "AbcGeom_Curve_v2", vec![Prop::compound(".geom", own)], vec![])
    };
    let identity = glam::DMat4::IDENTITY.to_cols_array();
    let objects = vec![
        xform("x", vec![0x30], vec![f64s(&identity)], vec![curves("fox", attributes, vec![])]),
        spline("spline", vec![0, 0, 2, 2]),
        spline("hermite", vec![0, 0, 4, 4]),
        spline("loop", vec![0, 1, 3, 3]),
        Obj::instance("copy", "/x/fox"),
    ];
    let bytes = archive("FramesPerTimeUnit=10", &[1.0, 1.1], objects);
    let file = File::new(&bytes);
    let check = |scene: &Scene| scene.validate().unwrap();
    check(&open(file.path(), &Options::default()).unwrap().scene);
    let mut state = 7u64;
    let mut next = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let mut read = 0;
    for _ in 0..1000 {
        let mut changed = bytes.clone();
        for _ in 0..=next(3) {
            let at = next(changed.len());
            changed[at] = next(256) as u8;
        }
        std::fs::write(file.path(), changed).unwrap();
        let shutter = Some([0.0, 0.5]);
        if let Ok(opened) = open(file.path(), &Options { shutter, width: Some(0.1), ..Options::default() }) {
            check(&opened.scene);
            read += 1;
        }
    }
    // Most changes are in numbers.
    assert!(read > 100, "{read}");
}
