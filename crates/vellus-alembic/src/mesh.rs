//! Meshes (IPolyMesh and ISubD).

use crate::archive::{Archive, Object};
use crate::attribute::Attribute;
use crate::error::{Error, wrong};
use crate::geometry::Geometry;

/// A mesh at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// The subdivision scheme, as `catmull-clark`. `None` for polygons.
    pub scheme: Option<String>,
    /// Vertices, in the space of the object.
    pub positions: Vec<[f32; 3]>,
    /// The number of corners of each face. Their sum is the number of indices.
    pub counts: Vec<u32>,
    /// The vertex of each corner, inside of `positions`. Seen from outside, corners are clockwise: the reverse of USD.
    pub indices: Vec<u32>,
    /// The speed of each vertex, per second.
    pub velocities: Option<Vec<[f32; 3]>>,
    /// Texture coordinates.
    pub uv: Option<Attribute>,
    /// Normals of polygons.
    pub normals: Option<Attribute>,
}

impl Mesh {
    /// The beginning of the names of the schema of polygons.
    pub const POLYGONS: &'static str = "AbcGeom_PolyMesh_v";
    /// The beginning of the names of the schema of subdivision surfaces.
    pub const SUBDIVISION: &'static str = "AbcGeom_SubD_v";

    /// Reads a mesh at a time in seconds. Positions are interpolated between samples with the same faces.
    ///
    /// # Errors
    /// [`Error::Damaged`], or [`Error::Property`] if counts or indices do not fit.
    pub fn read(archive: &Archive, object: &Object, time: f64) -> Result<Self, Error> {
        let geometry = Geometry::new(archive, object, ".geom", time)?;
        let steady = geometry.is_steady(&[".faceCounts", ".faceIndices"])?;
        let positions = geometry.vectors("P", steady)?.unwrap_or_default();
        let corners = geometry.integers(".faceIndices")?.unwrap_or_default();
        let counts = geometry.counts(".faceCounts", corners.len(), "corners")?;
        let mut indices = Vec::with_capacity(corners.len());
        for (i, index) in corners.into_iter().enumerate() {
            let vertex = u32::try_from(index).ok().filter(|index| (*index as usize) < positions.len());
            let what = || format!("[{i}] is {index}, but there are {} vertices", positions.len());
            indices.push(vertex.ok_or_else(|| wrong(".faceIndices", what()))?);
        }
        let scheme = match object.schema() {
            Some(schema) if schema.starts_with(Self::SUBDIVISION) => {
                Some(geometry.text(".scheme")?.unwrap_or_else(|| "catmull-clark".to_owned()))
            }
            _ => None,
        };
        let (uv, normals) = (geometry.attribute("uv")?, geometry.attribute("N")?);
        let velocities = geometry.vectors(".velocities", false)?.filter(|v| v.len() == positions.len());
        Ok(Mesh { scheme, positions, counts, indices, velocities, uv, normals })
    }
}
