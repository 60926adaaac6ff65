//! Reads implicit shapes as meshes: spheres, cubes, cylinders, cones, capsules and planes (UsdGeomGprim).

use crate::error::Error;
use crate::read::context::Reader;
use crate::read::mesh::show;
use crate::read::motion::Points;
use crate::read::polygons::Polygons;
use crate::read::primvar::{Interpolation, Primvar};
use crate::read::skeleton::{pose, turn};
use crate::read::surface::surface;
use crate::read::xform::Place;
use crate::stage::{Numbers, When};
use std::f64::consts::{FRAC_PI_2, TAU};

/// The schemas that are read.
pub(crate) const SHAPES: [&str; 8] =
    ["Sphere", "Cube", "Cylinder", "Cylinder_1", "Cone", "Capsule", "Capsule_1", "Plane"];

/// The faces around an axis, and those of half a circle along it. Silhouettes are within 3e-4 of the radius.
const AROUND: usize = 128;
const ALONG: usize = 64;

/// A point of a profile: its radius, its place on the axis, and the normal in the same directions.
type Ring = [f64; 4];

/// Reads a shape.
pub(crate) fn read(reader: &mut Reader, place: &Place) -> Result<(), Error> {
    let prim = place.path.as_str();
    let stage = reader.stage;
    reader.prim(prim)?;
    let word = |name: &str| stage.words(prim, name).map(|words| words.unwrap_or_default().into_iter().next());
    let left_handed = word("orientation")?.as_deref() == Some("leftHanded");
    let axis = match word("axis")?.as_deref() {
        Some("X") => 0,
        Some("Y") => 1,
        None | Some("Z") => 2,
        Some(other) => {
            reader.warnings.add(prim, format!("axis is {other}: it must be X, Y or Z; Z is used"));
            2
        }
    };
    let at = |when: When| -> Result<Option<Polygons>, Error> {
        let mut valid = true;
        let mut number = |name: &str, fallback: f64| -> Result<f64, Error> {
            let given = stage.precise(prim, name, when)?;
            let value = given.map_or(fallback, |v| if v.len() == 1 { v[0] } else { f64::NAN });
            valid &= value.is_finite() && value >= 0.0;
            Ok(value)
        };
        let shape = match place.type_name.as_str() {
            "Cube" => cube(number("size", 2.0)?),
            "Plane" => plane(number("width", 2.0)?, number("length", 2.0)?, axis),
            "Sphere" => {
                let radius = number("radius", 1.0)?;
                revolve(&[arc([-FRAC_PI_2, FRAC_PI_2], radius, 0.0, ALONG)], 2)
            }
            "Cylinder" => {
                let (radius, height) = (number("radius", 1.0)?, number("height", 2.0)?);
                revolve(&frustum([radius; 2], height), axis)
            }
            "Cylinder_1" => {
                let radii = [number("radiusBottom", 1.0)?, number("radiusTop", 1.0)?];
                revolve(&frustum(radii, number("height", 2.0)?), axis)
            }
            "Cone" => {
                let (radius, height) = (number("radius", 1.0)?, number("height", 2.0)?);
                revolve(&frustum([radius, 0.0], height), axis)
            }
            "Capsule" => {
                let radius = number("radius", 0.5)?;
                revolve(&capsule([radius; 2], number("height", 1.0)?), axis)
            }
            _ => {
                let radii = [number("radiusBottom", 0.5)?, number("radiusTop", 0.5)?];
                revolve(&capsule(radii, number("height", 1.0)?), axis)
            }
        };
        Ok(valid.then_some(shape))
    };
    let moves = stage.clock().close != stage.clock().open;
    let (open, close) = (at(When::Open)?, if moves { at(When::Close)? } else { None });
    let Some(mut shape) = open.filter(|_| !moves || close.is_some()) else {
        return Err(Error::prim(prim, "its size must be finite and not negative"));
    };
    let points =
        Points { open: std::mem::take(&mut shape.open), close: close.map(|close| close.open), base: When::Open };
    let Points { open, close, base: _ } = pose(reader, prim, points)?;
    (shape.open, shape.close) = (open, close);
    turn(reader, prim, &mut shape)?;
    let surface = surface(reader, prim)?;
    show(reader, place, left_handed, shape, &[surface])
}

/// A sphere of radius 1.
pub(crate) fn sphere() -> Polygons {
    revolve(&[arc([-FRAC_PI_2, FRAC_PI_2], 1.0, 0.0, ALONG)], 2)
}

/// An arc of a circle around a point of the axis.
fn arc(angles: [f64; 2], radius: f64, z: f64, steps: usize) -> Vec<Ring> {
    let at = |i: usize| {
        let (sin, cos) = (angles[0] + (angles[1] - angles[0]) * i as f64 / steps as f64).sin_cos();
        // A pole is exactly on the axis.
        let cos = if cos.abs() < 1e-15 { 0.0 } else { cos };
        [radius * cos, z + radius * sin, cos, sin]
    };
    (0..=steps).map(at).collect()
}

/// The straight side between two radii.
fn side([bottom, top]: [f64; 2], height: f64) -> Vec<Ring> {
    let (slope, length) = (bottom - top, height.hypot(bottom - top).max(f64::MIN_POSITIVE));
    let normal = [height / length, slope / length];
    vec![[bottom, -0.5 * height, normal[0], normal[1]], [top, 0.5 * height, normal[0], normal[1]]]
}

/// A cylinder, cone or frustum with its ends.
fn frustum(radii: [f64; 2], height: f64) -> Vec<Vec<Ring>> {
    let (low, high) = (-0.5 * height, 0.5 * height);
    let bottom = vec![[0.0, low, 0.0, -1.0], [radii[0], low, 0.0, -1.0]];
    let top = vec![[radii[1], high, 0.0, 1.0], [0.0, high, 0.0, 1.0]];
    let strips = [bottom, side(radii, height), top];
    // A cone has no top.
    strips.into_iter().filter(|strip| strip[0][0] > 0.0 || strip[1][0] > 0.0).collect()
}

/// A cylinder with half spheres at its ends. `height` is without them.
fn capsule(radii: [f64; 2], height: f64) -> Vec<Vec<Ring>> {
    let bottom = arc([-FRAC_PI_2, 0.0], radii[0], -0.5 * height, ALONG / 2);
    let top = arc([0.0, FRAC_PI_2], radii[1], 0.5 * height, ALONG / 2);
    vec![bottom, side(radii, height), top]
}

fn primvar(values: Vec<f32>, lanes: usize, interpolation: Interpolation) -> Primvar {
    Primvar { values: Numbers { values, lanes }, interpolation, space: None }
}

/// A surface of revolution about an axis (0 to 2), of profiles from the bottom to the top. u goes around, v along.
fn revolve(strips: &[Vec<Ring>], axis: usize) -> Polygons {
    let (mut points, mut normals, mut uv) = (Vec::new(), Vec::new(), Vec::new());
    let (mut counts, mut indices) = (Vec::new(), Vec::new());
    // x, y and z keep their cyclic order.
    let place = |[x, y, z]: [f64; 3]| {
        let mut turned = [0.0; 3];
        [x, y, z].into_iter().enumerate().for_each(|(k, value)| turned[(k + axis + 1) % 3] = value as f32);
        turned
    };
    let step = |pair: &[Ring]| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
    let whole: f64 = strips.iter().flat_map(|strip| strip.windows(2).map(step)).sum();
    let mut length = 0.0;
    for strip in strips {
        for (i, ring) in strip.iter().enumerate() {
            let first = points.len() as i64;
            if i > 0 {
                length += step(&strip[i - 1..=i]);
            }
            for k in 0..=AROUND {
                // The last point is exactly the first one.
                let (sin, cos) = (TAU * (k % AROUND) as f64 / AROUND as f64).sin_cos();
                let [r, z, nr, nz] = *ring;
                points.push(place([r * cos, r * sin, z]));
                normals.extend(place([nr * cos, nr * sin, nz]));
                uv.extend([k as f32 / AROUND as f32, if whole > 0.0 { (length / whole) as f32 } else { 0.0 }]);
            }
            let row = AROUND as i64 + 1;
            for k in (0..AROUND as i64).filter(|_| i > 0) {
                let (low, high) = (first - row + k, first + k);
                let face = [low, low + 1, high + 1, high];
                // Faces at a pole are triangles.
                let is_pole = [strip[i - 1][0] == 0.0, ring[0] == 0.0];
                let corners =
                    face.iter().enumerate().filter(|(c, _)| !(is_pole[0] && *c == 1 || is_pole[1] && *c == 2));
                let before = indices.len();
                indices.extend(corners.map(|(_, corner)| *corner));
                counts.push((indices.len() - before) as i64);
            }
        }
    }
    // Two poles in a row have no faces.
    let is_face: Vec<bool> = counts.iter().map(|n| *n >= 3).collect();
    let mut rest = is_face.iter().zip(&counts).flat_map(|(is_face, n)| std::iter::repeat_n(*is_face, *n as usize));
    indices.retain(|_| rest.next().unwrap_or(false));
    counts.retain(|n| *n >= 3);
    Polygons {
        counts,
        indices,
        holes: Vec::new(),
        parts: Vec::new(),
        open: points,
        close: None,
        normals: Some(primvar(normals, 3, Interpolation::Vertex)),
        uv: Some(primvar(uv, 2, Interpolation::Vertex)),
    }
}

/// Squares or rectangles with their own uv.
fn quads(points: Vec<[f32; 3]>, indices: Vec<i64>) -> Polygons {
    let faces = indices.len() / 4;
    let uv = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0].repeat(faces);
    Polygons {
        counts: vec![4; faces],
        indices,
        holes: Vec::new(),
        parts: Vec::new(),
        open: points,
        close: None,
        normals: None,
        uv: Some(primvar(uv, 2, Interpolation::FaceVarying)),
    }
}

fn cube(size: f64) -> Polygons {
    let half = (0.5 * size) as f32;
    let corner = |i: usize| std::array::from_fn(|k| if i >> k & 1 == 1 { half } else { -half });
    let sides = [1, 3, 7, 5, 0, 4, 6, 2, 2, 6, 7, 3, 0, 1, 5, 4, 4, 5, 7, 6, 0, 2, 3, 1];
    quads((0..8).map(corner).collect(), sides.to_vec())
}

/// A rectangle across an axis. Its width is along x and its length along y, or along z where the axis has their place.
fn plane(width: f64, length: f64, axis: usize) -> Polygons {
    let [w, l] = [width, length].map(|size| (0.5 * size) as f32);
    let place = |[x, y]: [f32; 2]| match axis {
        0 => [0.0, y * l, -x * w],
        1 => [x * w, 0.0, -y * l],
        _ => [x * w, y * l, 0.0],
    };
    quads([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(place).to_vec(), vec![0, 1, 2, 3])
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use std::f64::consts::PI;

    /// The volume of a closed surface, which is positive if its faces are seen from outside. Normals must agree.
    fn volume(shape: &Polygons) -> f64 {
        let mut rest = &shape.indices[..];
        let point = |i: i64| DVec3::from(shape.open[i as usize].map(f64::from));
        let mut sum = 0.0;
        for &count in &shape.counts {
            let (face, after) = rest.split_at(count as usize);
            rest = after;
            for pair in face[1..].windows(2) {
                let [a, b, c] = [point(face[0]), point(pair[0]), point(pair[1])];
                sum += a.dot(b.cross(c)) / 6.0;
                if let Some(normals) = &shape.normals {
                    let n = normals.values.row(face[0] as usize);
                    let n = DVec3::new(n[0].into(), n[1].into(), n[2].into());
                    assert!((b - a).cross(c - a).normalize().dot(n) > 0.99, "{a} {b} {c} {n}");
                }
            }
        }
        assert!(rest.is_empty());
        sum
    }

    /// Polygons inside round shapes have 1 − π²·2/(3·128²) of the volume for each round direction.
    #[test]
    fn shapes_have_their_volumes_and_face_outward() {
        let near = |shape: &Polygons, expected: f64| {
            let volume = volume(shape);
            assert!((volume / expected - 1.0).abs() < 2e-3, "{volume} {expected}");
        };
        for axis in 0..3 {
            near(&revolve(&[arc([-FRAC_PI_2, FRAC_PI_2], 2.0, 0.0, ALONG)], axis), 4.0 / 3.0 * PI * 8.0);
            near(&revolve(&frustum([0.5, 0.5], 3.0), axis), PI * 0.25 * 3.0);
            near(&revolve(&frustum([2.0, 0.0], 3.0), axis), PI * 4.0);
            near(&revolve(&frustum([2.0, 1.0], 3.0), axis), PI * (4.0 + 2.0 + 1.0));
            near(&revolve(&capsule([0.5, 0.5], 2.0), axis), PI * (0.5 + 4.0 / 3.0 * 0.125));
        }
        near(&cube(3.0), 27.0);
        for axis in 0..3 {
            let shape = plane(4.0, 2.0, axis);
            let [a, b, c] = [0, 1, 2].map(|i| DVec3::from(shape.open[i].map(f64::from)));
            assert_eq!((b - a).cross(c - a)[axis], 8.0);
        }
    }

    /// Shapes without a size have no faces, or flat ones.
    #[test]
    fn empty_shapes_are_consistent() {
        for shape in [
            revolve(&frustum([0.0, 0.0], 0.0), 0),
            revolve(&capsule([0.0, 0.0], 1.0), 1),
            revolve(&[arc([-FRAC_PI_2, FRAC_PI_2], 0.0, 0.0, ALONG)], 2),
            cube(0.0),
        ] {
            assert_eq!(shape.counts.iter().sum::<i64>() as usize, shape.indices.len());
            assert!(shape.uv.unwrap().values.values.iter().all(|x| x.is_finite()));
        }
    }
}
