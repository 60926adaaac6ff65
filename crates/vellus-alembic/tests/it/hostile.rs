//! Damaged archives are errors: nothing panics, and memory and time are bounded by the file.

use crate::writer::*;
use vellus_alembic::*;

/// Reads everything at three times.
fn read_all(bytes: Vec<u8>) {
    let Ok(archive) = Archive::open(bytes) else { return };
    for (i, object) in archive.objects.iter().enumerate() {
        assert!(archive.find(&archive.path(i)).is_some() || !archive.path(i).is_empty());
        for time in [-1.0, 0.5, 1e300] {
            let _ = Curves::read(&archive, object, time);
            let _ = Mesh::read(&archive, object, time);
            let _ = Camera::read(&archive, object, time);
            let _ = Xform::read(&archive, object, time).map(|xform| xform.matrix());
            let _ = visibility(&archive, object, time);
            let _ = instance_source(&archive, object);
            for property in attributes(object).iter().chain(user_properties(object)) {
                if let Ok(attribute) = Attribute::read(&archive, property, time) {
                    let last = attribute.rows();
                    let _ = (attribute.number(last, 0), attribute.text(last), attribute.number(usize::MAX, 0));
                }
            }
        }
    }
}

/// An archive with every schema.
fn whole() -> Vec<u8> {
    let points = f32s(&[0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0]);
    let p = || Prop::array("P", F32, 3, vec![]).samples(vec![points.clone(), points.iter().map(|b| b / 2).collect()]);
    let uv = Prop::compound(
        "uv",
        vec![Prop::array(".vals", F32, 2, f32s(&[0.0, 1.0])), Prop::array(".indices", U32, 1, i32s(&[0, 0]))],
    );
    let names = Prop::array("groom_group_name", TEXT, 1, texts(&["a", "b"])).metadata("geoScope=uni;arrayExtent=1");
    let curves = Prop::compound(
        ".geom",
        vec![
            p(),
            Prop::array("nVertices", I32, 1, i32s(&[2, 2])),
            Prop::scalar("curveBasisAndType", U8, 4, vec![1, 0, 0, 0]),
            uv,
            Prop::compound(".arbGeomParams", vec![names]),
        ],
    );
    let mesh = Prop::compound(
        ".geom",
        vec![
            p(),
            Prop::array(".faceIndices", I32, 1, i32s(&[0, 1, 3, 2])),
            Prop::array(".faceCounts", I32, 1, i32s(&[4])),
        ],
    );
    let camera = Prop::compound(".geom", vec![Prop::scalar(".core", F64, 16, f64s(&[1.0; 16]))]);
    let xform = Prop::compound(
        ".xform",
        vec![Prop::scalar(".ops", U8, 2, vec![0x30, 0x20]), Prop::scalar(".vals", F64, 20, f64s(&[0.5; 20]))],
    );
    let children = vec![
        Obj::new("c", "AbcGeom_Curve_v2", vec![curves, Prop::scalar("visible", I8, 1, vec![1])], vec![]),
        Obj::new("m", "AbcGeom_PolyMesh_v1", vec![mesh], vec![]),
        Obj::new("v", "AbcGeom_Camera_v1", vec![camera], vec![]),
        Obj::instance("i", "/x/c"),
    ];
    archive("FramesPerTimeUnit=24", &[0.0, 1.0], vec![Obj::new("x", "AbcGeom_Xform_v3", vec![xform], children)])
}

#[test]
fn every_truncation_is_read_or_refused() {
    let bytes = whole();
    (0..bytes.len()).for_each(|length| read_all(bytes[..length].to_vec()));
}

/// Four thousand archives with one to four changed bytes.
#[test]
fn changed_bytes_are_read_or_refused() {
    let bytes = whole();
    // Steele, Lea and Flood: SplitMix64.
    let mut state = 1u64;
    let mut next = |below: usize| {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) % below as u64) as usize
    };
    for _ in 0..4000 {
        let mut changed = bytes.clone();
        for _ in 0..=next(4) {
            let at = next(changed.len());
            changed[at] = match next(3) {
                0 => changed[at] ^ (1 << next(8)),
                1 => [0, 1, 255][next(3)],
                _ => next(256) as u8,
            };
        }
        read_all(changed);
    }
}

/// A group that is its own child, and groups that share their children: 2⁶⁴ objects in a small file.
#[test]
fn shared_groups_use_up_their_budget() {
    let mut bytes = archive("", &[0.0], vec![Obj::new("a", "s", vec![], vec![])]);
    let header = |count: u8| {
        let mut header = Vec::new();
        for i in 0..count {
            header.extend([1, 0, 0, 0, b'a' + i, 0]);
        }
        header.extend([0; 32]);
        header
    };
    let mut data = |content: &[u8]| {
        let at = bytes.len() as u64;
        bytes.extend((content.len() as u64).to_le_bytes());
        bytes.extend(content);
        at
    };
    let [one, two] = [1, 2].map(|count| data(&header(count)) | 1 << 63);
    let group = |bytes: &mut Vec<u8>, children: &[u64]| {
        let at = bytes.len() as u64;
        bytes.extend((children.len() as u64).to_le_bytes());
        children.iter().for_each(|child| bytes.extend(child.to_le_bytes()));
        at
    };
    let root = |bytes: &mut Vec<u8>, objects: u64| {
        let old = u64::from_le_bytes(bytes[8..16].try_into().unwrap()) as usize;
        // The third child of the root.
        bytes[old + 24..old + 32].copy_from_slice(&objects.to_le_bytes());
        Archive::open(bytes.clone()).unwrap_err().to_string()
    };
    let mut looped = bytes.clone();
    let own = looped.len() as u64;
    group(&mut looped, &[1 << 63, own, one]);
    let error = root(&mut looped, own);
    assert!(error.contains("inside each other") || error.contains("than fit in the file"), "{error}");
    let mut doubled = bytes.clone();
    let mut last = 0;
    for _ in 0..64 {
        last = group(&mut doubled, &[1 << 63, last, last, two]);
    }
    assert!(root(&mut doubled, last).contains("than fit in the file"));
}
