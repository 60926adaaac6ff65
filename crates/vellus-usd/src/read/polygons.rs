//! Polygons with values at their corners or points: what a mesh or a shape is before it becomes triangles.

use crate::read::primvar::Primvar;

/// Polygons. Their counts and indices are consistent, and all coordinates are finite.
pub(crate) struct Polygons {
    /// The number of corners of each face, at least 3.
    pub counts: Vec<i64>,
    /// The point of each corner.
    pub indices: Vec<i64>,
    /// The faces that are not shown.
    pub holes: Vec<i64>,
    /// The part of each face; empty if there is one part.
    pub parts: Vec<usize>,
    /// The points when the shutter opens.
    pub open: Vec<[f32; 3]>,
    /// The points when the shutter closes, as many; `None` if both times are the same.
    pub close: Option<Vec<[f32; 3]>>,
    /// Shading normals.
    pub normals: Option<Primvar>,
    /// Texture coordinates; or colours, with three lanes, of a mesh whose surface has no texture.
    pub uv: Option<Primvar>,
}
