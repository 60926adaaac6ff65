//! Densities, directions and distances of cones, spheres, cylinders and disks.

use crate::geometry::ray::orthonormal_basis;
use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// The inverse of the solid angle of a cone.
pub(super) fn cone_pdf(cos: f32) -> f32 {
    1.0 / (TAU * (1.0 - cos).max(1e-12))
}

pub(super) fn uniform_cone(axis: Vec3, cos_max: f32, u: [f32; 2]) -> Vec3 {
    let cos = 1.0 - u[0] * (1.0 - cos_max);
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (s, c) = (TAU * u[1]).sin_cos();
    let (x, y) = orthonormal_basis(axis);
    (x * (sin * c) + y * (sin * s) + axis * cos).normalize()
}

/// A point of the unit disk, uniformly distributed (Shirley and Chiu 1997).
pub fn concentric(u: [f32; 2]) -> (f32, f32) {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    if a == 0.0 && b == 0.0 {
        return (0.0, 0.0);
    }
    let (r, phi) = if a.abs() > b.abs() { (a, PI / 4.0 * b / a) } else { (b, PI / 2.0 - PI / 4.0 * a / b) };
    (r * phi.cos(), r * phi.sin())
}

/// The cosine of the half angle that a sphere subtends. `None` from inside the sphere.
pub(super) fn cos_max(to: Vec3, radius: f32) -> Option<f32> {
    let sin2 = radius * radius / to.length_squared();
    (sin2 < 1.0).then(|| (1.0 - sin2).sqrt())
}

pub(super) fn sphere_entry(origin: Vec3, direction: Vec3, center: Vec3, radius: f32) -> Option<f32> {
    let to = center - origin;
    let along = to.dot(direction);
    let off2 = (to - direction * along).length_squared();
    let t = along - (radius * radius - off2).max(0.0).sqrt();
    (off2 <= radius * radius && t > 0.0).then_some(t)
}

/// The view of an infinite cylinder from a point. `from` is the point relative to the centre. Returns the direction and
/// the distance from the axis to the point, and half of the angle that the cylinder subtends. `None` from inside.
pub(super) fn seen_across(from: Vec3, axis: Vec3, radius: f32) -> Option<(Vec3, f32, f32)> {
    let off = from - axis * from.dot(axis);
    let distance = off.length();
    (distance > radius).then(|| (off / distance, distance, (radius / distance).asin()))
}

/// The distance at which a ray enters an infinite cylinder, and the squared sine of the angle between ray and axis.
/// `from` is the ray's origin relative to the centre.
pub(super) fn cylinder_entry(from: Vec3, direction: Vec3, axis: Vec3, radius: f32) -> Option<(f32, f32)> {
    let [off, across] = [from, direction].map(|v| v - axis * v.dot(axis));
    let sin2 = across.length_squared();
    let nearest = -off.dot(across) / sin2;
    let depth2 = radius * radius - (off + across * nearest).length_squared();
    if !(depth2 >= 0.0 && sin2 > 0.0) {
        return None;
    }
    let t = nearest - (depth2 / sin2).sqrt();
    (t > 0.0).then_some((t, sin2))
}
