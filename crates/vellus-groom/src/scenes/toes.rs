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
        // Sines of constants would differ between builds: see `super::opaque`.
        let toes = super::opaque(self);
        for i in 0..toes.count {
            let across = i as f32 - 0.5 * (toes.count - 1) as f32;
            let back = 0.25 * across * across * toes.radii.x;
            let center = toes.tip + Vec3::new(-back, 0.0, 2.0 * toes.spacing * across * toes.radii.z);
            let turn = Quat::from_rotation_y(-toes.fan * across) * Quat::from_rotation_z(-0.2);
            props::ellipsoid(scene, center, toes.radii, turn, surface.clone());
            let mirrored = Vec3::new(center.x, center.y, -center.z);
            let turn = Quat::from_rotation_y(toes.fan * across) * Quat::from_rotation_z(-0.2);
            props::ellipsoid(scene, mirrored, toes.radii, turn, surface.clone());
        }
    }
}
