//! All triangles of a scene, for rays: eight to a register (Möller and Trumbore 1997).

use crate::bvh::{Bounds, Bvh, WIDTH};
use crate::ray::Ray;
use glam::{Vec2, Vec3};
use vellus_scene::Mesh;
use wide::f32x8;

/// Up to eight triangles: a corner and two edges. Missing ones have no area.
#[derive(Clone, Debug)]
struct Block {
    corner: [f32x8; 3],
    edges: [[f32x8; 3]; 2],
    /// Triangles, counted over all meshes.
    index: [u32; WIDTH],
}

/// Meshes and the hierarchy over their triangles.
#[derive(Clone, Debug)]
pub struct Triangles {
    meshes: Vec<Mesh>,
    /// Triangles before each of `meshes`.
    offsets: Vec<u32>,
    blocks: Vec<Block>,
    bvh: Bvh,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug)]
pub struct TriangleHit {
    /// Which of the scene's meshes.
    pub mesh: usize,
    /// Distance along the ray.
    pub t: f32,
    /// Unit normal of the plane, on the side the ray comes from.
    pub plane: Vec3,
    /// Unit shading normal, on that side too.
    pub normal: Vec3,
    /// Texture coordinates.
    pub uv: Vec2,
}

fn cross(a: [f32x8; 3], b: [f32x8; 3]) -> [f32x8; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f32x8; 3], b: [f32x8; 3]) -> f32x8 {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

impl Triangles {
    /// Builds the hierarchy; `meshes` must be valid.
    pub fn new(meshes: Vec<Mesh>) -> Self {
        let mut offsets = vec![0u32];
        for mesh in &meshes {
            offsets.push(offsets[offsets.len() - 1] + mesh.triangles.len() as u32);
        }
        let corners = |mesh: &Mesh, t: usize| mesh.triangles[t].map(|v| mesh.positions[v as usize]);
        let all: Vec<[Vec3; 3]> =
            meshes.iter().flat_map(|mesh| (0..mesh.triangles.len()).map(move |t| corners(mesh, t))).collect();
        let boxes: Vec<Bounds> = all.iter().map(|[a, b, c]| (a.min(*b).min(*c), a.max(*b).max(*c))).collect();
        let mut blocks = Vec::new();
        let bvh = Bvh::build(&boxes, |primitives| {
            let mut index = [u32::MAX; WIDTH];
            index.iter_mut().zip(primitives).for_each(|(i, &p)| *i = p);
            let lane = |f: &dyn Fn([Vec3; 3]) -> Vec3, k: usize| {
                f32x8::new(index.map(|i| all.get(i as usize).map_or(0.0, |&corners| f(corners)[k])))
            };
            let vector = |f: &dyn Fn([Vec3; 3]) -> Vec3| [lane(f, 0), lane(f, 1), lane(f, 2)];
            blocks.push(Block {
                corner: vector(&|[a, _, _]| a),
                edges: [vector(&|[a, b, _]| b - a), vector(&|[a, _, c]| c - a)],
                index,
            });
        });
        Triangles { meshes, offsets, blocks, bvh }
    }

    /// The meshes, in the scene's order.
    pub fn meshes(&self) -> &[Mesh] {
        &self.meshes
    }

    /// The first triangle on a ray, from either side.
    pub fn intersect(&self, ray: &Ray) -> Option<TriangleHit> {
        let mut best: Option<(u32, f32, f32, f32)> = None;
        self.bvh.traverse(ray, |_| {}, |leaf, mut limit| {
            let block = &self.blocks[leaf as usize];
            let (mut mask, t, u, v) = block.meet(ray, limit);
            while mask != 0 {
                let lane = mask.trailing_zeros() as usize;
                mask &= mask - 1;
                let t = t.to_array()[lane];
                if t < limit {
                    limit = t;
                    best = Some((block.index[lane], t, u.to_array()[lane], v.to_array()[lane]));
                }
            }
            limit
        });
        best.map(|(index, t, u, v)| self.hit(ray, index, t, u, v))
    }

    /// Is there a triangle on the ray before its limit?
    pub fn occluded(&self, ray: &Ray) -> bool {
        let mut found = false;
        self.bvh.traverse(ray, |_| {}, |leaf, limit| {
            found = self.blocks[leaf as usize].meet(ray, limit).0 != 0;
            if found { -1.0 } else { limit }
        });
        found
    }

    fn hit(&self, ray: &Ray, index: u32, t: f32, u: f32, v: f32) -> TriangleHit {
        let mesh = self.offsets.partition_point(|&offset| offset <= index) - 1;
        let m = &self.meshes[mesh];
        let triangle = (index - self.offsets[mesh]) as usize;
        let [a, b, c] = m.triangles[triangle].map(|v| m.positions[v as usize]);
        let facing = |n: Vec3| if n.dot(ray.direction) > 0.0 { -n } else { n };
        let plane = facing((b - a).cross(c - a).normalize_or(Vec3::Z));
        let w = 1.0 - u - v;
        let smooth = m.normals.as_ref().map(|n| {
            let [a, b, c] = n[triangle];
            (a * w + b * u + c * v).normalize_or(plane)
        });
        // A normal that would face away from the ray, at a silhouette, is the plane's.
        let normal = smooth.map_or(plane, |n| if n.dot(plane) < 0.0 { -n } else { n });
        let normal = if normal.dot(ray.direction) < 0.0 { normal } else { plane };
        let uv = m.uv.as_ref().map_or(Vec2::new(u, v), |uv| {
            let [a, b, c] = uv[triangle];
            a * w + b * u + c * v
        });
        TriangleHit { mesh, t, plane, normal, uv }
    }
}

impl Block {
    /// The lanes a ray meets before `limit`, with distances and barycentric coordinates.
    #[inline]
    fn meet(&self, ray: &Ray, limit: f32) -> (u32, f32x8, f32x8, f32x8) {
        let (zero, one) = (f32x8::ZERO, f32x8::ONE);
        let d = ray.direction.to_array().map(f32x8::splat);
        let o = ray.origin.to_array().map(f32x8::splat);
        let p = cross(d, self.edges[1]);
        let determinant = dot(self.edges[0], p);
        let inverse = one / determinant;
        let s: [f32x8; 3] = std::array::from_fn(|k| o[k] - self.corner[k]);
        let u = dot(s, p) * inverse;
        let q = cross(s, self.edges[0]);
        let v = dot(d, q) * inverse;
        let t = dot(self.edges[1], q) * inverse;
        // Without area, the inverse is infinite and no comparison holds. Edges are a few roundings wide.
        let edge = f32x8::splat(-1e-6);
        let inside = u.simd_ge(edge) & v.simd_ge(edge) & (u + v).simd_le(f32x8::splat(1.000_001));
        let hit = inside & t.simd_gt(zero) & t.simd_lt(f32x8::splat(limit)) & determinant.abs().simd_gt(zero);
        (hit.to_bitmask(), t, u, v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A closed box from inside: every ray meets it where its planes are, no ray gets out.
    #[test]
    fn nothing_leaves_a_closed_box() {
        let positions: Vec<Vec3> =
            (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32)).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        let mesh = Mesh { name: "box".to_owned(), positions, triangles, normals: None, uv: None, surface: 0 };
        let all = Triangles::new(vec![mesh]);
        for i in 0..20_000u32 {
            let noise = |k: u32| ((i as f32 * 12.9898 + k as f32 * 78.233).sin() * 43758.547).rem_euclid(1.0);
            let origin = Vec3::new(noise(1), noise(2), noise(3)) * 0.98 + 0.01;
            let direction = (Vec3::new(noise(4), noise(5), noise(6)) - 0.5).normalize();
            let ray = Ray::new(origin, direction);
            let hit = all.intersect(&ray).unwrap();
            let walls = ((1.0 - origin) / direction).max(-origin / direction);
            assert!((hit.t - walls.min_element()).abs() < 1e-5 && hit.normal.dot(direction) < 0.0);
            assert!(all.occluded(&ray) && !all.occluded(&Ray { limit: hit.t - 1e-5, ..ray }));
        }
    }
}
