//! What is written is read again: by this crate, and by the library of Alembic.

use std::io::Cursor;
use std::process::Command;
use vellus_alembic::{
    Archive, Attribute, Camera, CurveBasis, CurveType, Curves, Form, Geometry, Kind, Mesh, Object, Op, Owner, Pod,
    Property, Scope, TimeSampling, Values, Writer, Xform, attributes, user_properties, visibility,
};
use vellus_testing::{need, succeeds};

type Memory = Writer<Cursor<Vec<u8>>>;

fn memory() -> Memory {
    Writer::new(Cursor::new(Vec::new())).unwrap()
}

fn read(writer: Memory) -> Archive {
    Archive::open(writer.finish(&[("_ai_Application", "tests")]).unwrap().into_inner()).unwrap()
}

fn attribute(name: &str, scope: Scope, lanes: usize, pod: Pod, values: Values) -> Attribute {
    Attribute { name: name.to_owned(), scope, lanes, pod, interpretation: String::new(), values, indices: None }
}

/// One attribute of each kind.
fn all_attributes() -> Vec<Attribute> {
    let whole = |pod| attribute(&format!("{pod:?}"), Scope::Uniform, 1, pod, Values::Whole(vec![1, 0]));
    let mut all: Vec<Attribute> =
        [Pod::Bool, Pod::U8, Pod::I8, Pod::U16, Pod::I16, Pod::U32, Pod::I32, Pod::U64, Pod::I64].map(whole).to_vec();
    all.push(attribute("half", Scope::Vertex, 1, Pod::F16, Values::Single((0..7).map(|i| 0.25 * i as f32).collect())));
    all.push(attribute("double", Scope::Constant, 3, Pod::F64, Values::Double(vec![0.1, -1e300, 5e-324])));
    let texts = ["", "a b", "\u{e9}"].map(str::to_owned).to_vec();
    all.push(attribute("text", Scope::Unknown, 1, Pod::Text, Values::Text(texts)));
    all.push(attribute("long", Scope::Constant, 20, Pod::F32, Values::Single(vec![0.5; 40])));
    all.push(attribute("empty", Scope::Uniform, 1, Pod::I32, Values::Whole(Vec::new())));
    let uv = attribute("groom_root_uv", Scope::Uniform, 2, Pod::F32, Values::Single(vec![0.1, 0.2, 0.3, 0.4]));
    all.push(Attribute { indices: Some(vec![1, 0, 1]), interpretation: "vector".to_owned(), ..uv });
    all
}

fn curves(shift: f32) -> Curves {
    Curves {
        kind: CurveType::Cubic,
        periodic: false,
        basis: CurveBasis::CatmullRom,
        counts: vec![4, 3],
        positions: (0..7).map(|i| [i as f32 + shift, -0.5, 1e-7 * i as f32]).collect(),
        weights: Some(vec![1.0; 7]),
        velocities: Some((0..7).map(|i| [0.0, i as f32, 0.0]).collect()),
        orders: vec![4, 3],
        knots: vec![0.0, 1.0, 2.0],
        widths: Some(attribute("width", Scope::Vertex, 1, Pod::F32, Values::Single(vec![0.1 + shift; 7]))),
        uv: None,
        normals: None,
    }
}

fn mesh() -> Mesh {
    let values = Values::Single([0.0, 0.0, 1.0].repeat(4));
    let normals =
        Attribute { interpretation: "normal".to_owned(), ..attribute("N", Scope::FaceVarying, 3, Pod::F32, values) };
    let uv = attribute("uv", Scope::FaceVarying, 2, Pod::F32, Values::Single(vec![0.0, 0.0, 1.0, 0.0]));
    Mesh {
        scheme: None,
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
        counts: vec![4],
        indices: vec![0, 3, 2, 1],
        velocities: None,
        uv: Some(Attribute { indices: Some(vec![0, 1, 1, 0]), interpretation: "vector".to_owned(), ..uv }),
        normals: Some(normals),
    }
}

fn camera() -> Camera {
    Camera {
        focal_length: 50.0,
        horizontal_aperture: 3.6,
        horizontal_film_offset: 0.1,
        vertical_aperture: 2.4,
        vertical_film_offset: -0.2,
        lens_squeeze_ratio: 1.5,
        overscan: [0.1, 0.2, 0.3, 0.4],
        f_stop: 2.8,
        focus_distance: 120.0,
        shutter: [-0.01, 0.01],
        clipping: [0.1, 1e5],
    }
}

fn xform(x: f64) -> Xform {
    let turned = [[0.0, 1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [x, 2.0, 3.0, 1.0]];
    Xform { inherits: true, ops: vec![Op::Matrix(turned)] }
}

/// A transform with curves of three samples, the last of which repeats the second one, a mesh, and a camera.
fn scene() -> Memory {
    let mut writer = memory();
    let times = writer.times(&TimeSampling::Uniform { start: 0.5, step: 0.25 });
    let mut fox = Geometry::xform(&mut writer, Memory::ROOT, "fox", times).unwrap();
    for x in [1.0, 2.0] {
        fox.add_xform(&mut writer, &xform(x)).unwrap();
    }
    let mut coat = Geometry::curves(&mut writer, fox.object, "coat", times).unwrap();
    for shift in [0.0, 1.0, 1.0] {
        coat.add_curves(&mut writer, &curves(shift), &all_attributes()).unwrap();
    }
    coat.user_property(&mut writer, &attribute("maker", Scope::Unknown, 1, Pod::I32, Values::Whole(vec![-7]))).unwrap();
    coat.visible(&mut writer, false).unwrap();
    let mut skin = Geometry::polygons(&mut writer, fox.object, "skin", 0).unwrap();
    skin.add_mesh(&mut writer, &mesh(), &[]).unwrap();
    let mut smooth = Geometry::subdivision(&mut writer, fox.object, "smooth", 0).unwrap();
    let scheme = Mesh { scheme: Some("catmull-clark".to_owned()), normals: None, ..mesh() };
    smooth.add_mesh(&mut writer, &scheme, &[]).unwrap();
    let mut eye = Geometry::camera(&mut writer, Memory::ROOT, "eye", 0).unwrap();
    eye.add_camera(&mut writer, &camera()).unwrap();
    writer
}

#[test]
fn schemas_are_read_as_they_were_written() {
    let archive = read(scene());
    assert_eq!(archive.metadata.get("_ai_Application"), Some("tests"));
    assert_eq!(archive.range(), Some([0.5, 1.0]));
    let object = |path| &archive.objects[archive.find(path).unwrap_or_else(|| panic!("{path}"))];
    let coat = object("/fox/coat");
    for (time, shift) in [(0.5, 0.0), (0.75, 1.0), (1.0, 1.0)] {
        assert_eq!(Curves::read(&archive, coat, time).unwrap(), curves(shift));
    }
    let found: Vec<Attribute> =
        attributes(coat).iter().map(|property| Attribute::read(&archive, property, 0.6).unwrap()).collect();
    assert_eq!(found, all_attributes());
    let [user] = user_properties(coat) else { panic!("{:?}", user_properties(coat)) };
    assert_eq!(Attribute::read(&archive, user, 9.0).unwrap().number(0, 0), Some(-7.0));
    assert_eq!(visibility(&archive, coat, 0.0).unwrap(), vellus_alembic::Visibility::Hidden);
    assert_eq!(Xform::read(&archive, object("/fox"), 0.75).unwrap(), xform(2.0));
    assert_eq!(Mesh::read(&archive, object("/fox/skin"), 0.0).unwrap(), mesh());
    let smooth = Mesh::read(&archive, object("/fox/smooth"), 0.0).unwrap();
    assert_eq!(smooth.scheme.as_deref(), Some("catmull-clark"));
    assert_eq!(Camera::read(&archive, object("/eye"), 0.0).unwrap(), camera());
}

/// Equal samples are in the file once, whatever property they belong to.
#[test]
fn equal_samples_are_shared() {
    let size = |samples: usize, properties: usize| {
        let mut writer = memory();
        let object = writer.object(Memory::ROOT, "a", &[]).unwrap();
        for i in 0..properties {
            let form = Form::array(Pod::F32, 1, 0);
            let property = writer.property(Owner::Object(object), &format!("p{i}"), &[], form).unwrap();
            (0..samples).for_each(|_| writer.sample(property, &[7; 40_000]).unwrap());
        }
        writer.finish(&[]).unwrap().into_inner().len()
    };
    assert!(size(50, 4) < size(1, 1) + 1000, "{} {}", size(50, 4), size(1, 1));
}

/// All series of samples: constant ones, those that change at the ends or in the middle, and repeated ones.
#[test]
fn samples_that_repeat_keep_their_places() {
    let series: [&[u8]; 9] = [
        &[],
        &[3],
        &[3, 3, 3],
        &[1, 2, 3, 4],
        &[1, 1, 2, 2],
        &[1, 1, 2, 1, 1],
        &[1, 2, 2, 2, 3, 3],
        &[0, 0, 1, 0, 0, 0, 2, 2, 2],
        &[5, 6, 5, 6],
    ];
    let mut writer = memory();
    let times = writer.times(&TimeSampling::Acyclic((0..9).map(f64::from).collect()));
    let object = writer.object(Memory::ROOT, "a", &[]).unwrap();
    for (i, values) in series.iter().enumerate() {
        for (kind, is_array) in [("s", false), ("a", true)] {
            let form = Form { pod: Pod::U8, extent: 1, is_array, times };
            let property = writer.property(Owner::Object(object), &format!("{kind}{i}"), &[], form).unwrap();
            values.iter().for_each(|value| writer.sample(property, &[*value]).unwrap());
        }
    }
    let archive = read(writer);
    for (i, values) in series.iter().enumerate() {
        for kind in ["s", "a"] {
            let property = archive.objects[1].property(&format!("{kind}{i}")).unwrap();
            let series = property.series().unwrap();
            assert_eq!(series.samples as usize, values.len());
            let found = (0..series.samples).map(|sample| archive.sample(series, sample).unwrap().bytes[0]);
            assert_eq!(found.collect::<Vec<_>>(), *values, "{kind}{i}");
        }
    }
}

/// Copies all objects and properties of an archive.
fn copy(archive: &Archive) -> Memory {
    let mut writer = memory();
    let times: Vec<u32> = archive.times.iter().map(|times| writer.times(times)).collect();
    let mut objects = vec![Memory::ROOT];
    for object in &archive.objects {
        let id = match object.parent {
            None => Memory::ROOT,
            Some(parent) => {
                let pairs: Vec<(&str, &str)> = object.metadata.iter().collect();
                let id = writer.object(objects[parent], &object.name, &pairs).unwrap();
                objects.push(id);
                id
            }
        };
        copy_properties(archive, &mut writer, Owner::Object(id), &object.properties, &times);
    }
    writer
}

fn copy_properties(archive: &Archive, writer: &mut Memory, owner: Owner, properties: &[Property], times: &[u32]) {
    for property in properties {
        let pairs: Vec<(&str, &str)> = property.metadata.iter().collect();
        let (series, is_array) = match &property.kind {
            Kind::Compound(children) => {
                let id = writer.compound(owner, &property.name, &pairs).unwrap();
                copy_properties(archive, writer, Owner::Compound(id), children, times);
                continue;
            }
            Kind::Scalar(series) => (series, false),
            Kind::Array(series) => (series, true),
        };
        let form =
            Form { pod: series.pod, extent: series.extent, is_array, times: times[series.time_sampling as usize] };
        let id = writer.property(owner, &property.name, &pairs, form).unwrap();
        for sample in 0..series.samples {
            let sample = archive.sample(series, sample).unwrap();
            match series.pod {
                Pod::Text => {
                    let texts = sample.to_text();
                    writer.sample_text(id, &texts.iter().map(String::as_str).collect::<Vec<_>>()).unwrap();
                }
                _ => writer.sample(id, &sample.bytes).unwrap(),
            }
        }
    }
}

/// Everything of an archive, as text.
fn told(archive: &Archive) -> String {
    fn properties(archive: &Archive, all: &[Property], text: &mut String) {
        for property in all {
            *text += &format!("{} {:?}\n", property.name, property.metadata);
            let Some(series) = property.series() else {
                properties(archive, property.children(), text);
                continue;
            };
            let times = archive.times(series);
            *text += &format!("{:?} {} {times:?}\n", series.pod, series.extent);
            for sample in 0..series.samples {
                *text += &format!("{:?}\n", archive.sample(series, sample).unwrap().bytes);
            }
        }
    }
    let mut text = String::new();
    for (i, Object { metadata, properties: all, .. }) in archive.objects.iter().enumerate() {
        text += &format!("{} {metadata:?}\n", archive.path(i));
        properties(archive, all, &mut text);
    }
    text
}

#[test]
fn a_copy_has_every_property_bit_by_bit() {
    let archive = read(scene());
    let copied = read(copy(&archive));
    assert_eq!(told(&copied), told(&archive));
}

/// From a file, parts are read as they are needed: all of them are the same.
#[test]
fn an_archive_in_a_file_is_the_same_as_in_memory() {
    let bytes = scene().finish(&[]).unwrap().into_inner();
    let mut file = tempfile::tempfile().unwrap();
    std::io::Write::write_all(&mut file, &bytes).unwrap();
    let archive = Archive::open_file(file).unwrap();
    assert_eq!(told(&archive), told(&Archive::open(bytes.clone()).unwrap()));
    for end in (0..bytes.len()).step_by(97) {
        let mut file = tempfile::tempfile().unwrap();
        std::io::Write::write_all(&mut file, &bytes[..end]).unwrap();
        let [short, memory] = [Archive::open_file(file), Archive::open(bytes[..end].to_vec())];
        assert_eq!(short.err(), memory.err(), "{end}");
    }
}

#[test]
fn wrong_names_forms_and_samples_are_errors() {
    let mut writer = memory();
    let object = writer.object(Memory::ROOT, "a", &[]).unwrap();
    for name in ["", "a", "b/c"] {
        assert!(writer.object(Memory::ROOT, name, &[]).is_err(), "{name}");
    }
    assert!(writer.object(Memory::ROOT, "b", &[("x", "1;2")]).is_err());
    let owner = Owner::Object(object);
    let property = writer.property(owner, "p", &[], Form::scalar(Pod::F32, 3, 0)).unwrap();
    assert!(writer.property(owner, "p", &[], Form::scalar(Pod::F32, 3, 0)).is_err());
    assert!(writer.property(owner, "q", &[], Form::scalar(Pod::F32, 3, 1)).is_err());
    assert!(writer.property(Owner::Compound(property), "q", &[], Form::scalar(Pod::F32, 3, 0)).is_err());
    assert!(writer.sample(property, &[0; 24]).is_err() && writer.sample_text(property, &["a"]).is_err());
    assert!(writer.sample(property, &[0; 12]).is_ok());
    let text = writer.property(owner, "t", &[], Form::array(Pod::Text, 1, 0)).unwrap();
    assert!(writer.sample_text(text, &["a\0"]).is_err() && writer.sample(text, &[0; 4]).is_err());
    // Nothing of this is in the archive.
    assert_eq!(read(writer).objects[1].properties.len(), 2);
}

/// The library of Alembic, if it is there. `cargo xtask test` installs it.
fn library() -> Option<Command> {
    let found = succeeds(Command::new("python3").args(["-c", "import alembic3d, imath"]));
    need("alembic", found.map(|()| Command::new("python3")))
}

/// The library reads what is written, and what it writes is read, with the same numbers.
#[test]
fn the_library_of_alembic_reads_and_writes_the_same() {
    let Some(mut python) = library() else { return };
    let folder = tempfile::tempdir().unwrap();
    let [ours, theirs] = ["ours.abc", "theirs.abc"].map(|name| folder.path().join(name));
    std::fs::write(&ours, scene().finish(&[]).unwrap().into_inner()).unwrap();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/reference.py");
    succeeds(python.arg(script).args([&ours, &theirs])).unwrap_or_else(|error| panic!("{error}"));
    let archive = Archive::open_file(std::fs::File::open(theirs).unwrap()).unwrap();
    let object = |path| &archive.objects[archive.find(path).unwrap_or_else(|| panic!("{path}"))];
    let coat = object("/fox/coat");
    for (time, shift) in [(0.5, 0.0), (0.75, 1.0)] {
        let found = Curves::read(&archive, coat, time).unwrap();
        let all = curves(shift);
        assert_eq!((found.positions, found.counts, found.basis), (all.positions, all.counts, all.basis));
        assert_eq!(found.widths.unwrap().values, all.widths.unwrap().values);
    }
    let found: Vec<Attribute> =
        attributes(coat).iter().map(|property| Attribute::read(&archive, property, 0.0).unwrap()).collect();
    let expected = all_attributes();
    for found in &found {
        assert_eq!(Some(found), expected.iter().find(|attribute| attribute.name == found.name), "{}", found.name);
    }
    assert_eq!(found.len(), 3);
    assert_eq!(Xform::read(&archive, object("/fox"), 0.75).unwrap().matrix(), xform(2.0).matrix());
    assert_eq!(Camera::read(&archive, object("/eye"), 0.0).unwrap(), camera());
}
