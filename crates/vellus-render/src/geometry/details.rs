//! What surfaces have at each point by images: their opacity, and their normals.
//!
//! Whether a ray meets a surface that is not opaque is decided where its hit is found, for rays of the camera, of light
//! and of shadow alike. The chance comes from the bits of the ray and the number of the triangle, so that no state is
//! needed, and the same ray has the same answer. Over many rays, a surface with the opacity o stops the part o of the
//! light.

use crate::geometry::ray::Ray;
use glam::{Vec2, Vec3};
use vellus_scene::{NormalMap, Opacity, Surface, Texture};

/// The details of each surface. Empty if no surface has any.
#[derive(Clone, Debug, Default)]
pub(crate) struct Details(Vec<Detail>);

#[derive(Clone, Debug)]
struct Detail {
    /// The opacity and its image, if rays may pass.
    opacity: Option<(Opacity, Option<Texture>)>,
    normals: Option<(NormalMap, Texture)>,
}

impl Detail {
    fn is_none(&self) -> bool {
        self.opacity.is_none() && self.normals.is_none()
    }
}

impl Details {
    pub fn new(surfaces: &[Surface], textures: &[Texture]) -> Self {
        let detail = |surface: &Surface| {
            let opacity = Some(surface.opacity).filter(|opacity| *opacity != Opacity::FULL);
            Detail {
                opacity: opacity.map(|opacity| (opacity, opacity.texture.map(|index| textures[index].clone()))),
                normals: surface.normals.map(|map| (map, textures[map.texture].clone())),
            }
        };
        let all: Vec<Detail> = surfaces.iter().map(detail).collect();
        if all.iter().all(Detail::is_none) { Details::default() } else { Details(all) }
    }

    /// Whether a surface has details.
    pub fn has(&self, surface: usize) -> bool {
        self.0.get(surface).is_some_and(|detail| !detail.is_none())
    }

    /// Whether rays may pass any surface.
    pub fn any_opacity(&self) -> bool {
        self.0.iter().any(|detail| detail.opacity.is_some())
    }

    /// Whether a ray meets a triangle with this surface at these texture coordinates.
    pub fn stops(&self, surface: usize, uv: Vec2, ray: &Ray, triangle: u32) -> bool {
        let Some((opacity, image)) = self.0.get(surface).and_then(|detail| detail.opacity.as_ref()) else {
            return true;
        };
        let share = opacity.at(image.as_ref().map_or(1.0, |image| image.at(uv)[0]));
        share >= 1.0 || chance(ray, triangle) < share
    }

    /// The normal of a surface at these texture coordinates, not normalized. `normal` is that of the mesh, and `right`
    /// the direction in which u grows, both of unit length. `up` is 1 or −1: the direction in which v grows is that of
    /// normal × right, times it.
    pub fn normal(&self, surface: usize, uv: Vec2, normal: Vec3, right: Vec3, up: f32) -> Option<Vec3> {
        let (map, image) = self.0.get(surface)?.normals.as_ref()?;
        let right = right.reject_from_normalized(normal).try_normalize()?;
        let [x, y, z] = map.at(image.at(uv));
        Some(right * x + normal.cross(right) * (up * y) + normal * z)
    }

    /// Whether a surface has a normal map.
    pub fn bends(&self, surface: usize) -> bool {
        self.0.get(surface).is_some_and(|detail| detail.normals.is_some())
    }
}

/// A number in [0, 1) from a ray and the number of a triangle (PCG: O'Neill 2014, as in Jarzynski and Olano 2020, Hash
/// Functions for GPU Rendering).
fn chance(ray: &Ray, triangle: u32) -> f32 {
    let words = ray.origin.to_array().into_iter().chain(ray.direction.to_array()).chain([ray.time]).map(f32::to_bits);
    let mix = |hash: u32, word: u32| {
        let state = (hash ^ word).wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
        (word >> 22) ^ word
    };
    let hash = words.fold(mix(0, triangle), mix);
    (hash >> 8) as f32 / (1 << 24) as f32
}
