//! Prototypes that a scene shows several times: one hierarchy over each prototype, and one over all instances.
//!
//! A ray is transformed to the coordinates of an instance. What it hits is transformed back, so that paths only know
//! world space.

use crate::geometry::bvh::{Bounds, Bvh, EMPTY, NONE, WIDTH, join};
use crate::geometry::curves::{CurveHit, Curves};
use crate::geometry::details::Details;
use crate::geometry::flat::Section;
use crate::geometry::ray::Ray;
use crate::geometry::triangles::{TriangleHit, Triangles};
use glam::{Affine3A, Vec3, Vec4Swizzles};
use std::sync::Arc;
use vellus_scene::{Instance, Mesh, Prototype, Simplified, Strands, corners};

/// A prototype, prepared for rays.
#[derive(Debug)]
struct Object {
    curves: Curves,
    triangles: Triangles,
    /// The number of sets of strands and of meshes of the scene before those of this prototype.
    first_set: usize,
    first_mesh: usize,
    strands: u32,
}

/// An instance, prepared for rays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    /// The prototype, and the simplified one that a share of the paths finds instead.
    objects: [u32; 2],
    share: f32,
    /// Moves [`Ray::detail`], so that the instances are not all simplified for the same paths.
    shift: f32,
    /// The number of strands of the scene before those of this instance.
    pub strands_before: u32,
    pub to_world: Affine3A,
    pub to_local: Affine3A,
    /// The length of a local unit in world space.
    pub scale: f32,
}

impl Placed {
    /// The object that the rays of a path find: see [`Ray::detail`].
    fn object(&self, detail: f32) -> usize {
        self.objects[usize::from((detail + self.shift).fract() < self.share)] as usize
    }

    /// The object that most paths find.
    pub(crate) fn usual_object(&self) -> usize {
        self.objects[usize::from(self.share > 0.5)] as usize
    }

    /// The ray in local coordinates, and the length of a local unit along it.
    fn local(&self, ray: &Ray) -> (Ray, f32) {
        let direction = self.to_local.transform_vector3(ray.direction);
        let unit = direction.length().recip();
        let origin = self.to_local.transform_point3(ray.origin);
        (Ray { origin, direction: direction * unit, t_max: ray.t_max / unit, ..*ray }, unit)
    }
}

/// What a ray hits.
#[derive(Clone, Copy, Debug)]
pub enum Hit {
    /// A strand.
    Curve(CurveHit),
    /// A mesh.
    Triangle(TriangleHit),
}

impl Hit {
    /// The distance along the ray.
    pub fn t(&self) -> f32 {
        match self {
            Hit::Curve(hit) => hit.entry.t,
            Hit::Triangle(hit) => hit.t,
        }
    }
}

/// The instances of a scene.
#[derive(Debug)]
pub struct Instances {
    objects: Vec<Object>,
    placed: Vec<Placed>,
    /// Indices of instances, for each leaf of the hierarchy.
    leaves: Vec<[u32; WIDTH]>,
    bvh: Bvh,
}

impl Instances {
    /// Builds the hierarchies. `first_set`, `first_mesh` and `strands` are the numbers of sets of strands, of meshes
    /// and of strands that the scene has in world space.
    pub fn new(
        prototypes: Vec<Prototype>,
        instances: &[Instance],
        [mut first_set, mut first_mesh]: [usize; 2],
        mut strands: u32,
    ) -> Self {
        let around: Vec<Option<Bounds>> = prototypes.iter().map(Prototype::bounds).collect();
        let mut objects = Vec::new();
        for Prototype { strands, meshes, .. } in prototypes {
            let (sets, number) = (strands.len(), meshes.len());
            let count = strands.iter().fold(0u32, |n, set| n.wrapping_add(set.len() as u32));
            let (curves, triangles) = (Curves::new(strands), Triangles::new(meshes));
            objects.push(Object { curves, triangles, first_set, first_mesh, strands: count });
            (first_set, first_mesh) = (first_set + sets, first_mesh + number);
        }
        let mut placed = Vec::with_capacity(instances.len());
        let mut boxes = Vec::with_capacity(instances.len());
        for (i, instance) in instances.iter().enumerate() {
            let simplified = instance.simplified.unwrap_or(Simplified { prototype: instance.prototype, share: 0.0 });
            let both = [instance.prototype, simplified.prototype];
            let around = both.iter().filter_map(|&prototype| around[prototype]).reduce(join);
            // An instance without points is never hit.
            let (Some(around), Some(scale)) = (around, instance.scale()) else { continue };
            let to_world = Affine3A::from_mat4(instance.to_world);
            let points = corners(around).map(|p| to_world.transform_point3(p));
            boxes.push(points.into_iter().fold(EMPTY, |bounds, p| join(bounds, (p, p))));
            let to_local = to_world.inverse();
            placed.push(Placed {
                objects: both.map(|prototype| prototype as u32),
                share: simplified.share,
                // Multiples of the golden ratio are evenly distributed.
                shift: (i as f64 * 0.618_033_988_749_895).fract() as f32,
                strands_before: strands,
                to_world,
                to_local,
                scale,
            });
            let count = both.map(|prototype| objects[prototype].strands);
            strands = strands.wrapping_add(count[0].max(count[1]));
        }
        let (bvh, leaves) = Bvh::build(boxes.len(), |i| boxes[i]);
        Instances { objects, placed, leaves, bvh }
    }

    /// Gives meshes the details of their surfaces.
    pub(crate) fn detail(&mut self, details: &Arc<Details>) {
        self.objects.iter_mut().for_each(|object| object.triangles.detail(details));
    }

    /// Gives the strands the sections of their looks: see [`Curves`].
    pub(crate) fn set_aspect_ratios(&mut self, of_look: &impl Fn(usize) -> f32) {
        self.objects.iter_mut().for_each(|object| object.curves.set_aspect_ratios(of_look));
    }

    /// Number of instances.
    pub fn len(&self) -> usize {
        self.placed.len()
    }

    /// Whether there are no instances.
    pub fn is_empty(&self) -> bool {
        self.placed.is_empty()
    }

    /// The strands and meshes of each prototype.
    pub(crate) fn objects(&self) -> impl Iterator<Item = (&Curves, &Triangles)> {
        self.objects.iter().map(|object| (&object.curves, &object.triangles))
    }

    /// All instances.
    pub(crate) fn placed(&self) -> &[Placed] {
        &self.placed
    }

    /// The hierarchy over the instances, and the instances of each leaf.
    pub(crate) fn hierarchy(&self) -> (&Bvh, &[[u32; WIDTH]]) {
        (&self.bvh, &self.leaves)
    }

    /// Number of segments of all prototypes.
    pub fn segments(&self) -> usize {
        self.objects.iter().map(|object| object.curves.segments()).sum()
    }

    /// Bytes in memory: control points of all prototypes, hierarchies and instances.
    pub fn bytes(&self) -> usize {
        let objects: usize = self.objects.iter().map(|object| object.curves.bytes()).sum();
        objects + size_of_val(&self.placed[..]) + size_of_val(&self.leaves[..]) + self.bvh.bytes()
    }

    /// Whether a path needs [`Ray::detail`].
    pub fn is_simplified(&self) -> bool {
        self.placed.iter().any(|placed| placed.share > 0.0)
    }

    /// Whether anything in a prototype moves.
    pub fn moves(&self) -> bool {
        self.objects.iter().any(|object| object.curves.moves() || object.triangles.moves())
    }

    /// The sets of strands of all prototypes.
    pub fn strands(&self) -> impl Iterator<Item = &Strands> {
        self.objects.iter().flat_map(|object| object.curves.strands())
    }

    /// A sphere around the strands of an instance: its centre and radius. `None` without strands.
    pub fn fur_sphere(&self, instance: usize) -> Option<(Vec3, f32)> {
        let placed = &self.placed[instance];
        let (centre, radius) = self.objects[placed.usual_object()].curves.sphere()?;
        Some((placed.to_world.transform_point3(centre), radius * placed.scale))
    }

    /// The meshes of all prototypes.
    pub fn meshes(&self) -> impl Iterator<Item = &Mesh> {
        self.objects.iter().flat_map(|object| object.triangles.meshes())
    }

    /// A set of strands, by its index in the scene.
    pub fn set(&self, set: usize) -> &Strands {
        let object = self.of_set(set);
        &object.curves.strands()[set - object.first_set]
    }

    /// The object of a set of strands.
    fn of_set(&self, set: usize) -> &Object {
        &self.objects[self.objects.partition_point(|object| object.first_set <= set) - 1]
    }

    /// A mesh, by its index in the scene.
    pub fn mesh(&self, mesh: usize) -> &Mesh {
        let object = &self.objects[self.objects.partition_point(|object| object.first_mesh <= mesh) - 1];
        &object.triangles.meshes()[mesh - object.first_mesh]
    }

    /// The number of strands of the scene before those of an instance.
    pub fn strands_before(&self, instance: u32) -> u32 {
        self.placed[instance as usize].strands_before
    }

    /// The motion of the fibre's axis at a hit on an instance while the shutter is open.
    pub fn movement(&self, instance: u32, hit: &CurveHit) -> Vec3 {
        let placed = &self.placed[instance as usize];
        let object = self.of_set(hit.set);
        let local = CurveHit { set: hit.set - object.first_set, ..*hit };
        placed.to_world.transform_vector3(object.curves.movement(&local))
    }

    /// The nearest hit of a ray.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let mut best = None;
        self.visit(ray, |index, placed, local, unit| {
            let object = &self.objects[placed.object(ray.detail)];
            let triangle = object.triangles.intersect(local);
            let curve = object.curves.intersect(&Ray { t_max: triangle.map_or(local.t_max, |hit| hit.t), ..*local });
            if let Some(hit) = curve {
                best = Some((index, Hit::Curve(hit), unit));
                return hit.entry.t * unit;
            }
            let Some(hit) = triangle else { return ray.t_max };
            best = Some((index, Hit::Triangle(hit), unit));
            hit.t * unit
        });
        best.map(|(index, hit, unit)| self.in_world(index, ray.detail, hit, unit))
    }

    /// Whether a ray hits anything within its length.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.any(ray, |object, local| object.curves.occluded(local) || object.triangles.occluded(local))
    }

    /// As [`Instances::occluded`], for the sets of strands and the meshes of the scene that cast shadows.
    pub fn occluded_by(&self, ray: &Ray, sets: impl Fn(usize) -> bool, meshes: impl Fn(usize) -> bool) -> bool {
        self.any(ray, |object, local| {
            object.curves.occluded_by(local, |set| sets(object.first_set + set))
                || object.triangles.occluded_by(local, |mesh| meshes(object.first_mesh + mesh))
        })
    }

    /// Whether `blocks` accepts an object that the ray may hit, and the ray in its coordinates.
    fn any(&self, ray: &Ray, blocks: impl Fn(&Object, &Ray) -> bool) -> bool {
        let mut found = false;
        self.visit(ray, |_, placed, local, _| {
            found = blocks(&self.objects[placed.object(ray.detail)], local);
            if found { -1.0 } else { ray.t_max }
        });
        found
    }

    /// Visits the instances that a ray may hit. `hit` gets the ray in local coordinates and returns the distance of a
    /// hit in world space, or a larger one. A negative distance ends the search.
    fn visit(&self, ray: &Ray, mut hit: impl FnMut(u32, &Placed, &Ray, f32) -> f32) {
        self.bvh.traverse(
            ray,
            |_| {},
            |leaf, mut t_max| {
                for &index in self.leaves[leaf as usize].iter().filter(|&&index| index != NONE) {
                    let placed = &self.placed[index as usize];
                    let (local, unit) = placed.local(&Ray { t_max, ..*ray });
                    t_max = t_max.min(hit(index, placed, &local, unit));
                    if t_max < 0.0 {
                        break;
                    }
                }
                t_max
            },
        );
    }

    fn in_world(&self, index: u32, detail: f32, hit: Hit, unit: f32) -> Hit {
        let placed = &self.placed[index as usize];
        let object = &self.objects[placed.object(detail)];
        match hit {
            Hit::Curve(mut hit) => {
                hit.set += object.first_set;
                hit.entry.t *= unit;
                hit.instance = Some(index);
                let in_world = |p: glam::Vec4| placed.to_world.transform_point3(p.xyz()).extend(p.w * placed.scale);
                hit.segment.points = hit.segment.points.map(in_world);
                let turned = |longer| placed.to_world.transform_vector3(longer);
                hit.section = hit.section.map(|section| Section { longer: turned(section.longer), ..section });
                Hit::Curve(hit)
            }
            Hit::Triangle(mut hit) => {
                hit.mesh += object.first_mesh;
                hit.t *= unit;
                hit.plane = placed.to_world.transform_vector3(hit.plane).normalize();
                hit.normal = placed.to_world.transform_vector3(hit.normal).normalize();
                hit.movement = placed.to_world.transform_vector3(hit.movement);
                Hit::Triangle(hit)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::World;
    use glam::{Mat4, Quat, Vec2, Vec4};
    use vellus::Fiber;
    use vellus_scene::{Basis, Look, Scene, Surface};

    fn noise(i: usize, k: u32) -> f32 {
        ((i as f32 * 12.9898 + k as f32 * 78.233).sin() * 43758.547).rem_euclid(1.0)
    }

    fn strands(basis: Basis, moves: bool, seed: usize) -> Strands {
        let (count, points) = (40, 7);
        let all: Vec<Vec4> = (0..count * points)
            .map(|i| {
                let (strand, k) = (i / points + seed, (i % points) as f32);
                let root = Vec3::new(noise(strand, 1), noise(strand, 2), noise(strand, 3));
                let along = Vec3::new(noise(strand, 4), noise(strand, 5), noise(strand, 6)) - 0.5;
                (root + along * (0.12 * k) + 0.01 * noise(i, 7)).extend(0.01 + 0.003 * k)
            })
            .collect();
        Strands {
            name: "fur".to_owned(),
            basis,
            starts: (0..=count).map(|i| (i * points) as u32).collect(),
            moved: moves.then(|| all.iter().map(|p| p.xyz() + Vec3::new(0.05, -0.02, 0.03)).collect()),
            points: all,
            normals: None,
            root_uv: Some((0..count).map(|i| Vec2::splat(noise(i, 8))).collect()),
            look: 0,
            varying: Vec::new(),
        }
    }

    fn ball(at: Vec3) -> Mesh {
        let positions: Vec<Vec3> =
            [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z].map(|p| at + 0.2 * p).to_vec();
        let triangles = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
        let normals = triangles.map(|t: [u32; 3]| t.map(|v| (positions[v as usize] - at).normalize()));
        Mesh {
            name: "ball".to_owned(),
            positions,
            moved: None,
            triangles: triangles.to_vec(),
            normals: Some(normals.to_vec()),
            uv: None,
            surface: 0,
        }
    }

    /// Two prototypes in 30 places, with rotation, mirroring and scales from 0.1 to 10, among strands and a mesh in
    /// world space.
    fn scene(moves: bool) -> Scene {
        let instances = (0..30).map(|i| {
            let axis = Vec3::new(noise(i, 11), noise(i, 12), noise(i, 13)) - 0.5;
            let turn = Quat::from_axis_angle(axis.normalize(), 6.0 * noise(i, 14));
            let scale = 10f32.powf(2.0 * noise(i, 15) - 1.0);
            let mirror = if i % 4 == 0 { Vec3::new(-1.0, 1.0, 1.0) } else { Vec3::ONE };
            let place = 12.0 * (Vec3::new(noise(i, 16), noise(i, 17), noise(i, 18)) - 0.5);
            Instance::new(i % 2, Mat4::from_scale_rotation_translation(scale * mirror, turn, place))
        });
        Scene {
            strands: vec![strands(Basis::Linear, false, 300)],
            meshes: vec![ball(Vec3::new(2.0, 0.0, 1.0))],
            prototypes: vec![
                Prototype {
                    name: "a".to_owned(),
                    strands: vec![strands(Basis::BSpline, moves, 0), strands(Basis::Linear, false, 100)],
                    meshes: vec![ball(Vec3::splat(0.5))],
                },
                Prototype {
                    name: "b".to_owned(),
                    strands: vec![strands(Basis::CatmullRom, false, 200)],
                    meshes: vec![ball(Vec3::ZERO), ball(Vec3::X)],
                },
            ],
            instances: instances.collect(),
            looks: vec![Look::constant("hair", Fiber::hair())],
            surfaces: vec![Surface::diffuse("skin", [0.5; 3])],
            ..Scene::default()
        }
    }

    /// Rays hit instances where they hit copies of the prototypes. Coordinates are up to 20 and radii down to 0.001, so
    /// single precision may move a hit by some 1e-5, which is a hundredth of such a radius. A ray that grazes a strand
    /// may then miss it: that is allowed for one ray in 200.
    #[test]
    fn instances_are_hit_like_copies() {
        for moves in [false, true] {
            let scene = scene(moves);
            let mut copied = scene.clone();
            copied.copy_instances();
            let [shared, copied] = [scene, copied].map(|scene| World::new(scene).unwrap());
            assert_eq!((shared.instances(), copied.instances()), (30, 0));
            assert!(shared.bytes() < copied.bytes() / 3 && shared.geometry.moves() == moves);
            let (mut curves, mut triangles, mut other) = (0, 0, 0);
            for i in 0..6000 {
                let place = |k: u32| 14.0 * (Vec3::new(noise(i, k), noise(i, k + 1), noise(i, k + 2)) - 0.5);
                let time = if moves { noise(i, 30) } else { 0.0 };
                let ray = Ray { time, ..Ray::new(place(20), (place(23) - place(20)).normalize()) };
                let [found, expected] = [&shared, &copied].map(|world| world.geometry.intersect(&ray));
                assert_eq!(shared.geometry.occluded(&ray), found.is_some());
                match (found, expected) {
                    (Some(Hit::Curve(a)), Some(Hit::Curve(b))) if (a.entry.t - b.entry.t).abs() < 1e-3 => {
                        let [at, expected] = [a, b].map(|hit| hit.segment.at(hit.entry.u));
                        assert!(at.distance(expected) < 2e-3, "{at} {expected}");
                        let [x, y] = [a, b].map(|hit| hit.segment.tangent(hit.entry.u));
                        if x.dot(y) < 0.999 {
                            // The joint of two segments.
                            other += 1;
                            continue;
                        }
                        let [x, y] = [(&shared, a), (&copied, b)]
                            .map(|(world, hit)| (world.geometry.strand_number(&hit), world.geometry.root_uv(&hit)));
                        // Copies have the strands of an instance one after the other, as instances have.
                        assert_eq!(x, y);
                        let [x, y] = [(&shared, a), (&copied, b)].map(|(world, hit)| world.geometry.movement(&hit));
                        assert!(x.distance(y) < 1e-5 * (1.0 + y.length()));
                        curves += usize::from(a.instance.is_some());
                    }
                    (Some(Hit::Triangle(a)), Some(Hit::Triangle(b))) if (a.t - b.t).abs() < 1e-3 => {
                        assert!(a.normal.dot(b.normal) > 0.999 && a.plane.dot(b.plane) > 0.999);
                        triangles += usize::from(a.mesh > 0);
                    }
                    (None, None) => {}
                    _ => other += 1,
                }
            }
            assert!(curves > 500 && triangles > 200 && other < 30, "{curves} {triangles} {other}");
        }
    }

    /// A shadow ray ends before its light: what is behind it does not count.
    #[test]
    fn rays_of_finite_length_stop() {
        let shared = World::new(scene(false)).unwrap();
        for i in 0..500 {
            let place = |k: u32| 14.0 * (Vec3::new(noise(i, k), noise(i, k + 1), noise(i, k + 2)) - 0.5);
            let ray = Ray::new(place(20), (place(23) - place(20)).normalize());
            let t = match shared.geometry.intersect(&ray) {
                Some(Hit::Curve(hit)) => hit.entry.t,
                Some(Hit::Triangle(hit)) => hit.t,
                None => continue,
            };
            assert!(!shared.geometry.occluded(&Ray { t_max: 0.999 * t, ..ray }));
            assert!(shared.geometry.occluded(&Ray { t_max: 1.001 * t, ..ray }));
        }
    }
}
