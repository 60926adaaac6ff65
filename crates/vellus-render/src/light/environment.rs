//! Environment maps.
//!
//! A map is only sampled where it is brighter than its average, in proportion to the difference. BSDF sampling finds
//! the rest (Karlík et al. 2019, MIS Compensation: Optimizing Sampling Techniques in Multiple Importance Sampling). A
//! map of one colour is not sampled at all.

use super::brightness;
use super::distribution::PiecewiseConstant1D;
use crate::geometry::ray::Ray;
use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};
use vellus_scene::{Ground, Texture, Wrap};

/// A latitude-longitude image and its distribution: rows, and pixels within each row, by excess brightness and solid
/// angle.
#[derive(Clone, Debug)]
pub(crate) struct Map {
    pub(crate) texture: Texture,
    /// The brightness above the average, averaged over the sphere. 0 if its share of the average is at most [`EVEN`].
    pub(super) excess: f32,
    /// The rows, and the pixels of each row.
    pub(crate) rows: PiecewiseConstant1D,
    pub(crate) columns: Vec<PiecewiseConstant1D>,
}

/// A sky is not sampled if its excess is at most this share of its average brightness.
const EVEN: f32 = 1e-3;

/// The cosine of the upper edge of a row of an image minus that of the lower edge.
pub(super) fn band(y: usize, h: usize) -> f32 {
    let edge = |y: usize| (y as f32 / h as f32 * PI).cos();
    edge(y) - edge(y + 1)
}

impl Map {
    pub(super) fn new(texture: Texture) -> Self {
        // The image continues from left to right. At a pole, the row of the other pole is no neighbour.
        let texture = Texture { wrap: [Wrap::Repeat, Wrap::Clamp], ..texture };
        let (w, h) = (texture.width, texture.height);
        // Bilinear lookups spread the light of a pixel over its neighbours. The maximum over the neighbours ensures
        // that every bright point can be sampled.
        let average = |value: &dyn Fn(usize, usize) -> f32| {
            let row = |y: usize| f64::from(band(y, h)) * (0..w).map(|x| f64::from(value(x, y))).sum::<f64>();
            ((0..h).map(row).sum::<f64>() / (2.0 * w as f64)) as f32
        };
        let mean = average(&|x, y| brightness(texture.pixels.get(y * w + x)));
        let bright = |x: usize, y: usize| {
            let mut most = 0.0f32;
            for row in y.saturating_sub(1)..=(y + 1).min(h - 1) {
                for dx in [w - 1, 0, 1] {
                    most = most.max(brightness(texture.pixels.get(row * w + (x + dx) % w)));
                }
            }
            (most - mean).max(0.0)
        };
        let excess = average(&bright);
        let columns = (0..h).map(|y| PiecewiseConstant1D::new((0..w).map(|x| bright(x, y)))).collect();
        let rows = PiecewiseConstant1D::new((0..h).map(|y| band(y, h) * (0..w).map(|x| bright(x, y)).sum::<f32>()));
        Map { texture, excess: if excess > EVEN * mean { excess } else { 0.0 }, rows, columns }
    }

    /// The direction of a point of the image. The middle is −z, and the top is +y.
    pub(super) fn direction(uv: Vec2) -> Vec3 {
        let (sin_theta, cos_theta) = ((1.0 - uv.y) * PI).sin_cos();
        let (sin, cos) = ((uv.x - 0.5) * TAU).sin_cos();
        Vec3::new(sin_theta * sin, cos_theta, -sin_theta * cos)
    }

    pub(super) fn uv(d: Vec3) -> Vec2 {
        Vec2::new(0.5 + d.x.atan2(-d.z) / TAU, 1.0 - d.x.hypot(d.z).atan2(d.y) / PI)
    }

    /// A point of the image in proportion to its excess brightness, and its density per solid angle.
    pub(super) fn sample(&self, u: [f32; 2]) -> (Vec2, f32) {
        let (y, t) = self.rows.pick(u[1]);
        let (x, s) = self.columns[y].pick(u[0]);
        // Uniform in the cosine: the density per solid angle is constant over a texel, at the poles too.
        let edge = |y: usize| (y as f32 / self.texture.height as f32 * PI).cos();
        let cos = edge(y) + t * (edge(y + 1) - edge(y));
        let uv = Vec2::new((x as f32 + s) / self.texture.width as f32, 1.0 - cos.clamp(-1.0, 1.0).acos() / PI);
        (uv, self.pdf(uv))
    }

    pub(super) fn pdf(&self, uv: Vec2) -> f32 {
        let (w, h) = (self.texture.width, self.texture.height);
        let x = ((uv.x.rem_euclid(1.0) * w as f32) as usize).min(w - 1);
        let y = (((1.0 - uv.y) * h as f32) as usize).min(h - 1);
        let share = self.rows.width(y) * self.columns[y].width(x);
        share * w as f32 / (TAU * band(y, h))
    }
}

/// The direction in a dome's image that a ray sees. The image is projected onto a disk of ground and onto a sphere. The
/// centre of the sphere is the point where the image was taken, and the sphere contains the edge of the disk. For rays
/// that start below the disk or outside the sphere, the image is infinitely far away.
pub(super) fn from_ground(ground: &Ground, up: Vec3, ray: &Ray) -> Vec3 {
    let taken = ground.origin + up * ground.height;
    let from = ray.origin - taken;
    let radius2 = ground.radius * ground.radius + ground.height * ground.height;
    let above = (ray.origin - ground.origin).dot(up);
    if from.length_squared() >= radius2 || above <= 0.0 {
        return ray.direction;
    }
    let sinks = -ray.direction.dot(up);
    if sinks > 0.0 {
        let seen = ray.at(above / sinks);
        if (seen - ground.origin).length_squared() <= ground.radius * ground.radius {
            return seen - taken;
        }
    }
    let along = from.dot(ray.direction);
    let t = (along * along - from.length_squared() + radius2).sqrt() - along;
    from + ray.direction * t
}
