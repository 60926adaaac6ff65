//! All triangles of a scene, prepared for rays: SIMD tests eight of them at once (Möller and Trumbore 1997).

use crate::geometry::bvh::{Bounds, Bvh, EMPTY, NONE, WIDTH, join};
use crate::geometry::details::Details;
use crate::geometry::ray::Ray;
use glam::{Mat3, Vec2, Vec3};
use rayon::prelude::*;
use std::array::from_fn;
use std::sync::Arc;
use vellus_scene::Mesh;
use wide::f32x8;

/// A corner and two edges of eight triangles. Missing triangles have no area.
pub(crate) type Shape = [[f32x8; 3]; 3];

/// Up to eight triangles.
#[derive(Clone, Debug)]
struct Block {
    /// When the shutter opens.
    shape: Shape,
    /// The numbers of the triangles, counted over all meshes.
    index: [u32; WIDTH],
}

/// Meshes with a hierarchy over their triangles. It finds where rays hit them.
#[derive(Clone, Debug)]
pub struct Triangles {
    meshes: Vec<Mesh>,
    /// The number of triangles before each of `meshes`.
    offsets: Vec<u32>,
    blocks: Vec<Block>,
    /// Shapes of the blocks when the shutter closes, if anything moves.
    closed: Vec<Shape>,
    bvh: Bvh,
    /// The details of surfaces, if any mesh has some.
    details: Arc<Details>,
    /// Whether rays may pass meshes.
    passes: bool,
}

/// Where a ray hits a triangle.
#[derive(Clone, Copy, Debug)]
pub struct TriangleHit {
    /// Index of the mesh in the scene.
    pub mesh: usize,
    /// Distance along the ray.
    pub t: f32,
    /// Unit normal of the plane, on the side that the ray comes from.
    pub plane: Vec3,
    /// Unit shading normal, on the same side.
    pub normal: Vec3,
    /// Texture coordinates.
    pub uv: Vec2,
    /// The motion of the point while the shutter is open.
    pub movement: Vec3,
}

fn cross(a: [f32x8; 3], b: [f32x8; 3]) -> [f32x8; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f32x8; 3], b: [f32x8; 3]) -> f32x8 {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

impl Triangles {
    /// Builds the hierarchy, on all cores.
    ///
    /// # Panics
    /// May panic if [`Mesh::validate`] returns an error.
    pub fn new(meshes: Vec<Mesh>) -> Self {
        let mut offsets = vec![0u32];
        for mesh in &meshes {
            offsets.push(offsets[offsets.len() - 1] + mesh.triangles.len() as u32);
        }
        let count = offsets[meshes.len()] as usize;
        let mut all = Triangles {
            meshes,
            offsets,
            blocks: Vec::new(),
            closed: Vec::new(),
            bvh: Bvh::build(0, |_| EMPTY).0,
            details: Arc::default(),
            passes: false,
        };
        let bounds = |i: u32, time: f32| -> Bounds {
            let [a, b, c] = all.corners(i, time);
            (a.min(b).min(c), a.max(b).max(c))
        };
        let (mut bvh, leaves) = Bvh::build(count, |i| bounds(i as u32, 0.5));
        let blocks = leaves.par_iter().map(|&index| Block { shape: all.shape(&index, 0.0), index }).collect();
        let mut closed = Vec::new();
        if all.meshes.iter().any(|mesh| mesh.moved.is_some()) {
            let leaf = |leaf: usize, time: f32| {
                leaves[leaf].iter().filter(|&&i| i != NONE).map(|&i| bounds(i, time)).fold(EMPTY, join)
            };
            bvh.set_motion([&|l| leaf(l, 0.0), &|l| leaf(l, 1.0)]);
            closed = leaves.par_iter().map(|index| all.shape(index, 1.0)).collect();
        }
        (all.blocks, all.closed, all.bvh) = (blocks, closed, bvh);
        all
    }

    /// Gives meshes the details of their surfaces.
    pub(crate) fn detail(&mut self, details: &Arc<Details>) {
        if self.meshes.iter().any(|mesh| details.has(mesh.surface)) {
            self.details = details.clone();
            self.passes = details.any_opacity();
        }
    }

    /// The mesh of a triangle, and its index in the mesh.
    fn place(&self, index: u32) -> (usize, usize) {
        let mesh = self.offsets.partition_point(|&offset| offset <= index) - 1;
        (mesh, (index - self.offsets[mesh]) as usize)
    }

    fn corners(&self, index: u32, time: f32) -> [Vec3; 3] {
        let (mesh, triangle) = self.place(index);
        let mesh = &self.meshes[mesh];
        mesh.triangles[triangle].map(|v| {
            let open = mesh.positions[v as usize];
            mesh.moved.as_ref().map_or(open, |moved| open.lerp(moved[v as usize], time))
        })
    }

    fn shape(&self, index: &[u32; WIDTH], time: f32) -> Shape {
        let corners = index.map(|i| if i == NONE { [Vec3::ZERO; 3] } else { self.corners(i, time) });
        let lanes = |f: fn([Vec3; 3]) -> Vec3| [0, 1, 2].map(|k| f32x8::new(corners.map(|c| f(c)[k])));
        [lanes(|[a, _, _]| a), lanes(|[a, b, _]| b - a), lanes(|[a, _, c]| c - a)]
    }

    /// The meshes, in the scene's order.
    pub fn meshes(&self) -> &[Mesh] {
        &self.meshes
    }

    /// The triangles of each leaf when the shutter opens and when it closes.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = ([&Shape; 2], [u32; WIDTH])> {
        let all = self.blocks.iter().enumerate();
        all.map(|(i, block)| ([&block.shape, self.closed.get(i).unwrap_or(&block.shape)], block.index))
    }

    /// The hierarchy.
    pub(crate) fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// Whether anything moves.
    pub fn moves(&self) -> bool {
        !self.closed.is_empty()
    }

    /// The nearest hit of a ray on either side of a triangle.
    pub fn intersect(&self, ray: &Ray) -> Option<TriangleHit> {
        let mut best: Option<(u32, f32, f32, f32)> = None;
        self.bvh.traverse(
            ray,
            |_| {},
            |leaf, mut t_max| {
                let block = &self.blocks[leaf as usize];
                let (mut mask, t, u, v) = self.meet(leaf, ray, t_max);
                while mask != 0 {
                    let lane = mask.trailing_zeros() as usize;
                    mask &= mask - 1;
                    let [t, u, v] = [t, u, v].map(|lanes| lanes.to_array()[lane]);
                    if t < t_max && self.stops(ray, block.index[lane], u, v) {
                        t_max = t;
                        best = Some((block.index[lane], t, u, v));
                    }
                }
                t_max
            },
        );
        best.map(|(index, t, u, v)| self.hit(ray, index, t, u, v))
    }

    /// Whether a ray hits a triangle within the ray's length.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.any(ray, |_, mask| mask != 0)
    }

    /// As [`Triangles::occluded`], for the meshes that `casts` accepts.
    pub fn occluded_by(&self, ray: &Ray, casts: impl Fn(usize) -> bool) -> bool {
        self.any(ray, |index, mask| (0..WIDTH).any(|lane| mask >> lane & 1 != 0 && casts(self.place(index[lane]).0)))
    }

    /// Whether `blocks` accepts a leaf, from its triangles and a mask of those that the ray hits.
    fn any(&self, ray: &Ray, blocks: impl Fn(&[u32; WIDTH], u32) -> bool) -> bool {
        let mut found = false;
        self.bvh.traverse(
            ray,
            |_| {},
            |leaf, t_max| {
                let index = &self.blocks[leaf as usize].index;
                let (mut mask, _, u, v) = self.meet(leaf, ray, t_max);
                if mask != 0 && self.passes {
                    let [u, v] = [u, v].map(|lanes| lanes.to_array());
                    let stops =
                        |lane: &usize| mask >> lane & 1 != 0 && self.stops(ray, index[*lane], u[*lane], v[*lane]);
                    mask = (0..WIDTH).filter(stops).fold(0, |mask, lane| mask | 1 << lane);
                }
                found = blocks(index, mask);
                if found { -1.0 } else { t_max }
            },
        );
        found
    }

    /// The normal by the normal map of a mesh, which has texture coordinates. Where they are the same at two corners,
    /// it is that of the mesh.
    fn bent(&self, mesh: &Mesh, triangle: usize, corners: [Vec3; 3], uv: Vec2, smooth: Option<Vec3>) -> Option<Vec3> {
        let [a, b, c] = mesh.uv.as_ref()?[triangle];
        let [p, q, r] = corners;
        let (ab, ac) = (b - a, c - a);
        let area = ab.perp_dot(ac);
        let right = ((q - p) * ac.y - (r - p) * ab.y) * area.signum();
        let normal = smooth.or(scaled_normal(corners).try_normalize())?;
        let bent = self.details.normal(mesh.surface, uv, normal, right.try_normalize()?, area.signum());
        bent.and_then(Vec3::try_normalize)
    }

    /// Whether a ray does not pass a triangle that it hits.
    fn stops(&self, ray: &Ray, index: u32, u: f32, v: f32) -> bool {
        if !self.passes {
            return true;
        }
        let (mesh, triangle) = self.place(index);
        let mesh = &self.meshes[mesh];
        self.details.stops(mesh.surface, uv(mesh, triangle, u, v), ray, index)
    }

    fn meet(&self, leaf: u32, ray: &Ray, t_max: f32) -> (u32, f32x8, f32x8, f32x8) {
        let open = &self.blocks[leaf as usize].shape;
        let Some(closed) = self.closed.get(leaf as usize) else { return meet(open, ray, t_max) };
        let (early, late) = (f32x8::splat(1.0 - ray.time), f32x8::splat(ray.time));
        let now: Shape = from_fn(|i| from_fn(|k| open[i][k].mul_add(early, closed[i][k] * late)));
        meet(&now, ray, t_max)
    }

    fn hit(&self, ray: &Ray, index: u32, t: f32, u: f32, v: f32) -> TriangleHit {
        let (mesh, triangle) = self.place(index);
        let m = &self.meshes[mesh];
        let corners = self.corners(index, ray.time);
        let facing = |n: Vec3| if n.dot(ray.direction) > 0.0 { -n } else { n };
        let plane = facing(scaled_normal(corners).normalize_or(Vec3::Z));
        let w = 1.0 - u - v;
        let uv = uv(m, triangle, u, v);
        let smooth = m.normals.as_ref().map(|n| {
            let [a, b, c] = n[triangle];
            let n = a * w + b * u + c * v;
            let n = if m.moved.is_some() { carried(n, self.corners(index, 0.0), corners) } else { n };
            n.normalize_or(plane)
        });
        let bends = self.details.bends(m.surface);
        let smooth = if bends { self.bent(m, triangle, corners, uv, smooth).or(smooth) } else { smooth };
        // At a silhouette, a shading normal may face away from the ray. The normal of the plane then replaces it.
        let normal = smooth.map_or(plane, |n| if n.dot(plane) < 0.0 { -n } else { n });
        let normal = if normal.dot(ray.direction) < 0.0 { normal } else { plane };
        let movement = m.moved.as_ref().map_or(Vec3::ZERO, |moved| {
            let [a, b, c] = m.triangles[triangle].map(|v| moved[v as usize] - m.positions[v as usize]);
            a * w + b * u + c * v
        });
        TriangleHit { mesh, t, plane, normal, uv, movement }
    }
}

/// The texture coordinates of a point of a triangle.
fn uv(mesh: &Mesh, triangle: usize, u: f32, v: f32) -> Vec2 {
    mesh.uv.as_ref().map_or(Vec2::new(u, v), |uv| {
        let [a, b, c] = uv[triangle];
        a * (1.0 - u - v) + b * u + c * v
    })
}

/// The normal of a triangle, with twice its area as length.
fn scaled_normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a)
}

/// Transforms a normal with its triangle. Its components along the edges and the plane's normal stay the same.
fn carried(n: Vec3, from: [Vec3; 3], to: [Vec3; 3]) -> Vec3 {
    let frame = |corners: [Vec3; 3]| {
        let [a, b, c] = corners;
        Mat3::from_cols(b - a, c - a, scaled_normal(corners).normalize_or_zero())
    };
    let (from, to) = (frame(from), frame(to));
    to.transpose().inverse() * (from.transpose() * n)
}

/// A bit mask of the triangles that a ray hits before `t_max`, their distances, and their barycentric coordinates.
#[inline]
fn meet([corner, edges @ ..]: &Shape, ray: &Ray, t_max: f32) -> (u32, f32x8, f32x8, f32x8) {
    let (zero, one) = (f32x8::ZERO, f32x8::ONE);
    let d = ray.direction.to_array().map(f32x8::splat);
    let o = ray.origin.to_array().map(f32x8::splat);
    let p = cross(d, edges[1]);
    let determinant = dot(edges[0], p);
    let inverse = one / determinant;
    let s: [f32x8; 3] = from_fn(|k| o[k] - corner[k]);
    let u = dot(s, p) * inverse;
    let q = cross(s, edges[0]);
    let v = dot(d, q) * inverse;
    let t = dot(edges[1], q) * inverse;
    // For triangles without area, the inverse is infinite and no comparison is true. Edges are a few rounding errors
    // wide.
    let edge = f32x8::splat(-1e-6);
    let inside = u.simd_ge(edge) & v.simd_ge(edge) & (u + v).simd_le(f32x8::splat(1.000_001));
    let hit = inside & t.simd_gt(zero) & t.simd_lt(f32x8::splat(t_max)) & determinant.abs().simd_gt(zero);
    (hit.to_bitmask(), t, u, v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use vellus_scene::{NormalMap, Opacity, Surface, Texture, Wrap};

    /// A square from 0 to 1 in x and y, with these texture coordinates, and an opacity.
    fn square(opacity: Opacity, textures: &[Texture]) -> Triangles {
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        let triangles = vec![[0, 1, 2], [0, 2, 3]];
        let at = |v: u32| positions[v as usize].truncate();
        let uv = Some(triangles.iter().map(|corners: &[u32; 3]| corners.map(at)).collect());
        let mesh = Mesh { name: "square".to_owned(), positions, triangles, normals: None, uv, surface: 0, moved: None };
        let mut all = Triangles::new(vec![mesh]);
        all.detail(&Arc::new(Details::new(&[Surface { opacity, ..Surface::diffuse("s", [0.5; 3]) }], textures)));
        all
    }

    /// Of 40,000 rays, the part that the surface stops has a standard error of at most 0.0025. Five of them are
    /// exceeded by chance in one of two million cases. Two squares behind one another stop independently.
    #[test]
    fn rays_pass_surfaces_by_chance() {
        for share in [0.0, 0.1, 0.5, 0.9, 1.0] {
            let all = square(Opacity { value: share, ..Opacity::FULL }, &[]);
            let behind = square(Opacity { value: share, ..Opacity::FULL }, &[]);
            let (mut nearest, mut shadows, mut both) = (0, 0, 0);
            for i in 0..40_000 {
                let (x, y) = ((i % 200) as f32 / 200.0 + 1e-3, (i / 200) as f32 / 200.0 + 1e-3);
                let ray = Ray::new(Vec3::new(x, y, 2.0), Vec3::new(0.0, 0.0, -1.0));
                let stopped = all.intersect(&ray).is_some();
                // The same ray has the same answer.
                assert_eq!(all.intersect(&ray).is_some(), stopped);
                assert_eq!(all.occluded(&ray), stopped);
                nearest += i32::from(stopped);
                let other = Ray::new(Vec3::new(x, y, 1.0), Vec3::new(1e-3, 0.0, -1.0).normalize());
                let shadow = behind.occluded(&other);
                shadows += i32::from(shadow);
                both += i32::from(shadow && stopped);
            }
            let near = |count: i32, expected: f32| (count as f32 / 40_000.0 - expected).abs() <= 0.0125;
            assert!(near(nearest, share) && near(shadows, share) && near(both, share * share), "{share}");
        }
    }

    /// A normal that leans to growing u, and one that leans to growing v, from both sides, on a square whose image is
    /// as wide as it, mirrored, or turned by a right angle.
    #[test]
    fn a_normal_map_follows_the_texture_coordinates() {
        type Map = fn(Vec2) -> Vec2;
        let maps: [(Map, Vec3, Vec3); 3] = [
            (|p| p, Vec3::X, Vec3::Y),
            (|p| Vec2::new(1.0 - p.x, p.y), Vec3::NEG_X, Vec3::Y),
            (|p| Vec2::new(p.y, 3.0 - 2.0 * p.x), Vec3::Y, Vec3::NEG_X),
        ];
        for (map, right, up) in maps {
            for (texel, lean) in [([0.8, 0.5, 0.9], right), ([0.5, 0.8, 0.9], up)] {
                let texture = Texture {
                    name: String::new(),
                    width: 1,
                    height: 1,
                    pixels: vec![texel].into(),
                    wrap: [Wrap::Repeat; 2],
                };
                let map_of = NormalMap { texture: 0, scale: [2.0; 3], bias: [-1.0; 3] };
                let mut all = square(Opacity::FULL, &[]);
                let mesh = &mut all.meshes[0];
                mesh.uv.as_mut().unwrap().iter_mut().flatten().for_each(|uv| *uv = map(*uv));
                let surface = Surface { normals: Some(map_of), ..Surface::diffuse("s", [0.5; 3]) };
                all.detail(&Arc::new(Details::new(&[surface], &[texture])));
                let expected = (0.6 * lean + 0.8 * Vec3::Z).normalize();
                for side in [1.0, -1.0] {
                    let ray = Ray::new(Vec3::new(0.3, 0.6, side), Vec3::new(0.0, 0.0, -side));
                    let normal = all.intersect(&ray).unwrap().normal;
                    assert!(normal.abs_diff_eq(side * expected, 1e-5), "{normal} {expected}");
                }
            }
        }
    }

    /// The left half of a texture is below the threshold.
    #[test]
    fn a_threshold_cuts_holes() {
        let pixels = vec![[0.2; 3], [0.2; 3], [0.7; 3], [0.7; 3]].into();
        let texture = Texture { name: String::new(), width: 4, height: 1, pixels, wrap: [Wrap::Clamp; 2] };
        let all = square(Opacity { value: 1.0, texture: Some(0), threshold: 0.3 }, &[texture]);
        for i in 0..100 {
            let x = i as f32 / 100.0 + 5e-3;
            let ray = Ray::new(Vec3::new(x, 0.3, 1.0), Vec3::NEG_Z);
            // The threshold is met a fifth of a pixel from the middle of the second one.
            assert_eq!(all.intersect(&ray).is_some(), x > 0.375 + 0.25 * 0.2, "{x}");
        }
    }

    /// From inside a closed box, every ray hits one of its planes, and none escapes.
    #[test]
    fn no_ray_leaves_a_closed_box() {
        let positions: Vec<Vec3> =
            (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32)).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        let mesh =
            Mesh { name: "box".to_owned(), positions, triangles, normals: None, uv: None, surface: 0, moved: None };
        let all = Triangles::new(vec![mesh]);
        for i in 0..20_000u32 {
            let noise = |k: u32| ((i as f32 * 12.9898 + k as f32 * 78.233).sin() * 43758.547).rem_euclid(1.0);
            let origin = Vec3::new(noise(1), noise(2), noise(3)) * 0.98 + 0.01;
            let direction = (Vec3::new(noise(4), noise(5), noise(6)) - 0.5).normalize();
            let ray = Ray::new(origin, direction);
            let hit = all.intersect(&ray).unwrap();
            let walls = ((1.0 - origin) / direction).max(-origin / direction);
            assert!((hit.t - walls.min_element()).abs() < 1e-5 && hit.normal.dot(direction) < 0.0);
            assert!(all.occluded(&ray) && !all.occluded(&Ray { t_max: hit.t - 1e-5, ..ray }));
        }
    }

    /// At any time, a moving mesh and its normals are those of a static mesh in the same place.
    #[test]
    fn moving_meshes_are_hit_like_static_ones() {
        let noise = |i: usize, k: u32| ((i as f32 * 12.9898 + k as f32 * 78.233).sin() * 43758.547).rem_euclid(1.0);
        let vector = |i: usize, k: u32| Vec3::new(noise(i, k), noise(i, k + 1), noise(i, k + 2));
        let positions: Vec<Vec3> = (0..300).map(|i| vector(i / 3, 1) + 0.2 * vector(i, 4)).collect();
        // For a rotation and a translation, the transform of normals is exact.
        let turn = Mat3::from_rotation_y(0.9) * Mat3::from_rotation_x(0.4);
        let moved: Vec<Vec3> = positions.iter().map(|&p| turn * p + Vec3::new(0.1, -0.2, 0.3)).collect();
        let triangles: Vec<[u32; 3]> = (0..100).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let normals: Vec<[Vec3; 3]> =
            (0..100).map(|i| [1, 2, 3].map(|k| (vector(i, 10 * k) - 0.5).normalize())).collect();
        let mesh = |positions: &[Vec3], moved, normals: &[[Vec3; 3]]| Mesh {
            name: "shards".to_owned(),
            positions: positions.to_vec(),
            moved,
            triangles: triangles.clone(),
            normals: Some(normals.to_vec()),
            uv: None,
            surface: 0,
        };
        let moving = Triangles::new(vec![mesh(&positions, Some(moved.clone()), &normals)]);
        let turned: Vec<[Vec3; 3]> = normals.iter().map(|n| n.map(|n| turn * n)).collect();
        let mut hits = 0;
        for (time, normals) in [(0.0, Some(&normals)), (0.4, None), (1.0, Some(&turned))] {
            let now: Vec<Vec3> = positions.iter().zip(&moved).map(|(a, b)| a.lerp(*b, time)).collect();
            let still = Triangles::new(vec![mesh(&now, None, normals.unwrap_or(&turned))]);
            for i in 0..2000 {
                let origin = 3.0 * vector(i, 20) - 1.0;
                let ray = Ray { time, ..Ray::new(origin, (vector(i, 23) - origin).normalize()) };
                match (moving.intersect(&ray), still.intersect(&ray)) {
                    (Some(a), Some(b)) => {
                        hits += 1;
                        assert!((a.t - b.t).abs() < 1e-4 && a.plane.abs_diff_eq(b.plane, 1e-3), "{a:?} {b:?}");
                        // Between opening and closing a triangle shrinks; its normals do not.
                        let (a, b) = (a.normal, b.normal);
                        assert!(normals.is_none() || a.abs_diff_eq(b, 2e-3), "{a} {b}");
                    }
                    (a, b) => assert!(a.is_none() && b.is_none(), "{a:?} {b:?}"),
                }
            }
        }
        assert!(hits > 300, "{hits}");
    }
}
