//! Strands of research data sets: `.data`, `.ply`, `.npy` and `.npz`.

mod data;
mod npy;
mod ply;

use crate::bytes::given_width;
use crate::error::Error;
use glam::{Vec2, Vec3};
use vellus_scene::{Basis, Parameter, Strands, Values};

/// Polylines from a file, with any coordinates.
#[derive(Debug, Default)]
struct Polylines {
    /// The index of the first point of each strand, and the number of points.
    starts: Vec<u32>,
    points: Vec<Vec3>,
    /// Linear RGB of each point.
    colors: Option<Vec<[f32; 3]>>,
    root_uv: Option<Vec<Vec2>>,
}

/// Reads strands of a research data set as [`Basis::Linear`]. The first bytes determine the format: `.ply` (Stanford
/// polygons), `.npy` and `.npz` (NumPy); other files are `.data` (USC-HairSalon).
///
/// `name` is used in messages and becomes the name of the strands. `width` is the diameter in the unit of the file: no
/// such file has widths. Colours of points in a `.ply` file are reflectances, in sRGB if they are whole numbers.
///
/// Strands with one point, or with coordinates of which nothing can be rendered, are there too:
/// [`Strands::remove_broken`] removes them.
///
/// # Errors
/// [`Error::File`] or [`Error::Line`] if the file is invalid, or has no strands. [`Error::NoWidth`] if `width` is
/// `None`. [`Error::Width`] if it is not in [0, 2·10⁹].
pub fn read_research(bytes: &[u8], name: &str, width: Option<f32>) -> Result<Strands, Error> {
    let width = given_width(width)?;
    let Polylines { starts, points, colors, root_uv } = match bytes {
        [b'p', b'l', b'y', b'\n' | b'\r', ..] => ply::read(bytes, name)?,
        [0x93, b'N', b'U', b'M', b'P', b'Y', ..] | [b'P', b'K', 3 | 5, ..] => npy::read(bytes, name)?,
        _ => data::read(bytes, name)?,
    };
    let radius = 0.5 * width.ok_or_else(|| Error::NoWidth { file: name.to_owned() })?;
    Ok(Strands {
        name: name.to_owned(),
        basis: Basis::Linear,
        starts,
        points: points.into_iter().map(|p| p.extend(radius)).collect(),
        moved: None,
        normals: None,
        root_uv,
        look: 0,
        varying: colors.map(|colors| (Parameter::Reflectance, Values::PerPoint(colors))).into_iter().collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn data(strands: &[&[[f32; 3]]]) -> Vec<u8> {
        let mut bytes = (strands.len() as u32).to_le_bytes().to_vec();
        for strand in strands {
            bytes.extend((strand.len() as u32).to_le_bytes());
            bytes.extend(strand.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        }
        bytes
    }

    /// Two strands of two and three points, and one with a single point.
    const STRANDS: [&[[f32; 3]]; 3] = [
        &[[0.0, 0.0, 0.0], [1.0, 0.5, 0.25]],
        &[[2.0, 2.0, 2.0]],
        &[[3.0, 0.0, 0.0], [4.0, 0.0, 0.0], [5.0, 0.0, 1.0]],
    ];

    fn points(strands: &Strands) -> Vec<Vec<[f32; 3]>> {
        (0..strands.len()).map(|i| strands.strand(i).iter().map(|p| p.truncate().to_array()).collect()).collect()
    }

    fn read(bytes: &[u8]) -> Result<Strands, Error> {
        read_research(bytes, "x", Some(0.5))
    }

    fn error(bytes: &[u8]) -> String {
        read(bytes).unwrap_err().to_string()
    }

    #[test]
    fn strands_of_hair_salon_are_read() {
        let mut strands = read(&data(&STRANDS)).unwrap();
        assert_eq!(points(&strands), STRANDS.map(<[_]>::to_vec));
        assert_eq!(strands.points[0].w, 0.25);
        assert_eq!(strands.remove_broken().unwrap().strands, [1]);
        assert!(matches!(read_research(&data(&STRANDS), "x", None), Err(Error::NoWidth { .. })));
        let whole = data(&STRANDS);
        for end in 0..whole.len() {
            assert!(read(&whole[..end]).is_err(), "{end}");
        }
        assert!(error(&[whole.clone(), vec![0]].concat()).contains("1 byte is left"), "{}", error(&whole));
        assert!(error(&[255; 12]).contains("4294967295 strands"), "{}", error(&[255; 12]));
        assert!(error(b"v 0 0 0\nv 1 1 1\n").contains("x, byte"));
    }

    /// Edges in any order and direction of the file, lines, and numbers of strands; text and both byte orders.
    #[test]
    fn strands_of_ply_files_are_read() {
        let expected = [STRANDS[0].to_vec(), STRANDS[2].to_vec()];
        let vertices = "0 0 0\n1 0.5 0.25\n3 0 0\n4 0 0\n5 0 1\n";
        let header = |more: &str| {
            format!(
                "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n{more}"
            )
        };
        let edges = header("element edge 3\nproperty int vertex1\nproperty int vertex2\nend_header\n")
            + vertices
            + "3 4\n0 1\n2 3\n";
        assert_eq!(points(&read(edges.as_bytes()).unwrap()), expected);
        let lines = header("element line 2\nproperty list uchar int vertex_indices\nend_header\n")
            + vertices
            + "2 0 1\n3 2 3 4\n";
        assert_eq!(points(&read(lines.as_bytes()).unwrap()), expected);
        let text = "ply\r\nformat ascii 1.0\r\nelement vertex 5\r\nproperty int strand_id\r\nproperty double x\r\nproperty double y\r\nproperty double z\r\nproperty uchar red\r\nproperty uchar green\r\nproperty uchar blue\r\nend_header\r\n7 0 0 0 255 0 0\r\n7 1 .5 .25 255 0 0\r\n3 3 0 0 0 0 188\r\n3 4 0 0 0 0 188\r\n3 5 0 1 0 0 188\r\n";
        let found = read(text.as_bytes()).unwrap();
        assert_eq!(points(&found), expected);
        let [(Parameter::Reflectance, Values::PerPoint(colors))] = &found.varying[..] else { panic!() };
        assert!(colors[0] == [1.0, 0.0, 0.0] && (colors[4][2] - 0.503).abs() < 1e-3, "{colors:?}");
        for big in [false, true] {
            let order = if big { "big" } else { "little" };
            let mut bytes = header("element edge 3\nproperty int vertex1\nproperty int vertex2\nend_header\n")
                .replace("ascii", &format!("binary_{order}_endian"))
                .into_bytes();
            let mut add = |word: [u8; 4]| {
                bytes.extend(if big { word.iter().rev().copied().collect::<Vec<u8>>() } else { word.to_vec() })
            };
            expected.iter().flatten().flatten().for_each(|x: &f32| add(x.to_le_bytes()));
            [0, 1, 2, 3, 3, 4i32].iter().for_each(|x| add(x.to_le_bytes()));
            assert_eq!(points(&read(&bytes).unwrap()), expected);
            for end in 0..bytes.len() {
                assert!(read(&bytes[..end]).is_err(), "{end}");
            }
        }
        let message = |text: &str| error(text.as_bytes());
        assert!(message(&(header("end_header\n") + vertices)).contains("does not say which points are a strand"));
        let faces =
            header("element face 1\nproperty list uchar int vertex_indices\nend_header\n") + vertices + "3 0 1 2\n";
        assert!(message(&faces).contains("polygons"), "{}", message(&faces));
        for (edges, what) in
            [("0 1\n0 2\n3 4\n", "branch"), ("0 9\n2 3\n3 4\n", "vertex 9"), ("0 1\n2 3\n3 2\n", "loop")]
        {
            let text =
                header("element edge 3\nproperty int vertex1\nproperty int vertex2\nend_header\n") + vertices + edges;
            assert!(message(&text).contains(what), "{edges}: {}", message(&text));
        }
        assert!(
            message("ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty float x\nend_header\n")
                .contains("x, ")
        );
    }

    fn npy(descr: &str, fortran: bool, shape: &str, values: &[u8]) -> Vec<u8> {
        let order = if fortran { "True" } else { "False" };
        let header = format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}\n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.bytes());
        bytes.extend(values);
        bytes
    }

    fn npz(files: &[(&str, Vec<u8>)], deflated: bool) -> Vec<u8> {
        let method = if deflated { zip::CompressionMethod::Deflated } else { zip::CompressionMethod::Stored };
        let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
        for (name, bytes) in files {
            let options = zip::write::SimpleFileOptions::default().compression_method(method);
            zip.start_file(*name, options).unwrap();
            zip.write_all(bytes).unwrap();
        }
        zip.finish().unwrap().into_inner()
    }

    #[test]
    fn arrays_of_numpy_are_read() {
        let numbers: Vec<f32> = (0..18).map(|i| 0.5 * i as f32).collect();
        let expected = [
            vec![[0.0, 0.5, 1.0], [1.5, 2.0, 2.5], [3.0, 3.5, 4.0]],
            vec![[4.5, 5.0, 5.5], [6.0, 6.5, 7.0], [7.5, 8.0, 8.5]],
        ];
        let single: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        let double: Vec<u8> = numbers.iter().flat_map(|x| f64::from(*x).to_be_bytes()).collect();
        let half: Vec<u8> = [
            0u16, 0x3800, 0x3c00, 0x3e00, 0x4000, 0x4100, 0x4200, 0x4300, 0x4400, 0x4480, 0x4500, 0x4580, 0x4600,
            0x4680, 0x4700, 0x4780, 0x4800, 0x4840,
        ]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
        let shape = "(2, 3, 3)";
        for array in
            [npy("<f4", false, shape, &single), npy(">f8", false, shape, &double), npy("<f2", false, shape, &half)]
        {
            assert_eq!(points(&read(&array).unwrap()), expected);
        }
        // The first index is the fastest.
        let at = |i: usize| numbers[9 * (i % 2) + 3 * (i / 2 % 3) + i / 6];
        let turned: Vec<u8> = (0..18).flat_map(|i| at(i).to_le_bytes()).collect();
        assert_eq!(points(&read(&npy("<f4", true, shape, &turned)).unwrap()), expected);
        let uv: Vec<u8> = [0.1f32, 0.2, 0.3, 0.4].iter().flat_map(|x| x.to_le_bytes()).collect();
        for deflated in [false, true] {
            let file = npz(
                &[
                    ("positions.npy", npy("<f4", false, shape, &single)),
                    ("root_uv.npy", npy("<f4", false, "(2, 2)", &uv)),
                    ("other.npy", npy("<i8", false, "(1,)", &[0; 8])),
                ],
                deflated,
            );
            let found = read(&file).unwrap();
            assert_eq!(points(&found), expected);
            assert_eq!(found.root_uv.unwrap()[1], Vec2::new(0.3, 0.4));
            for end in (0..file.len()).step_by(7) {
                assert!(read(&file[..end]).is_err(), "{end}");
            }
        }
        let two =
            npz(&[("a.npy", npy("<f4", false, shape, &single)), ("b.npy", npy("<f4", false, shape, &single))], false);
        assert!(error(&two).contains("a, b"), "{}", error(&two));
        assert!(error(&npy("<f4", false, "(2, 9)", &single)).contains("(2, 9)"));
        assert!(error(&npy("<f4", false, "(9999999999, 9999999, 3)", &single)).contains("x, byte"));
        assert!(error(&npy("|O", false, shape, &single)).contains("|O"));
    }

    /// Changed bytes give an error or other strands, and no end of the program.
    #[test]
    fn damaged_files_do_no_harm() {
        let single: Vec<u8> = (0..18).flat_map(|i| (i as f32).to_le_bytes()).collect();
        let array = npy("<f4", false, "(2, 3, 3)", &single);
        let text = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nelement edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n0 0 0\n1 1 1\n0 1\n";
        for whole in [data(&STRANDS), array.clone(), npz(&[("strands.npy", array)], true), text.as_bytes().to_vec()] {
            for at in 0..whole.len() {
                for byte in [0, 1, 0x7f, 0xff, b' ', b'9'] {
                    let mut bytes = whole.clone();
                    bytes[at] = byte;
                    if let Ok(mut strands) = read(&bytes) {
                        strands.remove_broken();
                        assert!(strands.is_empty() || strands.validate().is_ok());
                    }
                }
            }
        }
    }
}
