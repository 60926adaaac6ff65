//! Reads Wavefront .obj files: polygons with uv and normals. Materials, curves and free-form surfaces are ignored.
//!
//! Existing crates invent values that a face does not have, or panic on indices that are far out of range.

use crate::error::Error;
use glam::{Vec2, Vec3};
use std::borrow::Cow;
use std::collections::HashMap;
use vellus_scene::{Mesh, triangulate};

/// Reads the meshes of an .obj file, one for each object or group that has faces. Polygons become triangles by
/// [`triangulate`]. `name` is used in messages.
///
/// # Errors
/// [`Error::Line`] if the file is invalid or has no faces.
pub fn read_obj(bytes: &[u8], name: &str) -> Result<Vec<Mesh>, Error> {
    let mut reader = Reader { file: name, line: 0, ..Reader::default() };
    let text = String::from_utf8_lossy(bytes);
    // Removes comments.
    let mut lines = vellus_io::unmarked(&text).lines().map(|line| line.split('#').next().unwrap_or_default()).zip(1..);
    while let Some((line, number)) = lines.next() {
        reader.line = number;
        let mut whole = Cow::Borrowed(line);
        // A backslash at the end of a line continues it on the next line.
        while whole.trim_end().ends_with('\\') {
            let joined = whole.to_mut();
            joined.truncate(joined.trim_end().len() - 1);
            joined.push(' ');
            joined.push_str(lines.next().map_or("", |(line, _)| line));
        }
        let mut words = whole.split_whitespace();
        match words.next() {
            Some("v") => {
                let [x, y, z] = reader.numbers(words)?;
                reader.positions.push(Vec3::new(x, y, z));
            }
            Some("vn") => {
                let [x, y, z] = reader.numbers(words)?;
                reader.normals.push(Vec3::new(x, y, z).normalize_or_zero());
            }
            Some("vt") => {
                let [u, v] = reader.numbers(words)?;
                reader.uv.push(Vec2::new(u, v));
            }
            Some("o" | "g") => {
                reader.close();
                reader.name = words.collect::<Vec<_>>().join(" ");
            }
            Some("f") => reader.face(words)?,
            _ => {}
        }
    }
    reader.close();
    if reader.meshes.is_empty() { Err(reader.fail("it has no faces")) } else { Ok(reader.meshes) }
}

fn shown(word: &str) -> String {
    vellus_io::excerpt(word.as_bytes(), 40)
}

#[derive(Default)]
struct Reader<'a> {
    file: &'a str,
    line: usize,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    uv: Vec<Vec2>,
    /// Name of the current object.
    name: String,
    /// Corners of the triangles of the current object.
    triangles: Vec<[Corner; 3]>,
    meshes: Vec<Mesh>,
}

#[derive(Clone, Copy)]
struct Corner {
    position: usize,
    uv: Option<usize>,
    normal: Option<usize>,
}

impl Reader<'_> {
    fn fail(&self, what: impl Into<String>) -> Error {
        Error::Line { file: self.file.to_owned(), line: self.line, what: what.into() }
    }

    /// The first numbers of a line. Further ones (a weight, a colour) are ignored.
    fn numbers<'w, const N: usize>(&self, mut words: impl Iterator<Item = &'w str>) -> Result<[f32; N], Error> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            let word = words.next().ok_or_else(|| self.fail(format!("{N} numbers are expected")))?;
            *number = word.parse().unwrap_or(f32::NAN);
            if !number.is_finite() {
                return Err(self.fail(format!("{} is not a finite number", shown(word))));
            }
        }
        Ok(numbers)
    }

    fn face<'w>(&mut self, words: impl Iterator<Item = &'w str>) -> Result<(), Error> {
        let corners = words.map(|word| self.corner(word)).collect::<Result<Vec<_>, _>>()?;
        if corners.len() < 3 {
            return Err(self.fail(format!("a face has at least 3 corners, not {}", corners.len())));
        }
        let positions: Vec<Vec3> = corners.iter().map(|corner| self.positions[corner.position]).collect();
        triangulate(&positions, |triangle| self.triangles.push(triangle.map(|i| corners[i])));
        Ok(())
    }

    /// Parses `position`, `position/uv`, `position//normal` or `position/uv/normal`. Indices count from 1. Negative
    /// indices count from the last element.
    fn corner(&self, word: &str) -> Result<Corner, Error> {
        let mut parts = word.split('/');
        let mut index = |kind: &str, there: usize| -> Result<Option<usize>, Error> {
            let Some(part) = parts.next().filter(|part| !part.is_empty()) else { return Ok(None) };
            let given = part.parse::<i64>().ok();
            let from_start =
                given.and_then(|i| if i < 0 { i.checked_add_unsigned(there as u64) } else { i.checked_sub(1) });
            let index = from_start.and_then(|i| usize::try_from(i).ok()).filter(|&i| i < there);
            index.map(Some).ok_or_else(|| {
                let (word, part) = (shown(word), shown(part));
                self.fail(format!("{word}: there is no {kind} {part} of the {there} so far"))
            })
        };
        let position = index("vertex", self.positions.len())?;
        let corner = Corner {
            position: position.ok_or_else(|| self.fail(format!("{}: it has no vertex", shown(word))))?,
            uv: index("uv", self.uv.len())?,
            normal: index("normal", self.normals.len())?,
        };
        Ok(corner)
    }

    /// Creates a mesh of the current faces and their vertices. It has uv or normals only if all corners have them.
    fn close(&mut self) {
        if self.triangles.is_empty() {
            return;
        }
        let triangles = std::mem::take(&mut self.triangles);
        let mut new = HashMap::new();
        let mut positions = Vec::new();
        let mut vertex = |corner: Corner| {
            *new.entry(corner.position).or_insert_with(|| {
                positions.push(self.positions[corner.position]);
                positions.len() as u32 - 1
            })
        };
        let indices = triangles.iter().map(|t| t.map(&mut vertex)).collect();
        let corners = |value: &dyn Fn(Corner) -> Option<usize>| -> Option<Vec<[usize; 3]>> {
            triangles.iter().map(|t| Some([value(t[0])?, value(t[1])?, value(t[2])?])).collect()
        };
        let normals = corners(&|corner| corner.normal);
        let uv = corners(&|corner| corner.uv);
        self.meshes.push(Mesh {
            moved: None,
            name: if self.name.is_empty() { "mesh".to_owned() } else { self.name.clone() },
            triangles: indices,
            normals: normals.map(|n| n.iter().map(|n| n.map(|i| self.normals[i])).collect()),
            uv: uv.map(|uv| uv.iter().map(|uv| uv.map(|i| self.uv[i])).collect()),
            positions,
            surface: 0,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUAD: &str =
        "o a plane\nv 0 0 0 1\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1 # corner\nvn 0 0 2\n";

    #[test]
    fn polygons_with_uv_and_normals_are_read() {
        let file =
            format!("mtllib none.mtl\n{QUAD}usemtl skin\nf 1/1/1 2/2/1 3/3/1 -1/-1/-1\ng empty\ng b\nf 2 3//1 4\n");
        let meshes = read_obj(file.as_bytes(), "a.obj").unwrap();
        let [mesh, bare] = &meshes[..] else { panic!("{meshes:?}") };
        assert_eq!((mesh.name.as_str(), &mesh.triangles[..]), ("a plane", &[[0, 1, 2], [0, 2, 3]][..]));
        assert_eq!(mesh.uv.as_ref().unwrap()[1], [Vec2::ZERO, Vec2::ONE, Vec2::Y]);
        assert_eq!(mesh.normals.as_ref().unwrap()[0], [Vec3::Z; 3]);
        assert_eq!((bare.name.as_str(), &bare.positions[..]), ("b", &[Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y][..]));
        assert!(bare.uv.is_none() && bare.normals.is_none());
        assert!(meshes.iter().all(|mesh| mesh.validate() == Ok(())));
    }

    /// A pentagon of 2 × 2 with a notch of 1.5, from each of its corners.
    #[test]
    fn concave_polygons_do_not_leave_their_outline() {
        for first in 0..5 {
            let face: Vec<String> = (0..5).map(|i| ((first + i) % 5 + 1).to_string()).collect();
            let file = format!("v 0 0 0\nv 2 0 0\nv 2 0 -2\nv 1 0 -0.5\nv 0 0 -2\nf {}", face.join(" "));
            let [mesh] = &read_obj(file.as_bytes(), "notch.obj").unwrap()[..] else { panic!() };
            let mut area = 0.0;
            for triangle in &mesh.triangles {
                let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
                let normal = (b - a).cross(c - a);
                assert!(normal.y > 0.0, "{first}: {:?}", mesh.triangles);
                area += 0.5 * normal.length();
            }
            assert!((area - 2.5).abs() < 1e-6, "{first}: {area}");
        }
    }

    #[test]
    fn a_byte_order_mark_is_skipped() {
        let file = format!("{}f 1 2 3 4", QUAD.split_once('\n').unwrap().1);
        let meshes = read_obj(file.as_bytes(), "a.obj").unwrap();
        assert_eq!(meshes[0].positions.len(), 4);
        assert_eq!(read_obj(format!("\u{feff}{file}").as_bytes(), "a.obj").unwrap(), meshes);
    }

    #[test]
    fn a_backslash_joins_the_next_line() {
        let long = format!("{QUAD}f 1 \\\n 2 3\\\n4 # the last corner \\\nf 1 2 \\ \n 3\nf 9 1 2");
        let error = read_obj(long.as_bytes(), "a.obj").unwrap_err().to_string();
        assert!(error.starts_with("a.obj, line 16: 9:"), "{error}");
        let meshes = read_obj(long.rsplit_once('\n').unwrap().0.as_bytes(), "a.obj").unwrap();
        assert_eq!(meshes[0].triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
        // The last line has no next one.
        assert!(read_obj(format!("{QUAD}f 1 2 3 \\").as_bytes(), "a.obj").is_ok());
    }

    #[test]
    fn garbage_is_cut_and_without_control_characters() {
        let error =
            read_obj(format!("{QUAD}v \u{1b}[2J{}", "x".repeat(1000)).as_bytes(), "a.obj").unwrap_err().to_string();
        assert!(!error.contains('\u{1b}') && error.len() < 120, "{error}");
    }

    #[test]
    fn broken_files_are_errors_with_file_and_line() {
        let bad = [
            ("f 1 2 99", "no vertex 99 of the 4"),
            ("f 1 2 6148914691236517206", "no vertex"),
            ("f 1 2 -9223372036854775808", "no vertex"),
            ("f 1 2 0", "no vertex 0"),
            ("f 1/1/9 2/1/9 3/1/9", "no normal 9"),
            ("f 1/7 2/7 3/7", "no uv 7"),
            ("f 1 2", "at least 3"),
            ("f a b c", "no vertex a"),
            ("f /1 /2 /3", "has no vertex"),
            ("v 1", "3 numbers"),
            ("v 1 nan 0", "nan is not a finite number"),
            ("vt x y", "x is not"),
            ("", "no faces"),
        ];
        for (line, what) in bad {
            let error = read_obj(format!("{QUAD}{line}").as_bytes(), "bad.obj").unwrap_err().to_string();
            assert!(error.starts_with("bad.obj, line ") && error.contains(what), "{line}: {error}");
        }
        assert!(read_obj(&[0xff, 0xfe, b'\n', b'f', b' '], "binary.obj").is_err());
    }
}
