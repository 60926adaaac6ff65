//! Rays.

use glam::Vec3;

/// A ray, from its origin up to a distance.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it starts.
    pub origin: Vec3,
    /// Where it goes, unit length.
    pub direction: Vec3,
    /// How far it is asked for; infinity is everywhere.
    pub t_max: f32,
    /// When: 0 as the shutter opens, 1 as it closes.
    pub time: f32,
}

impl Ray {
    /// A ray without end, as the shutter opens.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Ray { origin, direction, t_max: f32::INFINITY, time: 0.0 }
    }

    /// The point at that distance.
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }
}

/// Two directions across `n` that make with it a right-handed frame (Duff et al. 2017, Building an Orthonormal
/// Basis, Revisited).
pub fn orthonormal_basis(n: Vec3) -> (Vec3, Vec3) {
    let sign = 1f32.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), Vec3::new(b, sign + n.y * n.y * a, -n.y))
}
