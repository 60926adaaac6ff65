//! Converts the surface of a body to triangles with surface nets (Gibson 1998): one vertex in each grid cell that the
//! surface intersects, projected onto the surface.

use crate::body::Body;
use glam::{IVec3, Vec2, Vec3};
use rayon::prelude::*;
use std::collections::HashMap;
use vellus_scene::Mesh;

/// The surface of a body with smooth normals, from a grid of cells of width `step`. `uv` returns texture coordinates.
pub(crate) fn polygonize(body: &Body, step: f32, name: &str, uv: &(dyn Fn(Vec3) -> Vec2 + Sync)) -> Mesh {
    let (low, high) = body.bounds();
    let origin = low - Vec3::splat(2.0 * step);
    let size = ((high - low) / step).ceil().as_ivec3() + IVec3::splat(5);
    let at = |i: IVec3| origin + step * i.as_vec3();
    let layer = (size.x * size.y) as usize;
    let values: Vec<f32> = (0..size.z)
        .into_par_iter()
        .flat_map_iter(|z| (0..layer as i32).map(move |i| body.distance(at(IVec3::new(i % size.x, i / size.x, z)))))
        .collect();
    let value = |i: IVec3| values[i.z as usize * layer + (i.y * size.x + i.x) as usize];

    // One vertex in each cell with corners of both signs: the mean of the intersections of the surface with its edges.
    let mut positions = Vec::new();
    let mut vertex_of = HashMap::new();
    for cell in cells(size - 1) {
        let corners: [f32; 8] = std::array::from_fn(|c| value(cell + corner(c)));
        if corners.iter().all(|&d| d < 0.0) || corners.iter().all(|&d| d >= 0.0) {
            continue;
        }
        let (mut sum, mut count) = (Vec3::ZERO, 0.0);
        for a in 0..8 {
            for bit in [1, 2, 4] {
                let b = a | bit;
                if b != a && (corners[a] < 0.0) != (corners[b] < 0.0) {
                    let t = corners[a] / (corners[a] - corners[b]);
                    sum += corner(a).as_vec3().lerp(corner(b).as_vec3(), t);
                    count += 1.0;
                }
            }
        }
        vertex_of.insert(cell, positions.len() as u32);
        positions.push(at(cell) + step * sum / count);
    }

    // One quad for each edge of the grid that the surface intersects, between the four cells around it.
    let mut triangles = Vec::new();
    for cell in cells(size - 1) {
        for axis in 0..3 {
            let (u, v) = (unit((axis + 1) % 3), unit((axis + 2) % 3));
            let inside = value(cell) < 0.0;
            if inside == (value(cell + unit(axis)) < 0.0) || cell.dot(u) == 0 || cell.dot(v) == 0 {
                continue;
            }
            let around = [cell - u - v, cell - v, cell, cell - u];
            let Some([a, b, c, d]) = four(around.map(|cell| vertex_of.get(&cell).copied())) else { continue };
            let quad = if inside { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
            triangles.extend(quad);
        }
    }

    positions.par_iter_mut().for_each(|p| {
        // A vertex moves by less than a cell, so triangles do not fold at creases.
        let moved = body.project(*p);
        if moved.distance(*p) < step {
            *p = moved;
        }
    });
    let normals: Vec<Vec3> = positions.par_iter().map(|&p| body.gradient(p).normalize_or(Vec3::Y)).collect();
    let coordinates: Vec<Vec2> = positions.par_iter().map(|&p| uv(p)).collect();
    Mesh {
        name: name.to_owned(),
        normals: Some(triangles.iter().map(|t: &[u32; 3]| t.map(|v| normals[v as usize])).collect()),
        uv: Some(triangles.iter().map(|t| t.map(|v| coordinates[v as usize])).collect()),
        positions,
        triangles,
        moved: None,
        surface: 0,
    }
}

fn cells(size: IVec3) -> impl Iterator<Item = IVec3> {
    (0..size.z).flat_map(move |z| (0..size.y).flat_map(move |y| (0..size.x).map(move |x| IVec3::new(x, y, z))))
}

fn corner(c: usize) -> IVec3 {
    IVec3::new((c & 1) as i32, (c >> 1 & 1) as i32, (c >> 2) as i32)
}

fn unit(axis: usize) -> IVec3 {
    [IVec3::X, IVec3::Y, IVec3::Z][axis]
}

fn four(vertices: [Option<u32>; 4]) -> Option<[u32; 4]> {
    let [Some(a), Some(b), Some(c), Some(d)] = vertices else { return None };
    Some([a, b, c, d])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Flow;
    use glam::Quat;

    /// The area and the volume of a sphere are correct, so its triangles close it and all face outward.
    #[test]
    fn a_sphere_is_closed_and_faces_outward() {
        let body = Body::default().ellipsoid([1.0, 2.0, 3.0], [2.0; 3], Quat::IDENTITY, 0.0, Flow::Along(Vec3::X), 1.0);
        let mesh = polygonize(&body, 0.1, "sphere", &|_| Vec2::ZERO);
        assert_eq!(mesh.validate(), Ok(()));
        let corner = |v: u32| mesh.positions[v as usize] - Vec3::new(1.0, 2.0, 3.0);
        let (mut area, mut volume) = (0.0, 0.0);
        for &[a, b, c] in &mesh.triangles {
            let (a, b, c) = (corner(a), corner(b), corner(c));
            area += 0.5 * (b - a).cross(c - a).length();
            volume += a.dot(b.cross(c)) / 6.0;
        }
        // Chords of a tenth of a unit on a radius of 2 give an error of order (0.1/2)²/4.
        assert!((area / (16.0 * std::f32::consts::PI) - 1.0).abs() < 2e-3, "{area}");
        assert!((volume / (32.0 / 3.0 * std::f32::consts::PI) - 1.0).abs() < 2e-3, "{volume}");
    }
}
