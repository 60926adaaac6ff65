//! Rays.

use glam::Vec3;

/// A ray from its origin to a largest distance.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Its origin.
    pub origin: Vec3,
    /// Its direction, unit length.
    pub direction: Vec3,
    /// The largest distance of a hit. It may be infinite.
    pub t_max: f32,
    /// Its time in [0, 1]: the shutter opens at 0 and closes at 1.
    pub time: f32,
    /// A number in [0, 1) that chooses between an instance's prototype and its simplified one. All rays of a path have
    /// the same.
    pub detail: f32,
}

impl Ray {
    /// An infinite ray at time 0 that sees the prototypes of instances.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Ray { origin, direction, t_max: f32::INFINITY, time: 0.0, detail: 0.0 }
    }

    /// The point at a distance.
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }
}

/// Two unit vectors that complete the unit vector `n` to a right-handed orthonormal basis (Duff et al. 2017, Building
/// an Orthonormal Basis, Revisited).
pub fn orthonormal_basis(n: Vec3) -> (Vec3, Vec3) {
    let sign = 1f32.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), Vec3::new(b, sign + n.y * n.y * a, -n.y))
}
