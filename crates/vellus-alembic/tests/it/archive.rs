//! The tree, samples and errors of archives.

use crate::writer::*;
use vellus_alembic::*;

fn open(objects: Vec<Obj>) -> Archive {
    Archive::open(archive("FramesPerTimeUnit=25;_ai_Application=test", &[0.0, 1.0, 2.0, 3.0], objects)).unwrap()
}

#[test]
fn objects_have_names_parents_and_metadata() {
    let leaf = |name| Obj::new(name, "AbcGeom_Curve_v2", vec![], vec![]);
    let archive = open(vec![Obj::new("a", "AbcGeom_Xform_v3", vec![], vec![leaf("b"), leaf("c")]), leaf("d")]);
    let paths: Vec<String> = (0..archive.objects.len()).map(|object| archive.path(object)).collect();
    assert_eq!((paths[0].as_str(), paths.len()), ("/", 5));
    for (path, schema) in [("/a", "AbcGeom_Xform_v3"), ("/a/b", "AbcGeom_Curve_v2"), ("/d", "AbcGeom_Curve_v2")] {
        let object = archive.find(path).unwrap();
        assert_eq!((paths[object].as_str(), archive.objects[object].schema()), (path, Some(schema)));
    }
    assert_eq!((archive.find("/a/d"), archive.find("/")), (None, Some(0)));
    assert_eq!(archive.frames_per_second(), Some(25.0));
    assert_eq!(archive.metadata.get("_ai_Application"), Some("test"));
}

/// Seven samples, of which the third to the fifth differ: the file has four.
#[test]
fn equal_samples_at_both_ends_are_stored_once() {
    let stored = (0..4).map(|i| i32s(&[i])).collect();
    let prop = Prop::scalar("x", I32, 1, vec![]).samples(stored).range([7, 2, 4]);
    let archive = open(vec![Obj::new("a", "s", vec![prop], vec![])]);
    let series = archive.objects[1].property("x").and_then(Property::series).unwrap();
    let value = |sample| archive.sample(series, sample).map(|sample| sample.to_i64()[0]);
    assert_eq!((0..7).map(|i| value(i).unwrap()).collect::<Vec<_>>(), [0, 0, 1, 2, 3, 3, 3]);
    assert!(value(7).unwrap_err().to_string().contains("sample 7 is missing: there are 7"));
    assert_eq!((series.is_constant(), archive.times(series).time(2)), (false, 2.0));
}

#[test]
fn each_kind_of_property_is_read() {
    let inner = Prop::compound("inner", vec![Prop::array("names", TEXT, 1, texts(&["a", "", "bc"]))]);
    let props = vec![
        Prop::compound("outer", vec![inner]),
        Prop::array("P", F32, 3, f32s(&[1.0, 2.0, 3.0])).metadata("geoScope=vtx"),
        Prop::scalar("flag", BOOL, 1, vec![1]),
        Prop::array("empty", F32, 3, vec![]),
    ];
    let archive = open(vec![Obj::new("a", "s", props, vec![])]);
    let object = &archive.objects[1];
    let names = object.property("outer").unwrap().child("inner").unwrap().child("names").unwrap();
    assert_eq!(archive.sample(names.series().unwrap(), 0).unwrap().to_text(), ["a", "", "bc"]);
    let points = object.property("P").unwrap();
    let series = points.series().unwrap();
    assert_eq!((series.pod, series.extent, points.metadata.get("geoScope")), (Pod::F32, 3, Some("vtx")));
    assert_eq!(archive.sample(series, 0).unwrap().to_f32(), [1.0, 2.0, 3.0]);
    assert!(matches!(object.property("flag").unwrap().kind, Kind::Scalar(_)));
    assert!(archive.sample(object.property("empty").unwrap().series().unwrap(), 0).unwrap().is_empty());
}

#[test]
fn other_files_are_named() {
    let good = archive("", &[0.0], vec![]);
    let error = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = good.clone();
        change(&mut bytes);
        Archive::open(bytes).unwrap_err()
    };
    assert_eq!(error(&|bytes| bytes.splice(0..4, *b"\x89HDF").for_each(drop)), Error::Hdf5);
    assert!(Error::Hdf5.to_string().contains("abcconvert -toOgawa"));
    assert_eq!(error(&|bytes| bytes[0] = b'o'), Error::NotAlembic);
    assert_eq!(error(&|bytes| bytes.truncate(10)), Error::NotAlembic);
    assert_eq!(error(&|bytes| bytes[5] = 0), Error::NotClosed);
    assert!(matches!(error(&|bytes| bytes[7] = 9), Error::Version { found: 9, .. }));
    assert!(matches!(error(&|bytes| bytes[15] = 1), Error::Damaged { .. }));
}
