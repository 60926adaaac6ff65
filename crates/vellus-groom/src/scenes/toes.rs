//! Bare toes and fingers.

use super::props;
use glam::{Quat, Vec3};
use vellus_scene::{Scene, Surface};

/// The toes of a foot that points along +x, and of its mirror image at z = 0.
pub(super) struct Toes {
    /// The middle of the tips' row.
    pub tip: Vec3,
    pub count: usize,
    /// Half the length, height and width of a toe.
    pub radii: Vec3,
    /// Distance between toes, relative to their width.
    pub spacing: f32,
    /// The angle between neighbours, in radians.
    pub fan: f32,
}

impl Toes {
    pub fn add(&self, scene: &mut Scene, surface: &Surface) {
        for i in 0..self.count {
            let across = i as f32 - 0.5 * (self.count - 1) as f32;
            let back = 0.25 * across * across * self.radii.x;
            let center = self.tip + Vec3::new(-back, 0.0, 2.0 * self.spacing * across * self.radii.z);
            let turn = Quat::from_rotation_y(-self.fan * across) * Quat::from_rotation_z(-0.2);
            props::ellipsoid(scene, center, self.radii, turn, surface.clone());
            let mirrored = Vec3::new(center.x, center.y, -center.z);
            let turn = Quat::from_rotation_y(self.fan * across) * Quat::from_rotation_z(-0.2);
            props::ellipsoid(scene, mirrored, self.radii, turn, surface.clone());
        }
    }
}
