//! Light meters: which exposure suits the lights of a world, and which a film.

use crate::World;
use crate::film::{Film, Layer};
use crate::geometry::instances::Hit;
use crate::geometry::ray::Ray;
use crate::integrator::path::shadow_t_max;
use crate::integrator::sampler::Sampler;
use crate::light::Emission;
use glam::Vec3;
use rayon::prelude::*;

/// The step of exposures by the incident light: a colour is off by 4 % at most.
const INCIDENT_STEP: f64 = 0.125;

/// The brightest place of the ball over the mean that is exposed for, at most.
const CONTRAST: f64 = 3.0;

/// Places on the ball that the light meter measures, and samples of the light at each.
const PLACES: usize = 64;
const METERED: u64 = 256;

/// The luminance that a picture has on average after metering, as the mean of logarithms. It is a little less than that
/// of a grey card, because the studio's background is darker.
const TARGET: f64 = 0.16;

/// Metering keeps at least this share of the pixels below white.
const BELOW_WHITE: f64 = 0.98;

/// Metering darkens a picture at most this many stops to keep its highlights.
const DARKEN: f64 = 1.0;

/// Exposures are multiples of this many stops, so that small changes of a scene do not change the exposure.
const STEP: f64 = 0.25;

/// The luminance of linear sRGB (Rec. 709).
pub(crate) fn luminance(c: [f64; 3]) -> f64 {
    0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]
}

impl Film {
    /// The luminance of each pixel and the share of the pixel that objects cover, row by row.
    pub(crate) fn luminances(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let places = (0..self.height()).flat_map(|y| (0..self.width()).map(move |x| (x, y)));
        places.map(move |(x, y)| {
            let color = [0, 1, 2].map(|c| self.mean(x, y, Layer::Beauty, c));
            (luminance(color), self.mean(x, y, Layer::Alpha, 0))
        })
    }

    /// The exposure that suits the film, in stops: a multiple of a quarter in [-100, 100].
    ///
    /// The mean of the logarithms of the luminance becomes 0.16, a little less than that of a grey card. Pixels count
    /// as far as objects cover them, and black pixels do not count. The exposure is up to one stop lower, to keep
    /// 98 % of these pixels below white. `None` if all pixels are black or empty.
    pub fn metered(&self) -> Option<f32> {
        let mut lit: Vec<(f64, f64)> = self.luminances().filter(|&(y, weight)| y > 0.0 && weight > 0.0).collect();
        let total: f64 = lit.iter().map(|(_, weight)| weight).sum();
        let mean = lit.iter().map(|(y, weight)| weight * y.log2()).sum::<f64>() / total;
        lit.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut below = 0.0;
        let (bright, _) = lit.iter().find(|(_, weight)| {
            below += weight;
            below >= BELOW_WHITE * total
        })?;
        let wanted = TARGET.log2() - mean;
        let stops = wanted.min((-bright.log2()).max(wanted - DARKEN));
        Some(((stops / STEP).round() * STEP).clamp(-100.0, 100.0) as f32)
    }
}

impl World {
    /// The exposure in stops with which white paper beside the fur is white: a multiple of an eighth in [-100, 100]. It
    /// does not depend on the colour of the fur, so dark fur stays dark.
    ///
    /// This is an incident light meter: the mean radiance of a white ball around the fur, as the camera sees it in
    /// direct light. With the light behind it, a third of that of its brightest place counts, so that rims keep their
    /// form. `None` without direct light.
    pub fn metered(&self) -> Option<f32> {
        let geometry = &self.geometry;
        let (middle, radius) = geometry.sphere()?;
        let place = |i: usize| middle + fibonacci(i, PLACES) * radius;
        let lit = |i: usize| self.irradiance(place(i), fibonacci(i, PLACES), i as u32) / std::f64::consts::PI;
        let readings: Vec<f64> = (0..PLACES).into_par_iter().map(lit).collect();
        let toward = (geometry.view.eyes()[0] - middle).normalize_or(Vec3::Z);
        let weights = (0..PLACES).map(|i| f64::from(fibonacci(i, PLACES).dot(toward).max(0.0)));
        let (seen, all) = readings.iter().zip(weights).fold((0.0, 0.0), |(s, a), (x, w)| (s + w * x, a + w));
        let brightest = readings.iter().copied().fold(0.0, f64::max);
        let stops = -(seen / all).max(brightest / CONTRAST).log2();
        stops.is_finite().then(|| ((stops / INCIDENT_STEP).round() * INCIDENT_STEP).clamp(-100.0, 100.0) as f32)
    }

    /// The direct light on a plane at a point: the brightest channel, so that coloured light does not end at white.
    fn irradiance(&self, point: Vec3, normal: Vec3, seed: u32) -> f64 {
        let lights = &self.geometry.lights;
        let sampled = |u: [f32; 3]| {
            let (light, sample) = lights.sample(0, point, u)?;
            let cos = normal.dot(sample.direction);
            let ray = Ray { t_max: shadow_t_max(&sample), ..Ray::new(point, sample.direction) };
            if cos <= 0.0 || self.geometry.shadows(&ray, light) {
                return None;
            }
            let density = if sample.pdf.is_infinite() { 1.0 } else { sample.pdf };
            Some(sample.radiance.map(|c| f64::from(c * cos / density)))
        };
        // Some lights are not sampled, such as a dome of one colour. A ray finds them.
        let found = |u: f32, v: f32| {
            let z = 1.0 - 2.0 * u;
            let (sin, cos) = (std::f32::consts::TAU * v).sin_cos();
            let sphere = Vec3::new((1.0 - z * z).sqrt() * cos, z, (1.0 - z * z).sqrt() * sin);
            let ray = Ray::new(point, (normal + sphere).normalize_or(normal));
            let hit = match self.geometry.intersect(&ray) {
                Some(Hit::Curve(hit)) => Some(hit.entry.t),
                Some(Hit::Triangle(hit)) => Some(hit.t),
                None => None,
            };
            let near = lights.intersect(&Ray { t_max: hit.unwrap_or(f32::INFINITY), ..ray }, Some(0));
            let far = lights.escaped(&ray, Some(0)).filter(|_| near.is_none() && hit.is_none());
            let all = near.into_iter().chain(far).filter(|(_, emission)| emission.pdf == 0.0);
            let light =
                |(_, emission): (usize, Emission)| emission.radiance.map(|c| std::f64::consts::PI * f64::from(c));
            all.map(light).fold([0.0; 3], plus)
        };
        let one = |index: u64| {
            let mut sampler = Sampler::new([seed, 0], index, 0);
            let ([x, y, z, _], [u, v, ..]) = (sampler.next(), sampler.next());
            plus(sampled([x, y, z]).unwrap_or_default(), found(u, v))
        };
        let sum = (0..METERED).map(one).fold([0.0; 3], plus);
        sum.into_iter().fold(0.0, f64::max) / METERED as f64
    }
}

fn plus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|c| a[c] + b[c])
}

/// One of `count` directions that are evenly distributed.
pub(crate) fn fibonacci(i: usize, count: usize) -> Vec3 {
    let y = 1.0 - (2 * i + 1) as f32 / count as f32;
    // The golden angle.
    let (sin, cos) = (i as f32 * 2.399_963).sin_cos();
    let r = (1.0 - y * y).sqrt();
    Vec3::new(r * cos, y, r * sin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Mat3;
    use vellus::{Color, Fiber};
    use vellus_scene::{LightShape, Look, Scene};

    fn stops(light: LightShape, color: f32) -> Option<f32> {
        let mut scene = vellus_groom::scene("cat", true).unwrap();
        // The ground hides half of a dome.
        scene.meshes.clear();
        scene.camera = scene.framing_along(Vec3::Z, 1.0);
        let fiber = Fiber::hair().with_color(Color::Reflectance([color; 3])).unwrap();
        scene.looks = vec![Look::constant("fur", fiber)];
        for strands in &mut scene.strands {
            strands.look = 0;
            strands.varying.clear();
        }
        World::new(Scene { lights: vec![light.into()], reflectance: vellus_scene::ReflectanceOf::Dense, ..scene })
            .unwrap()
            .metered()
    }

    /// White paper is white in a dome of radiance 1, and the colour of the fur does not matter. The fur hides some of
    /// the dome: a quarter of a stop.
    #[test]
    fn the_exposure_is_that_of_white_paper() {
        let dome = |radiance: f32| LightShape::Dome {
            radiance: [radiance; 3],
            texture: None,
            rotation: Mat3::IDENTITY,
            ground: None,
        };
        for color in [0.02, 0.9] {
            let [one, four] = [1.0, 4.0].map(|radiance| stops(dome(radiance), color).unwrap());
            assert!((0.0..=0.25).contains(&one), "{one}");
            assert_eq!(four, one - 2.0);
        }
        assert_eq!(stops(dome(0.0), 0.5), None);
        let sun = |direction| LightShape::Distant { direction, half_angle: 0.0, irradiance: [std::f32::consts::PI; 3] };
        let [front, back] = [Vec3::Z, -Vec3::Z].map(|direction| stops(sun(direction), 0.5));
        // The mean of a ball in frontal light is 2/3. From behind, a third of its brightest place counts.
        let [front, back] = [front.unwrap(), back.unwrap()];
        assert!((0.25..0.9).contains(&front) && (back - 1.625).abs() < 0.2, "{front} {back}");
    }
}
