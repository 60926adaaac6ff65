//! Files of strands: written strands are read back, a damaged file gives an error with its place, and nothing panics.

use glam::Vec4;
use rand::{Rng, RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use vellus_groom::{Error, HairHeader, hair_header, read_hair, read_tfx, write_hair};
use vellus_scene::{Basis, Parameter, Strands, Values};
use vellus_testing::{small_tfx, tfx};

fn strands() -> Strands {
    let point = |i: usize| Vec4::new((i as f32).sin(), i as f32 * 0.25, -1.5, 0.01 + 0.001 * i as f32);
    Strands {
        name: "test.hair".to_owned(),
        basis: Basis::Linear,
        starts: vec![0, 2, 7, 11],
        points: (0..11).map(point).collect(),
        moved: None,
        normals: None,
        root_uv: None,
        look: 0,
        varying: vec![(Parameter::Reflectance, Values::PerPoint(vec![[0.25, 0.5, 0.75]; 11]))],
    }
}

#[test]
fn hair_files_are_read_as_written() {
    let mut strands = strands();
    let bytes = write_hair(&strands).unwrap();
    assert_eq!(read_hair(&bytes, "test.hair", None).unwrap(), strands);
    // Widths of points replace a width given for files without widths.
    assert_eq!(read_hair(&bytes, "test.hair", Some(9.0)).unwrap(), strands);
    strands.basis = Basis::CatmullRom;
    strands.starts = vec![0, 11];
    assert!(write_hair(&strands).unwrap_err().to_string().contains("flatten"));
}

#[test]
fn widths_come_from_the_caller_or_the_default_of_a_hair_file() {
    let mut bytes = write_hair(&strands()).unwrap();
    let without_defaults = HairHeader { transparency: Some(0.0), ..HairHeader::default() };
    assert_eq!(hair_header(&bytes, "test.hair").unwrap(), without_defaults);
    // Segments and points only.
    bytes[12] = 3;
    bytes.truncate(128 + 2 * 3 + 12 * 11);
    let error = read_hair(&bytes, "test.hair", None).unwrap_err();
    assert_eq!(error, Error::NoWidth { file: "test.hair".to_owned() });
    assert!(error.to_string().contains("--width"));
    assert_eq!(read_hair(&bytes, "test.hair", Some(0.5)).unwrap().points[3].w, 0.25);
    bytes[20..24].copy_from_slice(&3f32.to_le_bytes());
    assert_eq!(read_hair(&bytes, "test.hair", None).unwrap().points[3].w, 1.5);
    let header = HairHeader { thickness: Some(3.0), transparency: Some(0.0), color: Some([0.5; 3]) };
    assert_eq!(hair_header(&bytes, "test.hair").unwrap(), header);
    // A width of 0 is for strands that are only measured.
    assert_eq!(read_hair(&bytes, "test.hair", Some(0.0)).unwrap().points[3].w, 0.0);
    for width in [-1.0, f32::NAN, f32::INFINITY, 1e30] {
        assert!(matches!(read_hair(&bytes, "test.hair", Some(width)), Err(Error::Width(_))));
    }
}

#[test]
fn equal_strands_need_no_segment_counts() {
    let mut bytes = vec![0; 128];
    bytes[..4].copy_from_slice(b"HAIR");
    for (at, word) in [(4, 2u32), (8, 6), (12, 2), (16, 2), (20, 1f32.to_bits())] {
        bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
    }
    bytes.resize(128 + 6 * 12, 0);
    let strands = read_hair(&bytes, "equal", None).unwrap();
    assert_eq!((strands.starts, strands.points.len()), (vec![0, 3, 6], 6));
}

#[test]
fn errors_name_the_place_of_the_damage() {
    let good = write_hair(&strands()).unwrap();
    type Damage = fn(&mut Vec<u8>);
    let damages: [(Damage, &str); 5] = [
        (|b| b.truncate(100), "1 header of 128 bytes belong here, but 100 bytes are left"),
        (|b| b[0] = b'X', "byte 0: a .hair file begins with HAIR"),
        (|b| b.truncate(200), "byte 134: 11 points of 12 bytes belong here, but 66 bytes are left"),
        (|b| b[4..8].copy_from_slice(&10_000_000u32.to_le_bytes()), "byte 4: 10000000 strands do not fit"),
        (|b| b[130] = 200, "byte 130: strand 1 ends at point 203, but there are 11"),
    ];
    for (damage, message) in damages {
        let mut bytes = good.clone();
        damage(&mut bytes);
        let error = read_hair(&bytes, "bad.hair", None).unwrap_err().to_string();
        assert!(error.starts_with("bad.hair, byte") && error.contains(message), "{error}");
    }
}

/// A strand with one point, one with NaN and one with a negative thickness.
#[test]
fn broken_strands_are_read_and_can_be_removed() {
    let good = write_hair(&strands()).unwrap();
    type Damage = fn(&mut Vec<u8>);
    let damages: [Damage; 2] = [
        |b| b[134..138].copy_from_slice(&f32::NAN.to_le_bytes()),
        |b| b[266..270].copy_from_slice(&(-1f32).to_le_bytes()),
    ];
    for damage in damages {
        let mut bytes = good.clone();
        damage(&mut bytes);
        let mut strands = read_hair(&bytes, "bad.hair", None).unwrap();
        let before = strands.len();
        assert_eq!((strands.remove_broken().unwrap().strands, strands.len()), (vec![0], before - 1));
        assert_eq!(strands.validate(), Ok(()));
    }
    let mut bytes = vec![0; 128];
    bytes[..4].copy_from_slice(b"HAIR");
    for (at, word) in [(4, 2u32), (8, 3), (12, 3), (20, 1f32.to_bits())] {
        bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
    }
    bytes.extend([1, 0, 0, 0]);
    bytes.resize(132 + 3 * 12, 0);
    let mut strands = read_hair(&bytes, "point.hair", None).unwrap();
    assert_eq!((strands.remove_broken().unwrap().strands, strands.len()), (vec![1], 1));
}

#[test]
fn tfx_files_of_both_versions_are_read() {
    for version in [3.0, 4.0] {
        let strands = read_tfx(&small_tfx(version), "a.tfx", Some(0.1)).unwrap();
        assert_eq!(strands.validate(), Ok(()));
        assert_eq!((strands.len(), strands.segments()), (3, 9));
        assert_eq!(
            strands.points[1],
            Vec4::new(1.5, 2.0, 2.5, 0.05) + if version < 4.0 { Vec4::ZERO } else { Vec4::new(0.5, 0.5, 0.5, 0.0) }
        );
        assert_eq!(strands.root_uv.unwrap()[1].to_array(), [0.25, 0.375]);
        assert!(matches!(read_tfx(&small_tfx(version), "a.tfx", None), Err(Error::NoWidth { .. })));
    }
    let error = read_tfx(&small_tfx(2.0), "a.tfx", Some(0.1)).unwrap_err().to_string();
    assert!(error.contains("byte 0: version 2 of TressFX"), "{error}");
    let mut huge = small_tfx(4.0);
    huge[4..8].copy_from_slice(&10_000_000u32.to_le_bytes());
    assert!(read_tfx(&huge, "a.tfx", Some(0.1)).unwrap_err().to_string().contains("40000000 points of 16 bytes"));
}

/// Thousands of damaged files. Each gives valid strands or an error. No reader panics, or allocates memory for a wrong
/// count.
#[test]
fn damaged_files_never_panic() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
    let files = [write_hair(&strands()).unwrap(), small_tfx(3.0), small_tfx(4.0)];
    let mut errors = 0;
    for round in 0..6000 {
        let kind = round % 3;
        let mut bytes = files[kind].clone();
        for _ in 0..rng.random_range(1..5) {
            // Headers are the critical part: half of the damage goes there.
            let end = if rng.random() { 160.min(bytes.len()) } else { bytes.len() };
            let at = rng.random_range(0..end.max(1));
            match rng.random_range(0..4) {
                0 => bytes.truncate(at),
                1 => bytes.splice(at..at, [rng.random::<u8>(); 3]).for_each(drop),
                2 if at + 4 <= bytes.len() => {
                    let word = [0, u32::MAX, 0x7fff_ffff, 0x8000_0000, f32::NAN.to_bits()][rng.random_range(0..5)];
                    bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
                }
                _ if at < bytes.len() => bytes[at] = rng.next_u64() as u8,
                _ => {}
            }
            if bytes.is_empty() {
                break;
            }
        }
        let read = if kind == 0 { read_hair } else { read_tfx };
        match read(&bytes, "damaged", Some(0.1)) {
            Ok(mut strands) => {
                strands.remove_broken();
                assert_eq!(strands.validate(), Ok(()));
            }
            Err(error) => {
                errors += 1;
                assert!(error.to_string().starts_with("damaged, byte"), "{error}");
            }
        }
    }
    assert!((500..6000).contains(&errors), "{errors} of 6000 were errors");
}

/// Guide strands as games have them: without widths and uv, and a .hair file keeps them all.
#[test]
fn guide_strands_become_a_hair_file() {
    const STRANDS: usize = 48_113;
    let numbers = (0..STRANDS * 4 * 3).map(|i| (i as f32 * 0.618).fract() * 100.0);
    let bytes = tfx(3.0, [STRANDS, 4], numbers, false);
    let guides = read_tfx(&bytes, "guides.tfx", Some(0.02)).unwrap();
    assert_eq!((guides.validate(), guides.root_uv.is_none()), (Ok(()), true));
    assert_eq!((guides.len(), guides.segments()), (STRANDS, 3 * STRANDS));
    // Each strand has two bytes for its number of segments, and 4 points with widths.
    let bytes = write_hair(&guides).unwrap();
    assert_eq!(bytes.len(), 128 + STRANDS * (2 + 4 * 16));
    assert_eq!(read_hair(&bytes, "guides.tfx", None).unwrap(), guides);
}
