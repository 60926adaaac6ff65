//! Strands and meshes that a scene shows several times.

use crate::error::{Error, invalid};
use crate::mesh::Mesh;
use crate::scene::Scene;
use crate::strands::{MAX_COORDINATE, Strands, is_within};
use glam::{Mat3, Mat4, Vec3, Vec4Swizzles};

/// How much the lengths and angles of an instance may change beyond a uniform scale. A product of single-precision
/// rotations stays within a tenth of it.
const TOLERANCE: f32 = 1e-3;

/// The largest number of points of strands and vertices of meshes that copies of instances should have in total: more
/// need over 4 GB.
pub const MAX_COPIED: usize = 1 << 28;

/// Strands and meshes that a scene shows only through its instances, in coordinates of their own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Prototype {
    /// Name for messages.
    pub name: String,
    /// Hair and fur. Looks are those of the scene.
    pub strands: Vec<Strands>,
    /// Skin and other objects. Surfaces are those of the scene.
    pub meshes: Vec<Mesh>,
}

/// A prototype at a place in the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Index of the prototype in the scene.
    pub prototype: usize,
    /// The transform to world space: a rotation, a uniform scale that is not 0, a reflection and a translation.
    pub to_world: Mat4,
    /// What some paths find at this place instead. `None` if all find the prototype.
    pub simplified: Option<Simplified>,
}

/// A prototype that stands for another one: see [`Instance::simplified`]. It should look the same from far away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Simplified {
    /// Index of the prototype in the scene.
    pub prototype: usize,
    /// The share of the paths that find it, in [0, 1].
    pub share: f32,
}

impl Instance {
    /// A prototype at a place, the same for all paths.
    pub fn new(prototype: usize, to_world: Mat4) -> Self {
        Instance { prototype, to_world, simplified: None }
    }

    /// The uniform scale of the transform, positive. `None` if the transform is not a similarity.
    pub fn scale(&self) -> Option<f32> {
        let linear = Mat3::from_mat4(self.to_world);
        let scale = linear.determinant().abs().cbrt();
        let is_positive = scale.is_finite() && scale >= f32::MIN_POSITIVE.cbrt();
        let scaled = linear * (1.0 / scale);
        let away = scaled.transpose() * scaled - Mat3::IDENTITY;
        let is_similar = away.to_cols_array().iter().all(|x| x.abs() <= TOLERANCE);
        let is_affine = self.to_world.row(3) == glam::Vec4::W && self.to_world.is_finite();
        (is_positive && is_similar && is_affine).then_some(scale)
    }
}

impl Prototype {
    /// The smallest and largest coordinates of the surfaces of strands and of meshes, while the shutter is open. `None`
    /// without points.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let strands = self.strands.iter().flat_map(|strands| {
            let moved = strands.moved.iter().flatten().zip(&strands.points).map(|(p, open)| (*p, open.w));
            strands.points.iter().map(|p| (p.xyz(), p.w)).chain(moved)
        });
        let meshes = self.meshes.iter().flat_map(|mesh| mesh.positions.iter().chain(mesh.moved.iter().flatten()));
        let points = strands.chain(meshes.map(|p| (*p, 0.0)));
        points.fold(None, |bounds: Option<(Vec3, Vec3)>, (p, radius)| {
            let (low, high) = (p - radius, p + radius);
            Some(bounds.map_or((low, high), |(l, h)| (l.min(low), h.max(high))))
        })
    }

    /// Points of strands and vertices of meshes.
    pub fn points(&self) -> usize {
        let strands = self.strands.iter().map(|strands| strands.points.len());
        strands.chain(self.meshes.iter().map(|mesh| mesh.positions.len())).sum()
    }

    fn validate(&self) -> Result<(), Error> {
        self.strands.iter().try_for_each(Strands::validate)?;
        self.meshes.iter().try_for_each(Mesh::validate)
    }
}

/// The eight corners of a box.
pub fn corners((low, high): (Vec3, Vec3)) -> [Vec3; 8] {
    std::array::from_fn(|i| {
        let pick = |bit: usize, k: usize| if i >> bit & 1 == 0 { low[k] } else { high[k] };
        Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2))
    })
}

impl Scene {
    /// All sets of strands: those in world space, then those of each prototype.
    pub fn all_strands(&self) -> impl Iterator<Item = &Strands> {
        self.strands.iter().chain(self.prototypes.iter().flat_map(|prototype| &prototype.strands))
    }

    /// As [`Scene::all_strands`], to change them.
    pub fn all_strands_mut(&mut self) -> impl Iterator<Item = &mut Strands> {
        self.strands.iter_mut().chain(self.prototypes.iter_mut().flat_map(|prototype| &mut prototype.strands))
    }

    /// The corners of the boxes around all instances, in world space.
    pub(crate) fn instance_corners(&self) -> Vec<Vec3> {
        let bounds: Vec<_> = self.prototypes.iter().map(Prototype::bounds).collect();
        let of = |instance: &Instance| {
            let simplified = instance.simplified.and_then(|simplified| bounds[simplified.prototype]);
            let corners = bounds[instance.prototype].into_iter().chain(simplified).flat_map(corners);
            let to_world = instance.to_world;
            corners.map(move |p| to_world.transform_point3(p))
        };
        self.instances.iter().flat_map(of).collect()
    }

    pub(crate) fn validate_instances(&self) -> Result<(), Error> {
        self.prototypes.iter().try_for_each(Prototype::validate)?;
        for (i, instance) in self.instances.iter().enumerate() {
            let Some(prototype) = self.prototypes.get(instance.prototype) else {
                return Err(invalid("instances", format!("instance {i} has a prototype that does not exist")));
            };
            if let Some(Simplified { prototype, share }) = instance.simplified
                && !(prototype < self.prototypes.len() && (0.0..=1.0).contains(&share))
            {
                let what = format!("instance {i} has a simplified prototype that does not exist, or its share {share}");
                return Err(invalid("instances", what + " is not in [0, 1]"));
            }
            if instance.scale().is_none() {
                let what = format!("instance {i} must only rotate, mirror, move and scale uniformly");
                return Err(invalid(&prototype.name, what));
            }
        }
        if self.instance_corners().into_iter().any(|corner| !is_within(corner)) {
            return Err(invalid("instances", format!("all must be within ±{MAX_COORDINATE:e}")));
        }
        Ok(())
    }

    /// Points of strands and vertices of meshes that [`Scene::copy_instances`] would add: see [`MAX_COPIED`].
    pub fn copied_points(&self) -> usize {
        let of = |instance: &Instance| self.prototypes.get(instance.prototype).map_or(0, Prototype::points);
        self.instances.iter().map(of).fold(0, usize::saturating_add)
    }

    /// Replaces the instances by copies of their prototypes in world space, without [`Instance::simplified`].
    pub fn copy_instances(&mut self) {
        for instance in std::mem::take(&mut self.instances) {
            let prototype = &self.prototypes[instance.prototype];
            self.strands.extend(prototype.strands.iter().map(|strands| strands.transformed(instance.to_world)));
            self.meshes.extend(prototype.meshes.iter().map(|mesh| mesh.transformed(instance.to_world)));
        }
        self.prototypes.clear();
    }
}

impl Strands {
    /// The strands after a transform. Their sections keep their shape: the mean scale applies to their radii.
    pub fn transformed(&self, matrix: Mat4) -> Self {
        let scale = Mat3::from_mat4(matrix).determinant().abs().cbrt();
        let points = self.points.iter().map(|p| matrix.transform_point3(p.xyz()).extend(p.w * scale)).collect();
        let moved = self.moved.as_ref().map(|moved| moved.iter().map(|p| matrix.transform_point3(*p)).collect());
        let of_normals = Mat3::from_mat4(matrix).inverse().transpose();
        let normals =
            self.normals.as_ref().map(|all| all.iter().map(|n| (of_normals * *n).normalize_or_zero()).collect());
        Strands { points, moved, normals, ..self.clone() }
    }
}

impl Mesh {
    /// The mesh after a transform. A reflection reverses the triangles, so that they stay counterclockwise.
    pub fn transformed(&self, matrix: Mat4) -> Self {
        let linear = Mat3::from_mat4(matrix);
        let of_normals = linear.inverse().transpose();
        let is_mirrored = linear.determinant() < 0.0;
        let turned = |[a, b, c]: [u32; 3]| if is_mirrored { [a, c, b] } else { [a, b, c] };
        let place = |points: &[Vec3]| points.iter().map(|p| matrix.transform_point3(*p)).collect();
        let swap = |i: usize| if is_mirrored { [0, 2, 1][i] } else { i };
        Mesh {
            name: self.name.clone(),
            positions: place(&self.positions),
            moved: self.moved.as_deref().map(place),
            triangles: self.triangles.iter().copied().map(turned).collect(),
            normals: self.normals.as_ref().map(|all| {
                let corner = |n: &[Vec3; 3], i: usize| (of_normals * n[swap(i)]).normalize_or_zero();
                all.iter().map(|n| std::array::from_fn(|i| corner(n, i))).collect()
            }),
            uv: self.uv.as_ref().map(|all| all.iter().map(|uv| std::array::from_fn(|i| uv[swap(i)])).collect()),
            surface: self.surface,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Basis, Look};
    use glam::{Vec2, Vec4};
    use vellus::Fiber;

    fn strands() -> Strands {
        Strands {
            name: "fur".to_owned(),
            basis: Basis::Linear,
            starts: vec![0, 2],
            points: vec![Vec4::new(0.0, 0.0, 0.0, 0.1), Vec4::new(1.0, 2.0, 3.0, 0.2)],
            moved: None,
            normals: None,
            root_uv: None,
            look: 0,
            varying: Vec::new(),
        }
    }

    fn scene(matrices: &[Mat4]) -> Scene {
        let mesh = Mesh {
            name: "skin".to_owned(),
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            moved: None,
            triangles: vec![[0, 1, 2]],
            normals: Some(vec![[Vec3::Z; 3]]),
            uv: Some(vec![[Vec2::ZERO, Vec2::X, Vec2::Y]]),
            surface: 0,
        };
        Scene {
            prototypes: vec![Prototype { name: "cat".to_owned(), strands: vec![strands()], meshes: vec![mesh] }],
            instances: matrices.iter().map(|&to_world| Instance::new(0, to_world)).collect(),
            looks: vec![Look::constant("hair", Fiber::hair())],
            surfaces: vec![crate::Surface::diffuse("skin", [0.5; 3])],
            ..Scene::default()
        }
    }

    #[test]
    fn copies_are_where_the_instances_were() {
        let matrices = [
            Mat4::from_translation(Vec3::new(5.0, 0.0, 0.0)) * Mat4::from_scale(Vec3::splat(2.0)),
            Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0)),
        ];
        let mut scene = scene(&matrices);
        scene.validate().unwrap();
        let around = scene.bounds().unwrap();
        // Two copies of two points and three vertices.
        assert_eq!(scene.copied_points(), 10);
        scene.copy_instances();
        scene.validate().unwrap();
        assert_eq!((scene.strands.len(), scene.meshes.len(), scene.prototypes.len()), (2, 2, 0));
        assert_eq!(scene.strands[0].points, [Vec4::new(5.0, 0.0, 0.0, 0.2), Vec4::new(7.0, 4.0, 6.0, 0.4)]);
        // The corners of the boxes have the radii of strands: the widest strand's, scaled.
        let (low, high) = scene.bounds().unwrap();
        assert!(around.0.cmple(low).all() && around.1.cmpge(high).all());
        assert!((around.0 - low).abs().max_element() < 0.41 && (around.1 - high).abs().max_element() < 0.41);
        // A mirrored triangle still has its front outside.
        let mirrored = &scene.meshes[1];
        let [a, b, c] = mirrored.triangles[0].map(|i| mirrored.positions[i as usize]);
        assert!((b - a).cross(c - a).dot(mirrored.normals.as_ref().unwrap()[0][0]) > 0.0);
        assert_eq!(mirrored.uv.as_ref().unwrap()[0], [Vec2::ZERO, Vec2::Y, Vec2::X]);
    }

    #[test]
    fn other_transforms_are_refused() {
        let turn = Mat4::from_rotation_y(0.7) * Mat4::from_scale(Vec3::splat(1e-3));
        assert!((scene(&[turn]).instances[0].scale().unwrap() - 1e-3).abs() < 1e-8);
        for matrix in [
            Mat4::from_scale(Vec3::new(1.0, 1.0, 1.01)),
            Mat4::from_scale(Vec3::ZERO),
            Mat4::from_translation(Vec3::splat(2e9)),
            Mat4::from_translation(Vec3::splat(f32::NAN)),
        ] {
            assert!(scene(&[matrix]).validate().is_err(), "{matrix}");
        }
        let mut wrong = scene(&[Mat4::IDENTITY]);
        wrong.instances[0].prototype = 1;
        assert!(wrong.validate().is_err());
        for (prototype, share) in [(1, 0.5), (0, 1.1), (0, -0.1), (0, f32::NAN)] {
            let mut wrong = scene(&[Mat4::IDENTITY]);
            wrong.instances[0].simplified = Some(Simplified { prototype, share });
            assert!(wrong.validate().is_err());
        }
    }
}
