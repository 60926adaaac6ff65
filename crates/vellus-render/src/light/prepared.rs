//! One light, prepared for sampling and for rays.

use super::environment::{Map, from_ground};
use super::sampling::{concentric, cone_pdf, cos_max, cylinder_entry, seen_across, sphere_entry, uniform_cone};
use super::{Emission, LightSample, brightness};
use crate::geometry::ray::Ray;
use glam::{Mat3, Mat4, Vec2, Vec3};
use std::f32::consts::PI;
use vellus_scene::{Ground, LightShape, Texture};

#[derive(Clone, Debug)]
pub(crate) enum Prepared {
    Dome {
        radiance: [f32; 3],
        map: Option<Map>,
        rotation: Mat3,
        ground: Option<Ground>,
    },
    Distant {
        direction: Vec3,
        half_angle: f32,
        radiance: [f32; 3],
    },
    Flat {
        center: Vec3,
        x: Vec3,
        y: Vec3,
        normal: Vec3,
        area: f32,
        disk: bool,
        radiance: [f32; 3],
        texture: Option<Texture>,
    },
    Point {
        position: Vec3,
        intensity: [f32; 3],
    },
    Sphere {
        center: Vec3,
        radius: f32,
        radiance: [f32; 3],
    },
    Cylinder {
        center: Vec3,
        /// Unit length.
        axis: Vec3,
        half_length: f32,
        radius: f32,
        radiance: [f32; 3],
    },
}

/// Prepares a light of a scene.
pub(super) fn prepare(light: &LightShape, textures: &[Texture]) -> Prepared {
    let flat = |m: &Mat4, disk: bool, radiance: [f32; 3], texture: Option<usize>| {
        let half = if disk { 1.0 } else { 0.5 };
        let (x, y) = (m.transform_vector3(Vec3::X) * half, m.transform_vector3(Vec3::Y) * half);
        let cross = x.cross(y);
        // It emits toward −z of its own frame.
        let away = m.transform_vector3(-Vec3::Z);
        let normal = cross.normalize_or(Vec3::Y) * if cross.dot(away) < 0.0 { -1.0 } else { 1.0 };
        let area = cross.length() * if disk { PI } else { 4.0 };
        let texture = texture.map(|i| textures[i].clone());
        Prepared::Flat { center: m.transform_point3(Vec3::ZERO), x, y, normal, area, disk, radiance, texture }
    };
    match light {
        LightShape::Dome { radiance, texture, rotation, ground } => {
            let map = texture.map(|i| Map::new(textures[i].clone()));
            Prepared::Dome { radiance: *radiance, map, rotation: *rotation, ground: *ground }
        }
        LightShape::Distant { direction, half_angle, irradiance } => {
            // A cone of half angle a has a projected solid angle of π sin²a.
            let spread = PI * half_angle.sin().powi(2);
            let scale = if spread > 1e-9 { 1.0 / spread } else { 1.0 };
            Prepared::Distant {
                direction: direction.normalize(),
                half_angle: if spread > 1e-9 { half_angle.min(0.5 * PI) } else { 0.0 },
                radiance: irradiance.map(|e| e * scale),
            }
        }
        LightShape::Rect { to_world, radiance, texture } => flat(to_world, false, *radiance, *texture),
        LightShape::Disk { to_world, radiance } => flat(to_world, true, *radiance, None),
        LightShape::Point { position, intensity } => Prepared::Point { position: *position, intensity: *intensity },
        LightShape::Sphere { center, radius, radiance } => {
            Prepared::Sphere { center: *center, radius: *radius, radiance: *radiance }
        }
        LightShape::Cylinder { center, half_axis, radius, radiance } => Prepared::Cylinder {
            center: *center,
            axis: half_axis.normalize(),
            half_length: half_axis.length(),
            radius: *radius,
            radiance: *radiance,
        },
    }
}

impl Prepared {
    /// Multiplies the emission by a factor.
    pub(super) fn scale(&mut self, factor: f32) {
        self.radiance_mut().iter_mut().for_each(|channel| *channel *= factor);
    }

    /// Whether it emits nothing.
    pub(super) fn is_black(&self) -> bool {
        brightness(self.radiance()) <= 0.0
    }

    pub(crate) fn radiance(&self) -> [f32; 3] {
        match self {
            Prepared::Dome { radiance, .. }
            | Prepared::Distant { radiance, .. }
            | Prepared::Flat { radiance, .. }
            | Prepared::Sphere { radiance, .. }
            | Prepared::Cylinder { radiance, .. } => *radiance,
            Prepared::Point { intensity, .. } => *intensity,
        }
    }

    fn radiance_mut(&mut self) -> &mut [f32; 3] {
        match self {
            Prepared::Dome { radiance, .. }
            | Prepared::Distant { radiance, .. }
            | Prepared::Flat { radiance, .. }
            | Prepared::Sphere { radiance, .. }
            | Prepared::Cylinder { radiance, .. } => radiance,
            Prepared::Point { intensity, .. } => intensity,
        }
    }

    /// A rough estimate of the power that the light sends into a scene of this radius. Lights are chosen in proportion
    /// to it. For a sky, the power of its excess.
    pub(super) fn power(&self, reach: f32) -> f32 {
        let disk = PI * reach * reach;
        match self {
            Prepared::Dome { radiance, map, .. } => {
                let excess = map.as_ref().map_or(0.0, |map| map.excess);
                4.0 * PI * disk * excess * brightness(*radiance) / 3.0
            }
            Prepared::Distant { half_angle, radiance, .. } => {
                let spread = if *half_angle > 0.0 { PI * half_angle.sin().powi(2) } else { 1.0 };
                disk * spread * brightness(*radiance)
            }
            Prepared::Flat { area, radiance, .. } => PI * area * brightness(*radiance),
            Prepared::Point { intensity, .. } => 4.0 * PI * brightness(*intensity),
            Prepared::Sphere { radius, radiance, .. } => 4.0 * PI * PI * radius * radius * brightness(*radiance),
            Prepared::Cylinder { half_length, radius, radiance, .. } => {
                4.0 * PI * PI * radius * half_length * brightness(*radiance)
            }
        }
    }

    /// The direction that a flat light faces.
    pub(super) fn faces(&self) -> Option<Vec3> {
        match self {
            Prepared::Flat { normal, .. } => Some(*normal),
            _ => None,
        }
    }

    pub(super) fn sample(&self, point: Vec3, u: [f32; 2]) -> Option<LightSample> {
        let far = f32::INFINITY;
        match self {
            Prepared::Dome { radiance, map: Some(map), rotation, .. } => {
                let (uv, pdf) = map.sample(u);
                let texel = map.texture.at(uv);
                let radiance = [0, 1, 2].map(|c| radiance[c] * texel[c]);
                Some(LightSample { direction: *rotation * Map::direction(uv), distance: far, radiance, pdf })
            }
            Prepared::Dome { map: None, .. } => None,
            Prepared::Distant { direction, half_angle, radiance } => {
                if *half_angle == 0.0 {
                    let pdf = f32::INFINITY;
                    return Some(LightSample { direction: *direction, distance: far, radiance: *radiance, pdf });
                }
                let direction = uniform_cone(*direction, half_angle.cos(), u);
                Some(LightSample { direction, distance: far, radiance: *radiance, pdf: cone_pdf(half_angle.cos()) })
            }
            Prepared::Flat { center, x, y, normal, area, disk, radiance, texture } => {
                let (a, b) = if *disk { concentric(u) } else { (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0) };
                let to = *center + *x * a + *y * b - point;
                let distance = to.length();
                let direction = to / distance;
                let cos = -direction.dot(*normal);
                if cos <= 0.0 || distance <= 0.0 {
                    return None;
                }
                let radiance = textured(*radiance, texture.as_ref(), a, b);
                Some(LightSample { direction, distance, radiance, pdf: distance * distance / (cos * area) })
            }
            Prepared::Point { position, intensity } => {
                let to = *position - point;
                let distance = to.length();
                let radiance = intensity.map(|i| i / (distance * distance));
                let pdf = f32::INFINITY;
                (distance > 0.0).then(|| LightSample { direction: to / distance, distance, radiance, pdf })
            }
            Prepared::Sphere { center, radius, radiance } => {
                let to = *center - point;
                let cos = cos_max(to, *radius)?;
                let direction = uniform_cone(to.normalize(), cos, u);
                let t = sphere_entry(point, direction, *center, *radius).unwrap_or(to.dot(direction));
                Some(LightSample { direction, distance: t, radiance: *radiance, pdf: cone_pdf(cos) })
            }
            Prepared::Cylinder { center, axis, half_length, radius, radiance } => {
                // Uniform in the angle perpendicular to the axis, and in the length along it. Unlike a uniform density
                // on the surface, this density is finite where the surface is seen edge-on.
                let from = point - *center;
                let (toward, distance, angle) = seen_across(from, *axis, *radius)?;
                let (sin, cos) = ((2.0 * u[0] - 1.0) * angle).sin_cos();
                let depth = (radius * radius - (distance * sin).powi(2)).max(0.0).sqrt();
                let across = distance * cos - depth;
                let along = (2.0 * u[1] - 1.0) * half_length - from.dot(*axis);
                let direction = axis.cross(toward) * (sin * across) - toward * (cos * across) + *axis * along;
                let distance = direction.length();
                if across <= 0.0 {
                    return None;
                }
                let pdf = distance.powi(3) / (across * across * 4.0 * angle * half_length);
                Some(LightSample { direction: direction / distance, distance, radiance: *radiance, pdf })
            }
        }
    }

    pub(super) fn intersect(&self, ray: &Ray) -> Option<Emission> {
        match self {
            Prepared::Flat { center, x, y, normal, area, disk, radiance, texture } => {
                let cos = -ray.direction.dot(*normal);
                if cos <= 0.0 {
                    return None;
                }
                let t = (ray.origin - *center).dot(*normal) / cos;
                if t <= 0.0 || t >= ray.t_max {
                    return None;
                }
                // Coordinates in a frame that may be oblique.
                let p = ray.at(t) - *center;
                let (xx, xy, yy) = (x.dot(*x), x.dot(*y), y.dot(*y));
                let (px, py) = (p.dot(*x), p.dot(*y));
                let determinant = xx * yy - xy * xy;
                let (a, b) = ((px * yy - py * xy) / determinant, (py * xx - px * xy) / determinant);
                let inside = if *disk { a * a + b * b <= 1.0 } else { a.abs() <= 1.0 && b.abs() <= 1.0 };
                let radiance = textured(*radiance, texture.as_ref(), a, b);
                inside.then_some(Emission { t, radiance, pdf: t * t / (cos * area) })
            }
            Prepared::Sphere { center, radius, radiance } => {
                let t = sphere_entry(ray.origin, ray.direction, *center, *radius)?;
                let cos = cos_max(*center - ray.origin, *radius)?;
                (t < ray.t_max).then_some(Emission { t, radiance: *radiance, pdf: cone_pdf(cos) })
            }
            Prepared::Cylinder { center, axis, half_length, radius, radiance } => {
                let from = ray.origin - *center;
                let (_, _, angle) = seen_across(from, *axis, *radius)?;
                let (t, sin2) = cylinder_entry(from, ray.direction, *axis, *radius)?;
                let along = (from + ray.direction * t).dot(*axis);
                let is_met = t < ray.t_max && along.abs() <= *half_length;
                // The density is that of `sample`. The distance perpendicular to the axis is t times the sine.
                let pdf = t / (sin2 * 4.0 * angle * half_length);
                is_met.then_some(Emission { t, radiance: *radiance, pdf })
            }
            _ => None,
        }
    }

    pub(super) fn escaped(&self, ray: &Ray, camera: bool) -> Option<Emission> {
        let t = f32::INFINITY;
        match self {
            Prepared::Dome { radiance, map: Some(map), rotation, ground } => {
                let seen = ground.filter(|_| camera).map_or(ray.direction, |g| from_ground(&g, rotation.y_axis, ray));
                let uv = Map::uv(rotation.transpose() * seen);
                let texel = map.texture.at(uv);
                Some(Emission { t, radiance: [0, 1, 2].map(|c| radiance[c] * texel[c]), pdf: map.pdf(uv) })
            }
            Prepared::Dome { radiance, map: None, .. } => Some(Emission { t, radiance: *radiance, pdf: 0.0 }),
            Prepared::Distant { direction: center, half_angle, radiance } => {
                let inside = *half_angle > 0.0 && ray.direction.dot(*center) >= half_angle.cos();
                inside.then_some(Emission { t, radiance: *radiance, pdf: cone_pdf(half_angle.cos()) })
            }
            _ => None,
        }
    }
}

fn textured(radiance: [f32; 3], texture: Option<&Texture>, a: f32, b: f32) -> [f32; 3] {
    let Some(texture) = texture else { return radiance };
    // Stays half a texel inside, because the texture must not repeat.
    let hold = |x: f32, n: usize| (0.5 * x + 0.5).clamp(0.5 / n as f32, 1.0 - 0.5 / n as f32);
    let texel = texture.at(Vec2::new(hold(a, texture.width), hold(b, texture.height)));
    [0, 1, 2].map(|c| radiance[c] * texel[c])
}
