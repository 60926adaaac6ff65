//! Triangle meshes and their surfaces.

use crate::error::{Error, invalid};
use crate::strands::{MAX_COORDINATE, is_within};
use glam::{Vec2, Vec3};

/// A colour, or the product of a texture and a colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tint {
    /// Linear RGB, in [0, 1].
    pub color: [f32; 3],
    /// Index of a texture in the scene.
    pub texture: Option<usize>,
}

/// How much of a surface is there: rays pass it by chance where the opacity is below 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opacity {
    /// The opacity, or the factor of the texture; in [0, 1].
    pub value: f32,
    /// Index of a texture in the scene, whose first channel counts.
    pub texture: Option<usize>,
    /// In [0, 1]. If positive, opacities from it on are 1, and others are 0.
    pub threshold: f32,
}

impl Opacity {
    /// That of a surface without holes.
    pub const FULL: Opacity = Opacity { value: 1.0, texture: None, threshold: 0.0 };

    /// The opacity where the texture has this value, in [0, 1].
    pub fn at(&self, texel: f32) -> f32 {
        let opacity = self.value * texel;
        if self.threshold > 0.0 { f32::from(u8::from(opacity >= self.threshold)) } else { opacity.clamp(0.0, 1.0) }
    }
}

/// Normals by an image. Coordinates of the normal are right (where u grows), up (where v grows) and outward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalMap {
    /// Index of a texture in the scene.
    pub texture: usize,
    /// The factors of its channels, finite; usually 2.
    pub scale: [f32; 3],
    /// What is added, finite; usually −1.
    pub bias: [f32; 3],
}

impl NormalMap {
    /// The normal where the texture has these values; not normalized.
    pub fn at(&self, texel: [f32; 3]) -> [f32; 3] {
        std::array::from_fn(|c| texel[c] * self.scale[c] + self.bias[c])
    }
}

/// The surface of a mesh: a diffuse base under a rough dielectric coat, or metal, as in UsdPreviewSurface.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Name for messages.
    pub name: String,
    /// Colour of the diffuse base or of the metal.
    pub color: Tint,
    /// Emitted radiance, linear RGB.
    pub emission: [f32; 3],
    /// Roughness, from 0 (mirror) to 1.
    pub roughness: f32,
    /// From 0 (dielectric) to 1 (metal).
    pub metallic: f32,
    /// Refractive index of the coat, in [1, 4]. 1 means no coat.
    pub ior: f32,
    /// How much of it is there.
    pub opacity: Opacity,
    /// An image of its normals.
    pub normals: Option<NormalMap>,
    /// Whether it is skin that has the colour of the coat that grows on it, times [`SKIN`]. A renderer then replaces
    /// the colour where strands grow.
    pub skin: bool,
}

/// The colour of skin under a coat, relative to that of the coat: skin has less pigment than hair, and lies in its
/// shadow.
pub const SKIN: f32 = 0.8;

impl Surface {
    /// A diffuse surface without a coat. `color` is linear RGB in [0, 1].
    pub fn diffuse(name: impl Into<String>, color: [f32; 3]) -> Self {
        let color = Tint { color, texture: None };
        Surface {
            name: name.into(),
            color,
            emission: [0.0; 3],
            roughness: 1.0,
            metallic: 0.0,
            ior: 1.0,
            opacity: Opacity::FULL,
            normals: None,
            skin: false,
        }
    }
}

/// A triangle mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Name for messages.
    pub name: String,
    /// Positions of the vertices.
    pub positions: Vec<Vec3>,
    /// The vertices when the shutter closes, as many as `positions`. `None` if they do not move.
    pub moved: Option<Vec<Vec3>>,
    /// Three vertex indices for each triangle, counterclockwise when seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Shading normals of the corners of each triangle; without them it is flat.
    pub normals: Option<Vec<[Vec3; 3]>>,
    /// Texture coordinates of the corners of each triangle.
    pub uv: Option<Vec<[Vec2; 3]>>,
    /// Index of the surface in the scene.
    pub surface: usize,
}

impl Mesh {
    /// Checks that array lengths and indices are consistent, that all numbers are finite, and that coordinates are at
    /// most [`MAX_COORDINATE`].
    ///
    /// # Errors
    /// [`Error::Invalid`] for the first problem.
    pub fn validate(&self) -> Result<(), Error> {
        let fail = |what: String| Err(invalid(&self.name, what));
        if let Some(i) = self.positions.iter().position(|p| !is_within(*p)) {
            let [x, y, z] = self.positions[i].to_array();
            return fail(format!(
                "vertex {i} is ({x:?}, {y:?}, {z:?}): it must be finite and within ±{MAX_COORDINATE:e}"
            ));
        }
        if self.moved.as_ref().is_some_and(|m| m.len() != self.positions.len() || !m.iter().all(|p| is_within(*p))) {
            let what = "there must be as many moved vertices as vertices, all finite and within";
            return fail(format!("{what} ±{MAX_COORDINATE:e}"));
        }
        if let Some(i) = self.triangles.iter().position(|t| t.iter().any(|&v| v as usize >= self.positions.len())) {
            return fail(format!(
                "triangle {i} has a vertex index out of range: there are {} vertices",
                self.positions.len()
            ));
        }
        let wrong = |n: Option<usize>| n.is_some_and(|n| n != self.triangles.len());
        if wrong(self.normals.as_ref().map(Vec::len)) || wrong(self.uv.as_ref().map(Vec::len)) {
            return fail("normals and uv must have one entry for each triangle".to_owned());
        }
        let normal = |i: &usize| self.normals.as_ref().is_some_and(|n| n[*i].iter().any(|n| !n.is_finite()));
        let uv = |i: &usize| self.uv.as_ref().is_some_and(|uv| uv[*i].iter().any(|uv| !uv.is_finite()));
        if let Some(i) = (0..self.triangles.len()).find(|i| normal(i) || uv(i)) {
            return fail(format!("triangle {i} has a normal or uv that is not finite"));
        }
        Ok(())
    }
}
