//! Lights: where they are, how they are sampled.
//!
//! A sky is sampled only where it is brighter than on the average, in proportion to the excess: the rest is found as well by
//! the directions that surfaces and fibres scatter to (Karlík et al. 2019, MIS compensation). An even sky is not sampled at all.

mod distribution;

use crate::geometry::ray::{Ray, across};
use crate::light::distribution::Intervals;
use glam::{Mat3, Mat4, Vec2, Vec3};
use std::f32::consts::{PI, TAU};
use vellus_scene::{Ground, Light, Texture};

/// A direction toward a light.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit length.
    pub direction: Vec3,
    /// How far the light is; infinite for what is beyond the scene.
    pub distance: f32,
    /// RGB.
    pub radiance: [f32; 3],
    /// Per solid angle, with the light's own probability in it. Infinite for a single direction, whose `radiance` is then
    /// the irradiance over that probability.
    pub pdf: f32,
}

/// Radiance a ray finds, and the density of sampling that direction.
#[derive(Clone, Copy, Debug)]
pub struct Emission {
    /// Distance at which it is.
    pub t: f32,
    /// RGB.
    pub radiance: [f32; 3],
    /// Per solid angle, with the light's own probability in it. 0 where lights are not sampled.
    pub pdf: f32,
}

/// All lights of a scene.
#[derive(Clone, Debug)]
pub struct Lights {
    lights: Vec<Prepared>,
    /// Probability of each, all 0 where none is worth sampling; and to draw one.
    shares: Vec<f32>,
    chances: Intervals,
}

#[derive(Clone, Debug)]
enum Prepared {
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

/// A lat-long image and its distribution: rows, and pixels within each, by excess brightness and solid angle.
#[derive(Clone, Debug)]
struct Map {
    texture: Texture,
    /// Brightness above the average, averaged over the sphere; 0 where it is nowhere worth mentioning.
    excess: f32,
    /// Rows, and the pixels of each.
    rows: Intervals,
    columns: Vec<Intervals>,
}

/// A sky whose excess is this small a share of its brightness is even.
const EVEN: f32 = 1e-3;

fn brightness(c: [f32; 3]) -> f32 {
    c[0] + c[1] + c[2]
}

/// Cosine of the upper edge of a row of an image less that of the lower.
fn band(y: usize, h: usize) -> f32 {
    let edge = |y: usize| (y as f32 / h as f32 * PI).cos();
    edge(y) - edge(y + 1)
}

impl Map {
    fn new(texture: Texture) -> Self {
        let (w, h) = (texture.width, texture.height);
        // Bilinear lookups reach half a pixel further: the largest of the neighbours, so that nothing bright is never sampled.
        let average = |value: &dyn Fn(usize, usize) -> f32| {
            let row = |y: usize| f64::from(band(y, h)) * (0..w).map(|x| f64::from(value(x, y))).sum::<f64>();
            ((0..h).map(row).sum::<f64>() / (2.0 * w as f64)) as f32
        };
        let mean = average(&|x, y| brightness(texture.pixels[y * w + x]));
        let bright = |x: usize, y: usize| {
            let mut most = 0.0f32;
            for dy in [h - 1, 0, 1] {
                for dx in [w - 1, 0, 1] {
                    most = most.max(brightness(texture.pixels[(y + dy) % h * w + (x + dx) % w]));
                }
            }
            (most - mean).max(0.0)
        };
        let excess = average(&bright);
        let columns = (0..h).map(|y| Intervals::new((0..w).map(|x| bright(x, y)))).collect();
        let rows = Intervals::new((0..h).map(|y| band(y, h) * (0..w).map(|x| bright(x, y)).sum::<f32>()));
        Map { texture, excess: if excess > EVEN * mean { excess } else { 0.0 }, rows, columns }
    }

    /// The direction of a place in the image: its middle is −z, its top +y.
    fn direction(uv: Vec2) -> Vec3 {
        let (sin_theta, cos_theta) = ((1.0 - uv.y) * PI).sin_cos();
        let (sin, cos) = ((uv.x - 0.5) * TAU).sin_cos();
        Vec3::new(sin_theta * sin, cos_theta, -sin_theta * cos)
    }

    fn uv(d: Vec3) -> Vec2 {
        Vec2::new(0.5 + d.x.atan2(-d.z) / TAU, 1.0 - d.x.hypot(d.z).atan2(d.y) / PI)
    }

    /// A place in proportion to its excess brightness, and the density per solid angle.
    fn sample(&self, u: [f32; 2]) -> (Vec2, f32) {
        let (y, t) = self.rows.pick(u[1]);
        let (x, s) = self.columns[y].pick(u[0]);
        // Uniform in the cosine: per solid angle, a texel's density is the same all over it, at the poles too.
        let edge = |y: usize| (y as f32 / self.texture.height as f32 * PI).cos();
        let cos = edge(y) + t * (edge(y + 1) - edge(y));
        let uv = Vec2::new((x as f32 + s) / self.texture.width as f32, 1.0 - cos.clamp(-1.0, 1.0).acos() / PI);
        (uv, self.pdf(uv))
    }

    fn pdf(&self, uv: Vec2) -> f32 {
        let (w, h) = (self.texture.width, self.texture.height);
        let x = ((uv.x.rem_euclid(1.0) * w as f32) as usize).min(w - 1);
        let y = (((1.0 - uv.y) * h as f32) as usize).min(h - 1);
        let share = self.rows.width(y) * self.columns[y].width(x);
        share * w as f32 / (TAU * band(y, h))
    }
}

impl Lights {
    /// Prepares them; `reach` is the radius of the scene, which what is beyond it lights.
    pub fn new(lights: &[Light], textures: &[Texture], reach: f32) -> Self {
        let lights: Vec<Prepared> = lights.iter().map(|light| prepare(light, textures)).collect();
        let powers: Vec<f32> = lights.iter().map(|light| light.power(reach)).collect();
        let any = powers.iter().any(|&power| power > 0.0);
        let chances = Intervals::new(powers.into_iter());
        let shares = (0..lights.len()).map(|i| if any { chances.width(i) } else { 0.0 }).collect();
        Lights { lights, shares, chances }
    }

    /// A direction from `point` toward one of them, and which that is. `None` where the light has nothing to send there, or
    /// none is worth sampling.
    pub fn sample(&self, point: Vec3, u: [f32; 3]) -> Option<(usize, LightSample)> {
        if self.lights.is_empty() {
            return None;
        }
        let (i, _) = self.chances.pick(u[2]);
        let share = self.shares[i];
        if share <= 0.0 {
            return None;
        }
        let sample = self.lights[i].sample(point, [u[0], u[1]])?;
        if sample.pdf.is_infinite() {
            return Some((i, LightSample { radiance: sample.radiance.map(|r| r / share), ..sample }));
        }
        (sample.pdf > 0.0).then_some((i, LightSample { pdf: sample.pdf * share, ..sample }))
    }

    /// Of the lights of a shape that a ray meets before its limit, the nearest, and which that is.
    pub fn met(&self, ray: &Ray) -> Option<(usize, Emission)> {
        let mut best: Option<(usize, Emission)> = None;
        for (i, light) in self.lights.iter().enumerate() {
            let limit = best.map_or(ray.limit, |(_, b)| b.t);
            if let Some(emission) = light.met(&Ray { limit, ..*ray }) {
                best = Some((i, Emission { pdf: emission.pdf * self.shares[i], ..emission }));
            }
        }
        best
    }

    /// What is beyond the scene along a ray: of each light, which it is, its radiance and density. The camera's rays see ground.
    pub fn beyond<'a>(&'a self, ray: &'a Ray, camera: bool) -> impl Iterator<Item = (usize, Emission)> + 'a {
        self.lights.iter().zip(&self.shares).enumerate().filter_map(move |(i, (light, share))| {
            let emission = light.beyond(ray, camera)?;
            Some((i, Emission { pdf: emission.pdf * share, ..emission }))
        })
    }
}

fn prepare(light: &Light, textures: &[Texture]) -> Prepared {
    let flat = |m: &Mat4, disk: bool, radiance: [f32; 3], texture: Option<usize>| {
        let half = if disk { 1.0 } else { 0.5 };
        let (x, y) = (m.transform_vector3(Vec3::X) * half, m.transform_vector3(Vec3::Y) * half);
        let cross = x.cross(y);
        // It shines toward −z of its own frame.
        let away = m.transform_vector3(-Vec3::Z);
        let normal = cross.normalize_or(Vec3::Y) * if cross.dot(away) < 0.0 { -1.0 } else { 1.0 };
        let area = cross.length() * if disk { PI } else { 4.0 };
        let texture = texture.map(|i| textures[i].clone());
        Prepared::Flat { center: m.transform_point3(Vec3::ZERO), x, y, normal, area, disk, radiance, texture }
    };
    match light {
        Light::Dome { radiance, texture, rotation, ground } => {
            let map = texture.map(|i| Map::new(textures[i].clone()));
            Prepared::Dome { radiance: *radiance, map, rotation: *rotation, ground: *ground }
        }
        Light::Distant { direction, half_angle, irradiance } => {
            // A cone of half angle a has a projected solid angle of π sin²a.
            let spread = PI * half_angle.sin().powi(2);
            let scale = if spread > 1e-9 { 1.0 / spread } else { 1.0 };
            Prepared::Distant {
                direction: direction.normalize(),
                half_angle: if spread > 1e-9 { half_angle.min(0.5 * PI) } else { 0.0 },
                radiance: irradiance.map(|e| e * scale),
            }
        }
        Light::Rect { to_world, radiance, texture } => flat(to_world, false, *radiance, *texture),
        Light::Disk { to_world, radiance } => flat(to_world, true, *radiance, None),
        Light::Sphere { center, radius, radiance } => {
            Prepared::Sphere { center: *center, radius: *radius, radiance: *radiance }
        }
        Light::Cylinder { center, half_axis, radius, radiance } => Prepared::Cylinder {
            center: *center,
            axis: half_axis.normalize(),
            half_length: half_axis.length(),
            radius: *radius,
            radiance: *radiance,
        },
    }
}

impl Prepared {
    /// Power it sends into a scene of that radius, roughly: what lights are chosen by. Of a sky, that of its excess.
    fn power(&self, reach: f32) -> f32 {
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
            Prepared::Sphere { radius, radiance, .. } => 4.0 * PI * PI * radius * radius * brightness(*radiance),
            Prepared::Cylinder { half_length, radius, radiance, .. } => {
                4.0 * PI * PI * radius * half_length * brightness(*radiance)
            }
        }
    }

    fn sample(&self, point: Vec3, u: [f32; 2]) -> Option<LightSample> {
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
            Prepared::Sphere { center, radius, radiance } => {
                let to = *center - point;
                let cos = cos_max(to, *radius)?;
                let direction = uniform_cone(to.normalize(), cos, u);
                let t = sphere_entry(point, direction, *center, *radius).unwrap_or(to.dot(direction));
                Some(LightSample { direction, distance: t, radiance: *radiance, pdf: cone_pdf(cos) })
            }
            Prepared::Cylinder { center, axis, half_length, radius, radiance } => {
                // Across the axis in proportion to the angle it is seen under, along the axis in proportion to length:
                // unlike that of points on its surface, this density is finite where the surface is seen from the side.
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

    fn met(&self, ray: &Ray) -> Option<Emission> {
        match self {
            Prepared::Flat { center, x, y, normal, area, disk, radiance, texture } => {
                let cos = -ray.direction.dot(*normal);
                if cos <= 0.0 {
                    return None;
                }
                let t = (ray.origin - *center).dot(*normal) / cos;
                if t <= 0.0 || t >= ray.limit {
                    return None;
                }
                // Coordinates in a frame that need not be orthogonal.
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
                (t < ray.limit).then_some(Emission { t, radiance: *radiance, pdf: cone_pdf(cos) })
            }
            Prepared::Cylinder { center, axis, half_length, radius, radiance } => {
                let from = ray.origin - *center;
                let (_, _, angle) = seen_across(from, *axis, *radius)?;
                let (t, sin2) = cylinder_entry(from, ray.direction, *axis, *radius)?;
                let along = (from + ray.direction * t).dot(*axis);
                let is_met = t < ray.limit && along.abs() <= *half_length;
                // As in `sample`, where the distance across the axis is t times the sine.
                let pdf = t / (sin2 * 4.0 * angle * half_length);
                is_met.then_some(Emission { t, radiance: *radiance, pdf })
            }
            _ => None,
        }
    }

    fn beyond(&self, ray: &Ray, camera: bool) -> Option<Emission> {
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

/// The direction from where a dome's image was taken to what a ray sees of it: a disk of ground, or the sphere about that place which
/// meets the disk's edge. From below or beyond these the image is infinitely far away.
fn from_ground(ground: &Ground, up: Vec3, ray: &Ray) -> Vec3 {
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

fn textured(radiance: [f32; 3], texture: Option<&Texture>, a: f32, b: f32) -> [f32; 3] {
    let Some(texture) = texture else { return radiance };
    // Half a texel inside: it does not repeat.
    let hold = |x: f32, n: usize| (0.5 * x + 0.5).clamp(0.5 / n as f32, 1.0 - 0.5 / n as f32);
    let texel = texture.at(Vec2::new(hold(a, texture.width), hold(b, texture.height)));
    [0, 1, 2].map(|c| radiance[c] * texel[c])
}

/// 1 over the solid angle of a cone.
fn cone_pdf(cos: f32) -> f32 {
    1.0 / (TAU * (1.0 - cos).max(1e-12))
}

fn uniform_cone(axis: Vec3, cos_max: f32, u: [f32; 2]) -> Vec3 {
    let cos = 1.0 - u[0] * (1.0 - cos_max);
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (s, c) = (TAU * u[1]).sin_cos();
    let (x, y) = across(axis);
    (x * (sin * c) + y * (sin * s) + axis * cos).normalize()
}

/// A point of the unit disk (Shirley and Chiu 1997).
pub fn concentric(u: [f32; 2]) -> (f32, f32) {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    if a == 0.0 && b == 0.0 {
        return (0.0, 0.0);
    }
    let (r, phi) = if a.abs() > b.abs() { (a, PI / 4.0 * b / a) } else { (b, PI / 2.0 - PI / 4.0 * a / b) };
    (r * phi.cos(), r * phi.sin())
}

/// Cosine of the half angle a sphere is seen under; `None` from inside.
fn cos_max(to: Vec3, radius: f32) -> Option<f32> {
    let sin2 = radius * radius / to.length_squared();
    (sin2 < 1.0).then(|| (1.0 - sin2).sqrt())
}

fn sphere_entry(origin: Vec3, direction: Vec3, center: Vec3, radius: f32) -> Option<f32> {
    let to = center - origin;
    let along = to.dot(direction);
    let off2 = (to - direction * along).length_squared();
    let t = along - (radius * radius - off2).max(0.0).sqrt();
    (off2 <= radius * radius && t > 0.0).then_some(t)
}

/// How an endless cylinder is seen across its axis by a point, which lies `from` its centre: the direction and the
/// distance from the axis to the point, and half the angle it is seen under. `None` from inside.
fn seen_across(from: Vec3, axis: Vec3, radius: f32) -> Option<(Vec3, f32, f32)> {
    let off = from - axis * from.dot(axis);
    let distance = off.length();
    (distance > radius).then(|| (off / distance, distance, (radius / distance).asin()))
}

/// Where a ray that starts `from` its centre enters an endless cylinder, and the squared sine of its angle to the axis.
fn cylinder_entry(from: Vec3, direction: Vec3, axis: Vec3, radius: f32) -> Option<(f32, f32)> {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(width: usize, height: usize) -> Texture {
        let pixel = |i: usize| {
            let x = ((i * 7 + 3) % 11) as f32;
            [0.1 + x * x * 0.05, 0.2, 0.3 * x]
        };
        Texture {
            name: "sky".to_owned(),
            width,
            height,
            pixels: (0..width * height).map(pixel).collect(),
            wrap: [vellus_scene::Wrap::Repeat; 2],
        }
    }

    fn tube() -> Light {
        let (center, half_axis) = (Vec3::new(-1.2, 0.5, -1.5), Vec3::new(0.8, 0.7, 0.1));
        Light::Cylinder { center, half_axis, radius: 0.3, radiance: [4.0, 1.0, 2.0] }
    }

    fn lights() -> (Vec<Light>, Vec<Texture>) {
        let place = |x: f32, size: f32| {
            Mat4::from_cols(
                Vec3::new(size, 0.2, 0.0).extend(0.0),
                Vec3::new(0.0, size * 0.7, 0.3).extend(0.0),
                Vec3::Z.extend(0.0),
                Vec3::new(x, 0.3, 2.0).extend(1.0),
            )
        };
        let lights = vec![
            Light::Dome {
                radiance: [0.5, 1.0, 2.0],
                texture: Some(0),
                rotation: Mat3::from_rotation_y(0.7),
                ground: None,
            },
            Light::Distant { direction: Vec3::new(1.0, 2.0, 0.5), half_angle: 0.3, irradiance: [2.0, 1.0, 0.5] },
            Light::Rect { to_world: place(0.5, 1.1), radiance: [3.0, 2.0, 1.0], texture: None },
            Light::Disk { to_world: place(-2.0, 0.6), radiance: [1.0, 5.0, 1.0] },
            Light::Sphere { center: Vec3::new(0.0, -2.0, 0.4), radius: 0.8, radiance: [2.0, 2.0, 7.0] },
            tube(),
        ];
        (lights, vec![texture(16, 8)])
    }

    /// Where lights are sampled, sampling toward them and shooting uniformly find the same light, each light alone and all
    /// together; and the density a ray reports is that of sampling it.
    #[test]
    fn sampling_finds_what_rays_find() {
        let (all, textures) = lights();
        let sets = all.iter().map(|light| vec![light.clone()]).chain([all.clone()]);
        for (which, set) in sets.enumerate() {
            let lights = Lights::new(&set, &textures, 1.0);
            let point = Vec3::new(0.1, 0.2, -0.3);
            let seen = |direction: Vec3| {
                let ray = Ray::new(point, direction);
                match lights.met(&ray) {
                    Some((_, emission)) => vec![emission],
                    None => lights.beyond(&ray, false).map(|(_, emission)| emission).collect(),
                }
            };
            let n = 200_000;
            let (mut sampled, mut shot) = ([0.0f64; 2], [0.0f64; 2]);
            let mut draw = |u: [f32; 4]| {
                if let Some((_, s)) = lights.sample(point, [u[0], u[1], u[2]]) {
                    // Only as far as nothing nearer is in the way.
                    let open = seen(s.direction).iter().any(|e| (e.t - s.distance).abs() < 1e-3 || e.t == s.distance);
                    if open {
                        sampled[0] += f64::from(brightness(s.radiance) / s.pdf);
                        if set.len() == 1 {
                            let pdf = seen(s.direction)[0].pdf;
                            assert!((pdf / s.pdf - 1.0).abs() < 2e-2, "light {which}: {pdf} {}", s.pdf);
                        }
                    }
                    sampled[1] += 1.0;
                }
                let direction = uniform_cone(Vec3::Z, -1.0, [u[0], u[3]]);
                let found = seen(direction).into_iter().filter(|e| e.pdf > 0.0);
                shot[0] += found.map(|e| f64::from(brightness(e.radiance) * 4.0 * PI)).sum::<f64>();
                shot[1] += 1.0;
            };
            for index in 0..n {
                draw(crate::integrator::sampler::Sampler::new([which as u32, index as u32 >> 16], index, 3).next());
            }
            let (a, b) = (sampled[0] / n as f64, shot[0] / n as f64);
            // Uniform rays hit the smallest, 0.3 sr, 4800 times: 1.5 % one standard error at most.
            assert!((a / b - 1.0).abs() < 0.03, "light {which}: sampled {a}, shot {b}");
        }
    }

    /// What a cylinder sends to a small plane: an integral over its surface, and the mean over samples. From the side,
    /// from beyond an end, from near by; from within the endless cylinder nothing of its outside is seen.
    #[test]
    fn a_cylinder_sends_what_its_surface_does() {
        let Light::Cylinder { center, half_axis, radius, .. } = tube() else { panic!() };
        let lights = Lights::new(&[tube()], &[], 1.0);
        let (axis, half) = (half_axis.normalize().as_dvec3(), f64::from(half_axis.length()));
        let (x, y) = { axis.any_orthonormal_pair() };
        let at = |along: f64, off: f64| center.as_dvec3() + axis * (along * half) + x * (off * f64::from(radius));
        for point in [at(0.2, 6.0), at(2.5, 3.0), at(-0.9, 1.05), at(0.0, 200.0)] {
            let point = point.as_vec3().as_dvec3();
            let normal = (center.as_dvec3() - point).normalize();
            let n = 1500;
            let mut expected = 0.0;
            for i in 0..n {
                let (sin, cos) = ((f64::from(i) + 0.5) / f64::from(n) * std::f64::consts::TAU).sin_cos();
                let out = x * cos + y * sin;
                for k in 0..n {
                    let along = (2.0 * (f64::from(k) + 0.5) / f64::from(n) - 1.0) * half;
                    let to = center.as_dvec3() + out * f64::from(radius) + axis * along - point;
                    let (d2, d) = (to.length_squared(), to.length());
                    expected += (-to.dot(out) / d).max(0.0) * (to.dot(normal) / d).max(0.0) / d2;
                }
            }
            expected *= 2.0 * std::f64::consts::TAU * f64::from(radius) * half / f64::from(n * n);
            let samples = 40_000;
            let (mut sum, mut squares) = (0.0, 0.0);
            for index in 0..samples {
                let u = crate::integrator::sampler::Sampler::new([5, index >> 16], u64::from(index), 3).next();
                let found = lights
                    .sample(point.as_vec3(), [u[0], u[1], u[2]])
                    .map_or(0.0, |(_, s)| f64::from(s.direction.dot(normal.as_vec3()).max(0.0) / s.pdf));
                (sum, squares) = (sum + found, squares + found * found);
            }
            let count = f64::from(samples);
            let mean = sum / count;
            let error = ((squares / count - mean * mean) / count).sqrt();
            // Five standard errors: a false alarm in 1.7 million. The grid's own error is below 1e-5 of it, single
            // precision's too.
            assert!((mean - expected).abs() < 5.0 * error + 3e-5 * expected, "{point}: {mean} {expected} ± {error}");
        }
        for inside in [at(0.3, 0.5), at(4.0, 0.9)] {
            assert!(lights.sample(inside.as_vec3(), [0.3, 0.6, 0.5]).is_none());
            let ray = Ray::new(inside.as_vec3(), (center - inside.as_vec3() + Vec3::new(0.1, 0.0, 0.0)).normalize());
            assert!(lights.met(&ray).is_none());
        }
    }

    /// An even sky is left to the directions that things scatter to, alone and beside a lamp; of another, what is darker than the
    /// average is.
    #[test]
    fn what_is_even_is_not_sampled() {
        let (all, textures) = lights();
        let even = Texture { pixels: vec![[0.3, 0.7, 0.1]; 128], ..textures[0].clone() };
        let dome = |texture| Light::Dome { radiance: [0.5, 1.0, 2.0], texture, rotation: Mat3::IDENTITY, ground: None };
        let up = Ray::new(Vec3::ZERO, Vec3::Y);
        for sky in [dome(None), dome(Some(0))] {
            let alone = Lights::new(std::slice::from_ref(&sky), std::slice::from_ref(&even), 1.0);
            assert!(alone.sample(Vec3::ZERO, [0.4, 0.2, 0.7]).is_none());
            assert!(alone.beyond(&up, false).all(|(_, e)| e.pdf == 0.0 && e.radiance[1] > 0.0));
            let lamp = Lights::new(&[sky, all[4].clone()], std::slice::from_ref(&even), 1.0);
            assert!((0..9).all(|i| lamp.sample(Vec3::ZERO, [0.4, 0.2, i as f32 / 9.0]).is_some_and(|(i, _)| i == 1)));
        }
        let bright = |i: usize| {
            if i % 16 < 5 { [2.0, 3.0, 1.0 + (i / 16) as f32] } else { [0.2, 0.5 + 0.1 * (i % 3) as f32, 0.4] }
        };
        let sun = Texture { pixels: (0..128).map(bright).collect(), ..even };
        let map = Map::new(sun.clone());
        let texel = |y: usize, x: usize| Vec2::new((x as f32 + 0.5) / 16.0, 1.0 - (y as f32 + 0.5) / 8.0);
        let mean = |f: &dyn Fn(usize, usize) -> f32| {
            (0..128).map(|i| band(i / 16, 8) * f(i / 16, i % 16)).sum::<f32>() / (2.0 * 16.0)
        };
        let average = mean(&|y, x| brightness(sun.pixels[y * 16 + x]));
        let sampled = |y, x| map.pdf(texel(y, x)) > 0.0;
        assert!((0..128).all(|i| sampled(i / 16, i % 16) || brightness(sun.pixels[i]) <= average));
        // But next to the bright ones, whose light lookups spread.
        assert_eq!((0..128).filter(|&i| !sampled(i / 16, i % 16)).count(), 9 * 8);
        assert!((4.0 * PI * mean(&|y, x| map.pdf(texel(y, x))) - 1.0).abs() < 1e-4);
    }

    /// From anywhere above the ground the camera sees on it what was there when the image was taken: a pattern painted on the
    /// ground, seen from the place of the image, comes back where it was painted. Light comes as ever.
    #[test]
    fn ground_is_seen_where_it_was() {
        let pattern = |p: Vec2| [0.5 + 0.4 * (0.9 * p.x).sin(), 0.5 + 0.4 * (1.3 * p.y).cos(), 0.25];
        let (origin, height, radius) = (Vec3::new(1.0, -0.5, 2.0), 1.6, 12.0);
        let rotation = Mat3::from_rotation_x(0.4) * Mat3::from_rotation_y(0.7);
        let up = rotation.y_axis;
        let (w, h) = (2048, 1024);
        let pixel = |i: usize| {
            let uv = Vec2::new(((i % w) as f32 + 0.5) / w as f32, 1.0 - ((i / w) as f32 + 0.5) / h as f32);
            let d = Map::direction(uv);
            if d.y >= 0.0 { [0.0, 0.0, 1.0 + d.y] } else { pattern(Vec2::new(d.x, d.z) * (height / -d.y)) }
        };
        let image = Texture {
            name: "g".to_owned(),
            width: w,
            height: h,
            pixels: (0..w * h).map(pixel).collect(),
            wrap: [vellus_scene::Wrap::Repeat; 2],
        };
        let ground = Ground { origin, height, radius };
        let dome = Light::Dome { radiance: [1.0, 1.0, 2.0], texture: Some(0), rotation, ground: Some(ground) };
        let lights = Lights::new(&[dome], &[image], 1.0);
        let seen = |ray: &Ray, camera: bool| lights.beyond(ray, camera).next().unwrap().1.radiance;
        for i in 0..2000 {
            let [a, b, c, d] = crate::integrator::sampler::Sampler::new([1, 2], i, 3).next();
            let spot = Vec2::new(6.0 * a - 3.0, 6.0 * b - 3.0);
            let target = origin + rotation * Vec3::new(spot.x, 0.0, spot.y);
            let eye = origin + rotation * Vec3::new(4.0 * c - 2.0, 0.3 + 3.0 * d, 1.5);
            let found = seen(&Ray::new(eye, (target - eye).normalize()), true);
            let expected = pattern(spot);
            // A texel spans 0.003 rad: at 4.5 from 1.6 above 0.04 of ground, where the pattern changes by 0.02 at most.
            assert!((0..2).all(|k| (found[k] - expected[k]).abs() < 0.02), "{spot}: {found:?} {expected:?}");
            // Ground and sphere meet at the edge; upward is sky.
            let edge = origin + rotation * (Vec3::new(spot.x, 0.0, spot.y).normalize() * radius);
            let from = |to: Vec3| from_ground(&ground, up, &Ray::new(eye, (to - eye).normalize())).normalize();
            assert!(from(edge + 1e-3 * up).distance(from(edge - 1e-3 * up)) < 1e-3);
            assert!(from(edge + 1e-3 * up).distance((edge - origin - height * up).normalize()) < 1e-3);
            assert!(seen(&Ray::new(eye, (edge + 4.0 * up - eye).normalize()), true)[2] >= 2.0);
            let ray = Ray::new(eye, (target - eye).normalize());
            assert_eq!(seen(&ray, false), seen(&Ray::new(Vec3::splat(100.0), ray.direction), true));
        }
    }
}
