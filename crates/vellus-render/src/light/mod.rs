//! Lights: where they are, what they emit, and how they are sampled.

mod distribution;
mod environment;
mod prepared;
pub mod sampling;
#[cfg(test)]
mod tests;

use crate::geometry::ray::Ray;
use distribution::PiecewiseConstant1D;
use glam::Vec3;
use prepared::Prepared;
use vellus_scene::{Light, Texture};

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
    chances: PiecewiseConstant1D,
}

impl Lights {
    /// Prepares them; `reach` is the radius of the scene, which what is beyond it lights.
    pub fn new(lights: &[Light], textures: &[Texture], reach: f32) -> Self {
        let lights: Vec<Prepared> = lights.iter().map(|light| prepared::prepare(light, textures)).collect();
        let powers: Vec<f32> = lights.iter().map(|light| light.power(reach)).collect();
        let any = powers.iter().any(|&power| power > 0.0);
        let chances = PiecewiseConstant1D::new(powers.into_iter());
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
    pub fn intersect(&self, ray: &Ray) -> Option<(usize, Emission)> {
        let mut best: Option<(usize, Emission)> = None;
        for (i, light) in self.lights.iter().enumerate() {
            let t_max = best.map_or(ray.t_max, |(_, b)| b.t);
            if let Some(emission) = light.intersect(&Ray { t_max, ..*ray }) {
                best = Some((i, Emission { pdf: emission.pdf * self.shares[i], ..emission }));
            }
        }
        best
    }

    /// What is beyond the scene along a ray: of each light, which it is, its radiance and density. The camera's rays see ground.
    pub fn escaped<'a>(&'a self, ray: &'a Ray, camera: bool) -> impl Iterator<Item = (usize, Emission)> + 'a {
        self.lights.iter().zip(&self.shares).enumerate().filter_map(move |(i, (light, share))| {
            let emission = light.escaped(ray, camera)?;
            Some((i, Emission { pdf: emission.pdf * share, ..emission }))
        })
    }
}

/// The sum of the three channels.
fn brightness(c: [f32; 3]) -> f32 {
    c[0] + c[1] + c[2]
}
