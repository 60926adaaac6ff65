//! Polygons as meshes of triangles.

use super::place::{Place, normal_of};
use super::{Reader, Skipped};
use glam::{DMat3, Vec2, Vec3};
use vellus_alembic::{Attribute, Mesh};
use vellus_scene::triangulate;

/// A triangle: the corners among those of all faces, and their vertices.
struct Triangle {
    corners: [usize; 3],
    vertices: [u32; 3],
}

/// Reads a mesh. Its surface is the first one of the scene.
pub(super) fn read(reader: &mut Reader, place: &Place) -> Result<vellus_scene::Mesh, Skipped> {
    let archive = reader.archive;
    let object = &archive.objects[place.object];
    let [open, close] = reader.times;
    let mesh = Mesh::read(archive, object, open)?;
    if mesh.positions.is_empty() || mesh.counts.is_empty() {
        return Err(Skipped::part("it has no faces"));
    }
    if !place.is_regular() {
        return Err(Skipped::part("its transform flattens it: no scale may be 0"));
    }
    reader
        .note(place, mesh.scheme.as_ref().map(|_| "it is a subdivision surface: its control mesh is shown".to_owned()));
    let later = (close > open).then(|| Mesh::read(archive, object, close)).transpose()?;
    let later = later.filter(|later| (&later.counts, &later.indices) == (&mesh.counts, &mesh.indices));
    let positions = place.open(&mesh.positions);
    let moved = later.map(|later| place.close(&later.positions)).filter(|later| *later != positions);
    // Corners of Alembic are clockwise. A transform that mirrors turns them.
    let linear = DMat3::from_mat4(place.to_world);
    let triangles = triangles(&mesh, &positions, linear.determinant() > 0.0);
    let normal = normal_of(&place.to_world);
    let found = vellus_scene::Mesh {
        name: place.path.clone(),
        positions,
        moved,
        normals: mesh.normals.as_ref().and_then(|normals| corners(&mesh, &triangles, normals, normal)),
        uv: mesh.uv.as_ref().and_then(|uv| corners(&mesh, &triangles, uv, Vec2::from)),
        triangles: triangles.iter().map(|triangle| triangle.vertices).collect(),
        surface: 0,
    };
    found.validate().map_err(|error| Skipped::part(error.to_string()))?;
    Ok(found)
}

/// The triangles of all faces. Faces with fewer than three corners have none.
fn triangles(mesh: &Mesh, positions: &[Vec3], flipped: bool) -> Vec<Triangle> {
    let mut triangles = Vec::with_capacity(mesh.indices.len());
    let (mut polygon, mut first) = (Vec::new(), 0);
    for count in &mesh.counts {
        let own = &mesh.indices[first..first + *count as usize];
        polygon.clear();
        polygon.extend(own.iter().map(|vertex| positions[*vertex as usize]));
        triangulate(&polygon, |[a, b, c]| {
            let corners = if flipped { [a, c, b] } else { [a, b, c] };
            triangles.push(Triangle { corners: corners.map(|i| first + i), vertices: corners.map(|i| own[i]) });
        });
        first += own.len();
    }
    triangles
}

/// Values at the corners of the triangles, if the attribute has one for each vertex or corner.
fn corners<T, const N: usize>(
    mesh: &Mesh,
    triangles: &[Triangle],
    attribute: &Attribute,
    convert: impl Fn([f32; N]) -> T,
) -> Option<Vec<[T; 3]>> {
    let rows = attribute.rows();
    let by_corner = rows == mesh.indices.len();
    if attribute.lanes != N || !(by_corner || rows == mesh.positions.len()) {
        return None;
    }
    let of = |triangle: &Triangle, corner: usize| {
        let row = if by_corner { triangle.corners[corner] } else { triangle.vertices[corner] as usize };
        convert(std::array::from_fn(|lane| attribute.number(row, lane).unwrap_or_default() as f32))
    };
    Some(triangles.iter().map(|triangle| std::array::from_fn(|corner| of(triangle, corner))).collect())
}
