//! Curves, meshes, transforms, cameras and attributes at a time.

use crate::writer::*;
use vellus_alembic::*;

const TWO: [f32; 12] = [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0];

/// An archive with one object with the properties `own` in its schema, and its samples at 0 and 1 second.
fn open(name: &str, part: &str, own: Vec<Prop>) -> Archive {
    let object = Obj::new("a", name, vec![Prop::compound(part, own)], vec![]);
    Archive::open(archive("", &[0.0, 1.0], vec![object])).unwrap()
}

fn curves(kinds: [u8; 4], mut more: Vec<Prop>) -> Archive {
    let moved: Vec<f32> = TWO.iter().map(|x| x + 2.0).collect();
    more.extend([
        Prop::array("P", F32, 3, vec![]).samples(vec![f32s(&TWO), f32s(&moved)]),
        Prop::array("nVertices", I32, 1, i32s(&[2, 2])),
        Prop::scalar("curveBasisAndType", U8, 4, kinds.to_vec()),
    ]);
    open("AbcGeom_Curve_v2", ".geom", more)
}

#[test]
fn curves_have_their_kind_and_move() {
    let found = |kinds, time| {
        let archive = curves(kinds, vec![]);
        Curves::read(&archive, &archive.objects[1], time).unwrap()
    };
    let linear = found([1, 0, 0, 0], 0.25);
    assert_eq!((linear.kind, linear.basis, linear.periodic), (CurveType::Linear, CurveBasis::None, false));
    assert_eq!((&linear.counts[..], linear.positions[1], linear.widths), (&[2, 2][..], [0.5, 1.5, 0.5], None));
    let spline = found([0, 1, 3, 3], 9.0);
    assert_eq!((spline.kind, spline.basis, spline.periodic), (CurveType::Cubic, CurveBasis::CatmullRom, true));
    assert_eq!(spline.positions[0], [2.0; 3]);
    let orders = [CurveBasis::Bezier, CurveBasis::BSpline, CurveBasis::CatmullRom, CurveBasis::Hermite];
    assert_eq!([1, 2, 3, 4].map(|basis| found([0, 0, basis, basis], 0.0).basis), orders);
    assert_eq!(found([2, 0, 9, 9], 0.0).basis, CurveBasis::Unknown(9));
}

/// Curves whose numbers of points change have the points of the last sample.
#[test]
fn changing_curves_are_not_mixed() {
    let archive = open(
        "AbcGeom_Curve_v2",
        ".geom",
        vec![
            Prop::array("P", F32, 3, vec![]).samples(vec![f32s(&TWO), f32s(&[0.0; 12])]),
            Prop::array("nVertices", I32, 1, vec![]).samples(vec![i32s(&[2, 2]), i32s(&[1, 3])]),
        ],
    );
    let found = Curves::read(&archive, &archive.objects[1], 0.5).unwrap();
    assert_eq!((&found.counts[..], found.positions[1]), (&[2, 2][..], [0.0, 1.0, 0.0]));
}

#[test]
fn counts_that_do_not_fit_are_named() {
    let error = |counts: &[i32]| {
        let archive = open(
            "AbcGeom_Curve_v2",
            ".geom",
            vec![Prop::array("P", F32, 3, f32s(&TWO)), Prop::array("nVertices", I32, 1, i32s(counts))],
        );
        Curves::read(&archive, &archive.objects[1], 0.0).unwrap_err().to_string()
    };
    assert_eq!(error(&[2, 3]), "nVertices adds up to 5, but there are 4 points");
    assert_eq!(error(&[2, -1, 3]), "nVertices [1] is -1");
    let archive = open("AbcGeom_Curve_v2", ".other", vec![]);
    assert_eq!(Curves::read(&archive, &archive.objects[1], 0.0).unwrap_err().to_string(), ".geom is missing");
}

/// Values for each row, values shared by their indices, rows of a length in the metadata, and texts.
#[test]
fn attributes_have_scopes_and_indices() {
    let scoped = |prop: Prop, scope: &str| prop.metadata(&format!("geoScope={scope};isGeomParam=true"));
    let indexed = Prop::compound(
        "groom_root_uv",
        vec![
            Prop::array(".vals", F32, 2, f32s(&[0.1, 0.2, 0.3, 0.4])),
            Prop::array(".indices", U32, 1, i32s(&[1, 0, 1, 7])),
        ],
    );
    let guides = Prop::array("groom_closest_guides", I32, 1, i32s(&[1, 2, 3, 4, 5, 6]));
    let attributes = vec![
        scoped(indexed, "uni"),
        guides.metadata("geoScope=uni;arrayExtent=3"),
        scoped(Prop::array("Cd", F32, 3, vec![]).samples(vec![f32s(&[0.0; 3]), f32s(&[1.0; 3])]), "vtx"),
        scoped(Prop::array("groom_group_name", TEXT, 1, texts(&["body", "tail"])), "con"),
        Prop::scalar("groom_guide", I8, 1, vec![1]),
        Prop::compound("broken", vec![]),
    ];
    let archive = curves(
        [1, 0, 0, 0],
        vec![
            Prop::compound(".arbGeomParams", attributes),
            Prop::compound(".userProperties", vec![Prop::scalar("tool", TEXT, 1, texts(&["comb"]))]),
            scoped(Prop::array("width", F32, 1, f32s(&[0.5])), "con"),
        ],
    );
    let object = &archive.objects[1];
    let read = |i: usize| Attribute::read(&archive, &attributes_of(object)[i], 0.5);
    let uv = read(0).unwrap();
    assert_eq!((uv.name.as_str(), uv.scope, uv.lanes, uv.rows()), ("groom_root_uv", Scope::Uniform, 2, 4));
    assert_eq!([0, 1, 3].map(|row| uv.number(row, 1).map(|x| x as f32)), [Some(0.4), Some(0.2), None]);
    let guides = read(1).unwrap();
    assert_eq!((guides.lanes, guides.rows(), guides.number(1, 2), guides.number(1, 3)), (3, 2, Some(6.0), None));
    assert_eq!((read(2).unwrap().scope, read(2).unwrap().values), (Scope::Vertex, Values::Single(vec![0.5; 3])));
    assert_eq!((read(3).unwrap().text(1), read(3).unwrap().scope), (Some("tail"), Scope::Constant));
    assert_eq!((read(4).unwrap().values, read(4).unwrap().scope), (Values::Whole(vec![1]), Scope::Unknown));
    assert_eq!(read(5).unwrap_err().to_string(), "broken has no values");
    let tool = Attribute::read(&archive, &user_properties(object)[0], 0.0).unwrap();
    assert_eq!((tool.name.as_str(), tool.text(0)), ("tool", Some("comb")));
    let widths = Curves::read(&archive, object, 0.0).unwrap().widths.unwrap();
    assert_eq!((widths.scope, widths.number(0, 0)), (Scope::Constant, Some(0.5)));
}

fn attributes_of(object: &Object) -> &[Property] {
    attributes(object)
}

#[test]
fn meshes_have_checked_faces() {
    let mesh = |schema: &str, corners: &[i32]| {
        let archive = open(
            schema,
            ".geom",
            vec![
                Prop::array("P", F32, 3, f32s(&TWO)),
                Prop::array(".faceIndices", I32, 1, i32s(corners)),
                Prop::array(".faceCounts", I32, 1, i32s(&[4])),
                Prop::scalar(".scheme", TEXT, 1, texts(&["loop"])),
            ],
        );
        Mesh::read(&archive, &archive.objects[1], 0.0)
    };
    let polygons = mesh("AbcGeom_PolyMesh_v1", &[0, 1, 3, 2]).unwrap();
    assert_eq!((polygons.scheme, polygons.counts, polygons.indices), (None, vec![4], vec![0, 1, 3, 2]));
    assert_eq!(mesh("AbcGeom_SubD_v1", &[0, 1, 3, 2]).unwrap().scheme.as_deref(), Some("loop"));
    let error = |corners| mesh("AbcGeom_PolyMesh_v1", corners).unwrap_err().to_string();
    assert_eq!(error(&[0, 1, 4, 2]), ".faceIndices [2] is 4, but there are 4 vertices");
    assert_eq!(error(&[0, 1, 3]), ".faceCounts adds up to 4, but there are 3 corners");
}

#[test]
fn transforms_are_mixed_between_samples() {
    let ops = vec![0x10, 0x51, 0x00];
    let values = |x: f64| f64s(&[x, 0.0, 0.0, 90.0, 1.0, 2.0, 3.0]);
    let archive = open(
        "AbcGeom_Xform_v3",
        ".xform",
        vec![
            Prop::scalar(".inherits", BOOL, 1, vec![0]),
            Prop::scalar(".ops", U8, 3, ops),
            Prop::scalar(".vals", F64, 7, vec![]).samples(vec![values(0.0), values(4.0)]),
        ],
    );
    let xform = Xform::read(&archive, &archive.objects[1], 0.25).unwrap();
    let rotate = Op::Rotate([0.0, 1.0, 0.0], 90.0);
    assert_eq!(xform.ops, [Op::Translate([1.0, 0.0, 0.0]), rotate, Op::Scale([1.0, 2.0, 3.0])]);
    assert!(!xform.inherits);
    let empty = open("AbcGeom_Xform_v3", ".xform", vec![]);
    assert_eq!(Xform::read(&empty, &empty.objects[1], 0.0).unwrap(), Xform { inherits: true, ops: vec![] });
    let odd = open("AbcGeom_Xform_v3", ".xform", vec![Prop::scalar(".ops", U8, 1, vec![0x70])]);
    assert_eq!(Xform::read(&odd, &odd.objects[1], 0.0).unwrap_err().to_string(), ".ops has the unknown operation 7");
}

#[test]
fn cameras_have_sixteen_numbers() {
    let core: Vec<f64> = (1..=16).map(f64::from).collect();
    let archive = open("AbcGeom_Camera_v1", ".geom", vec![Prop::scalar(".core", F64, 16, f64s(&core))]);
    let camera = Camera::read(&archive, &archive.objects[1], 0.0).unwrap();
    assert_eq!((camera.focal_length, camera.horizontal_aperture, camera.vertical_aperture), (1.0, 2.0, 4.0));
    assert_eq!((camera.f_stop, camera.shutter, camera.clipping), (11.0, [13.0, 14.0], [15.0, 16.0]));
    let short = open("AbcGeom_Camera_v1", ".geom", vec![Prop::scalar(".core", F64, 3, f64s(&core[..3]))]);
    assert!(Camera::read(&short, &short.objects[1], 0.0).unwrap_err().to_string().contains("there must be 16"));
}

#[test]
fn objects_are_hidden_or_copies() {
    let hidden = |value: u8| {
        let prop = Prop::scalar("visible", I8, 1, vec![value]);
        let archive = Archive::open(archive("", &[0.0], vec![Obj::new("a", "s", vec![prop], vec![])])).unwrap();
        visibility(&archive, &archive.objects[1], 0.0).unwrap()
    };
    assert_eq!([0, 1, 255].map(hidden), [Visibility::Hidden, Visibility::Visible, Visibility::Inherited]);
    let archive = Archive::open(archive("", &[0.0], vec![Obj::instance("a", "/b/c")])).unwrap();
    assert_eq!(instance_source(&archive, &archive.objects[1]).unwrap().as_deref(), Some("/b/c"));
    assert_eq!(instance_source(&archive, &archive.objects[0]).unwrap(), None);
}
