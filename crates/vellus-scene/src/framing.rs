//! A default camera for scenes without one.

use crate::camera::Camera;
use crate::scene::Scene;
use glam::{Vec3, Vec4Swizzles};

/// Vertical angle of view, degrees.
const ANGLE: f32 = 30.0;

/// Fraction of the width and height of the picture that stays empty, for both sides together.
const MARGIN: f32 = 0.1;

/// Vertices of meshes are framed within this distance from the middle of the strands, relative to the half diagonal of
/// the strands' bounds.
const NEARBY: f32 = 1.1;

/// Slope of the view direction: the camera is a little above the front.
const RISE: f32 = 0.15;

impl Scene {
    /// A camera that frames the strands, or the meshes if there are no strands.
    ///
    /// It looks from the front and a little above. It is as near as possible, so that a picture of this `aspect` (width
    /// over height) shows everything with a margin of a tenth, also while it moves. `None` if the scene is empty.
    pub fn framing(&self, aspect: f32) -> Option<Camera> {
        let up = self.up();
        let front = if up == Vec3::Z { -Vec3::Y } else { Vec3::Z };
        self.framing_along((front + RISE * up).normalize(), aspect)
    }

    /// As [`Scene::framing`], from another direction: `back` is the unit vector toward the camera.
    ///
    /// Meshes beside strands are framed too, as far as they are near the strands: the head under hair, but not the
    /// feet.
    pub fn framing_along(&self, back: Vec3, aspect: f32) -> Option<Camera> {
        let (low, high) = self.bounds()?;
        let (middle, reach) = (0.5 * (low + high), 0.5 * (high - low).length());
        let right = self.up().cross(back).normalize();
        let above = back.cross(right);
        // k is the tangent of half the angle to fill. With the camera at e, a sphere of radius r around p is left of
        // the plane through the right border if p·x + k p·z + r √(1 + k²) ≤ e·x + k e·z. The other borders are similar.
        let half = (0.5 * ANGLE).to_radians().tan() * (1.0 - MARGIN);
        let slopes = [half * aspect, half];
        let mut beyond = [[f32::NEG_INFINITY; 2]; 2];
        let mut nearest = f32::NEG_INFINITY;
        self.visit(middle, NEARBY * reach, |point, radius| {
            let p = point - middle;
            let depth = p.dot(back);
            nearest = nearest.max(depth + radius);
            for (axis, place) in [p.dot(right), p.dot(above)].into_iter().enumerate() {
                let k = slopes[axis];
                let rest = k * depth + radius * k.hypot(1.0);
                let [positive, negative] = &mut beyond[axis];
                (*positive, *negative) = (positive.max(rest + place), negative.max(rest - place));
            }
        });
        let side = beyond.map(|[a, b]| 0.5 * (a - b));
        let distance = |axis: usize| 0.5 * (beyond[axis][0] + beyond[axis][1]) / slopes[axis];
        // Keeps a distance from strands that point at the camera.
        let least = nearest + reach.max(f32::MIN_POSITIVE);
        let distance = distance(0).max(distance(1)).max(least);
        let across = middle + right * side[0] + above * side[1];
        Some(Camera::look_at(across + back * distance, across, self.up(), ANGLE.to_radians(), aspect))
    }

    /// Visits all positions and radii to frame, when the shutter opens and when it closes. Beside strands, only the
    /// vertices of meshes within `reach` of `middle` are visited.
    fn visit(&self, middle: Vec3, reach: f32, mut see: impl FnMut(Vec3, f32)) {
        for strands in &self.strands {
            strands.points.iter().for_each(|p| see(p.xyz(), p.w));
            let moved = strands.moved.iter().flatten();
            moved.zip(&strands.points).for_each(|(p, point)| see(*p, point.w));
        }
        let instances = self.instance_corners();
        let no_strands = self.strands.iter().all(|strands| strands.points.is_empty()) && instances.is_empty();
        instances.into_iter().for_each(|p| see(p, 0.0));
        let vertices = self.meshes.iter().flat_map(|m| m.positions.iter().chain(m.moved.iter().flatten()));
        vertices.filter(|p| no_strands || p.distance(middle) <= reach).for_each(|p| see(*p, 0.0));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Basis, Mesh, Strands, Units};
    use glam::Vec4;

    fn hair(points: Vec<Vec4>, moved: Option<Vec<Vec3>>) -> Scene {
        let strands = Strands {
            name: "hair".to_owned(),
            basis: Basis::Linear,
            starts: vec![0, points.len() as u32],
            points,
            moved,
            normals: None,
            root_uv: None,
            look: 0,
            varying: Vec::new(),
        };
        Scene { strands: vec![strands], ..Scene::default() }
    }

    fn cube(size: f32) -> Scene {
        let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * size;
        let mesh = Mesh {
            name: "cube".to_owned(),
            positions: (0..8).map(corner).collect(),
            moved: None,
            triangles: vec![[0, 1, 2]],
            normals: None,
            uv: None,
            surface: 0,
        };
        Scene { meshes: vec![mesh], ..Scene::default() }
    }

    /// Smallest and largest coordinates in the picture of everything that is framed. The picture is [−1, 1]².
    fn seen(scene: &Scene, aspect: f32) -> [[f32; 2]; 2] {
        let camera = scene.framing(aspect).unwrap();
        assert_eq!(camera.validate(), Ok(()));
        let to_camera = camera.to_world.inverse();
        let mut range = [[f32::INFINITY, f32::NEG_INFINITY]; 2];
        scene.visit(Vec3::ZERO, 0.0, |point, radius| {
            let p = to_camera.transform_point3(point);
            assert!(p.z < 0.0, "{p} is behind the camera");
            let film = [camera.film_width, camera.film_height];
            for axis in 0..2 {
                let [low, high] = &mut range[axis];
                (*low, *high) = (low.min(2.0 * (p[axis] - radius) / -p.z / film[axis]), {
                    high.max(2.0 * (p[axis] + radius) / -p.z / film[axis])
                });
            }
        });
        range
    }

    /// Everything is in the picture. One axis has a margin of exactly a tenth, half of it on each side.
    #[test]
    fn long_hair_and_a_cube_fill_the_picture() {
        let long = (0..30).map(|i| Vec4::new((i as f32).sin(), -0.7 * i as f32, 0.3 * (i as f32).cos(), 0.01));
        let long: Vec<_> = long.collect();
        let fallen = long.iter().map(|p| p.xyz() + Vec3::new(2.0, -5.0, 0.5)).collect();
        let wide: Vec<_> = long.iter().map(|p| Vec4::new(p.y, p.x, p.z, p.w)).collect();
        let z_up = Scene { units: Some(Units { meters_per_unit: 1.0, z_up: true }), ..cube(1.0) };
        let away = hair(long.iter().map(|p| Vec4::new(p.x + 300.0, p.y, p.z - 200.0, p.w)).collect(), None);
        let scenes =
            [hair(long.clone(), None), hair(long, Some(fallen)), hair(wide, None), cube(1e-3), cube(1e3), z_up, away];
        for scene in scenes {
            for aspect in [1.5, 1.0, 0.4, 2.39] {
                let range = seen(&scene, aspect);
                let fills = range.map(|[low, high]| 0.5 * (high - low));
                // Spheres project to ellipses, and `seen` uses their shorter axes. A radius of 0.01 in more than 10 is
                // within 1e-3.
                assert!((fills[0].max(fills[1]) - 0.9).abs() < 1e-3, "{fills:?} at {aspect}");
                // Everything is within the margin.
                assert!(range.iter().flatten().all(|x| x.abs() < 0.9 + 1e-3), "{range:?} at {aspect}");
            }
        }
    }

    /// A strand that points at the camera, a strand without length, and an empty scene.
    #[test]
    fn the_camera_keeps_away() {
        let back = (Vec3::Z + RISE * Vec3::Y).normalize();
        let pointing = (0..4).map(|i| (i as f32 * back).extend(1e-4)).collect();
        let fills = seen(&hair(pointing, None), 1.5);
        assert!(fills.iter().flatten().all(|x| x.abs() < 0.9));
        let point = seen(&hair(vec![Vec4::new(1.0, 2.0, 3.0, 0.1); 2], None), 1.5);
        assert!(point.iter().flatten().all(|x| x.is_finite() && x.abs() < 0.91), "{point:?}");
        assert_eq!(Scene::default().framing(1.5), None);
    }
}
