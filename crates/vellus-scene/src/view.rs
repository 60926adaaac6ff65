//! The direction from which a camera looks at a scene, and the front of a groom.

use crate::scene::Scene;
use crate::strands::Strands;
use glam::{Quat, Vec3, Vec4Swizzles};
use std::str::FromStr;

/// The smallest mean horizontal direction of strands that says where the front is, as a share of their length. For
/// strands that lean in random directions it is near 0. For the fur of animals it is 0.2 to 0.6.
const LEAN: f32 = 0.1;

/// The smallest horizontal distance between the roots and the body that says where the front is, as a share of the size
/// of the body.
const BARE: f32 = 0.05;

/// From where a camera looks at a subject, relative to the subject's front.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Rotation around the up axis in degrees, in [-360, 360]. 0 is the front, and 90 is the subject's left side.
    pub yaw: f32,
    /// Height of the camera in degrees, in [-89, 89]. 0 is level, and positive angles look down.
    pub pitch: f32,
    /// Magnification, in [0.01, 100]. With 1, the subject fills the picture.
    pub zoom: f32,
}

impl Default for View {
    /// Three quarters from the front, and a little above.
    fn default() -> Self {
        View { yaw: 35.0, pitch: 15.0, zoom: 1.0 }
    }
}

impl FromStr for View {
    type Err = String;

    /// Reads `YAW,PITCH` or `YAW,PITCH,ZOOM`.
    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Option<Vec<f32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
        let view = match numbers.as_deref() {
            Some(&[yaw, pitch]) => Some(View { yaw, pitch, zoom: 1.0 }),
            Some(&[yaw, pitch, zoom]) => Some(View { yaw, pitch, zoom }),
            _ => None,
        };
        let within =
            |view: &View| view.yaw.abs() <= 360.0 && view.pitch.abs() <= 89.0 && (0.01..=100.0).contains(&view.zoom);
        view.filter(within).ok_or_else(|| {
            "a view is YAW,PITCH or YAW,PITCH,ZOOM: yaw in [-360, 360] and pitch in [-89, 89] degrees, zoom in \
             [0.01, 100]"
                .to_owned()
        })
    }
}

impl View {
    /// The unit vector from the subject toward the camera. `front` and `up` are perpendicular unit vectors.
    pub fn toward_camera(&self, front: Vec3, up: Vec3) -> Vec3 {
        let level = Quat::from_axis_angle(up, self.yaw.to_radians()) * front;
        let (sin, cos) = self.pitch.to_radians().sin_cos();
        (level * cos + up * sin).normalize()
    }
}

impl Scene {
    /// The up axis: +z if [`Scene::units`] says so, otherwise +y.
    pub fn up(&self) -> Vec3 {
        if self.units.is_some_and(|units| units.z_up) { Vec3::Z } else { Vec3::Y }
    }

    /// The direction in which the subject faces: one of the four horizontal axes.
    ///
    /// 1. Fur and hair lean backward. If the strands have a mean horizontal direction from root to tip, the front is
    ///    opposite to it.
    /// 2. Otherwise, faces are bare. If the roots are behind the middle of the meshes, the front is the other side.
    /// 3. Otherwise, it is +z for scenes with y up and −y for scenes with z up, the conventions of USD and Blender.
    pub fn front(&self) -> Vec3 {
        let up = self.up();
        let axes = if up == Vec3::Z {
            [Vec3::NEG_Y, Vec3::Y, Vec3::X, Vec3::NEG_X]
        } else {
            [Vec3::Z, Vec3::NEG_Z, Vec3::X, Vec3::NEG_X]
        };
        let level = |v: Vec3| v - up * v.dot(up);
        let lean = level(-self.lean());
        let bare = level(self.bare_side());
        let found = [(lean, LEAN), (bare, BARE)].into_iter().find(|(v, least)| v.length() >= *least);
        let Some((direction, _)) = found else { return axes[0] };
        // The first of equal axes.
        axes.into_iter().rev().max_by(|a, b| a.dot(direction).total_cmp(&b.dot(direction))).unwrap_or(axes[0])
    }

    /// The sum of the vectors from roots to tips, divided by the sum of their lengths.
    fn lean(&self) -> Vec3 {
        let (mut sum, mut lengths) = (glam::DVec3::ZERO, 0.0);
        for (root, tip) in self.strands.iter().flat_map(ends) {
            let along = (tip - root).as_dvec3();
            (sum, lengths) = (sum + along, lengths + along.length());
        }
        if lengths > 0.0 { (sum / lengths).as_vec3() } else { Vec3::ZERO }
    }

    /// The vector from the mean root to the middle of the meshes, divided by their size.
    fn bare_side(&self) -> Vec3 {
        let (mut sum, mut count) = (glam::DVec3::ZERO, 0.0);
        for (root, _) in self.strands.iter().flat_map(ends) {
            (sum, count) = (sum + root.as_dvec3(), count + 1.0);
        }
        let positions = || self.meshes.iter().flat_map(|mesh| &mesh.positions).copied();
        let low = positions().reduce(Vec3::min);
        let high = positions().reduce(Vec3::max);
        match low.zip(high) {
            Some((low, high)) if count > 0.0 && (high - low).length() > 0.0 => {
                (0.5 * (low + high) - (sum / count).as_vec3()) / (high - low).length()
            }
            _ => Vec3::ZERO,
        }
    }
}

/// The first and the last control point of each strand.
fn ends(strands: &Strands) -> impl Iterator<Item = (Vec3, Vec3)> + '_ {
    (0..strands.len()).filter_map(|i| {
        let points = strands.strand(i);
        Some((points.first()?.xyz(), points.last()?.xyz()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Basis, Mesh, Units};
    use glam::{Vec3Swizzles, Vec4};

    /// Straight strands from roots to tips.
    fn groom(strands: &[(Vec3, Vec3)]) -> Scene {
        let points = strands.iter().flat_map(|(root, tip)| [root.extend(0.01), tip.extend(0.01)]);
        let strands = Strands {
            name: "fur".to_owned(),
            basis: Basis::Linear,
            starts: (0..=strands.len() as u32).map(|i| 2 * i).collect(),
            points: points.collect::<Vec<Vec4>>(),
            moved: None,
            normals: None,
            root_uv: None,
            look: 0,
            varying: Vec::new(),
        };
        Scene { strands: vec![strands], ..Scene::default() }
    }

    fn z_up(scene: Scene) -> Scene {
        Scene { units: Some(Units { meters_per_unit: 1.0, z_up: true }), ..scene }
    }

    #[test]
    fn views_are_read_within_their_ranges() {
        assert_eq!("35, 15".parse(), Ok(View::default()));
        assert_eq!("-90,0,2.5".parse(), Ok(View { yaw: -90.0, pitch: 0.0, zoom: 2.5 }));
        for bad in ["", "1", "1,2,3,4", "361,0", "0,90", "0,0,0", "0,0,nan", "nan,0", "a,b"] {
            assert!(bad.parse::<View>().unwrap_err().starts_with("a view is YAW,PITCH"), "{bad}");
        }
    }

    #[test]
    fn yaw_turns_to_the_left_side_and_pitch_looks_down() {
        let seen = |yaw, pitch| View { yaw, pitch, zoom: 1.0 }.toward_camera(Vec3::Z, Vec3::Y);
        assert!(seen(0.0, 0.0).abs_diff_eq(Vec3::Z, 1e-6) && seen(90.0, 0.0).abs_diff_eq(Vec3::X, 1e-6));
        assert!(seen(180.0, 0.0).abs_diff_eq(Vec3::NEG_Z, 1e-6) && seen(0.0, 60.0).y > 0.86);
        // In a frame with z up, the left side of a subject that faces −y is +x.
        let left = View { yaw: 90.0, pitch: 0.0, zoom: 1.0 }.toward_camera(Vec3::NEG_Y, Vec3::Z);
        assert!(left.abs_diff_eq(Vec3::X, 1e-6));
    }

    #[test]
    fn fur_leans_backward() {
        // Fur that leans toward −x and down, a little to the side.
        let lean = Vec3::new(-0.5, -0.8, 0.1);
        let fur: Vec<_> = (0..9).map(|i| (Vec3::Z * i as f32, Vec3::Z * i as f32 + lean)).collect();
        assert_eq!(groom(&fur).front(), Vec3::X);
        let fur: Vec<_> = fur.iter().map(|(a, b)| (a.xzy(), b.xzy())).collect();
        assert_eq!(z_up(groom(&fur)).front(), Vec3::X);
    }

    #[test]
    fn without_a_direction_the_front_is_the_bare_side_or_a_convention() {
        // Hair that points away from the middle of a head, in all horizontal directions.
        let radial: Vec<_> = [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z].map(|d| (d, 2.0 * d)).into_iter().collect();
        assert_eq!((groom(&radial).front(), z_up(groom(&radial)).front()), (Vec3::Z, Vec3::NEG_Y));
        assert_eq!(Scene::default().front(), Vec3::Z);
        // The head is in front of the roots, toward −x.
        let head = Mesh {
            name: "head".to_owned(),
            positions: vec![Vec3::new(-3.0, -1.0, -1.0), Vec3::new(1.0, 1.0, 1.0), Vec3::X],
            moved: None,
            triangles: vec![[0, 1, 2]],
            normals: None,
            uv: None,
            surface: 0,
        };
        assert_eq!(Scene { meshes: vec![head], ..groom(&radial) }.front(), Vec3::NEG_X);
    }
}
