//! Lights: their intersection with rays, their emission, and their sampling.

pub mod background;
pub(crate) mod distribution;
pub(crate) mod environment;
pub(crate) mod prepared;
pub mod sampling;
pub(crate) mod shaped;
#[cfg(test)]
mod tests;

use crate::geometry::ray::Ray;
use distribution::PiecewiseConstant1D;
use glam::Vec3;
use prepared::Prepared;
use shaped::Shaped;
use vellus_scene::{Light, Shaping, Texture};

/// A sampled direction toward a light.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit length.
    pub direction: Vec3,
    /// Distance to the light; infinite for domes and distant lights.
    pub distance: f32,
    /// RGB.
    pub radiance: [f32; 3],
    /// Density per solid angle, times the probability of the light. Infinite for points and lights of one direction:
    /// their `radiance` is the irradiance of a plane that faces the light, divided by that probability.
    pub pdf: f32,
}

/// The radiance that a ray finds, and the density with which [`Lights::sample`] samples its direction.
#[derive(Clone, Copy, Debug)]
pub struct Emission {
    /// Distance along the ray.
    pub t: f32,
    /// RGB.
    pub radiance: [f32; 3],
    /// Density per solid angle, times the probability of the light; 0 if the light is not sampled.
    pub pdf: f32,
}

/// All lights of a scene.
#[derive(Clone, Debug)]
pub struct Lights {
    lights: Vec<Prepared>,
    /// How the emission of each light depends on the direction.
    shapings: Vec<Option<Shaped>>,
    /// The probability of each light, and their distribution. All are 0 if no light is sampled.
    shares: Vec<f32>,
    chances: PiecewiseConstant1D,
    /// Whether the camera sees each light directly.
    visible: Vec<bool>,
}

impl Lights {
    /// Prepares lights. `unseen` are the indices of lights that the camera does not see directly, and `shaped` those of
    /// lights with a shaping. `reach` is the radius of the scene. Domes and distant lights illuminate a disk of this
    /// radius.
    pub fn new(
        lights: &[Light],
        unseen: &[usize],
        shaped: &[(usize, Shaping)],
        textures: &[Texture],
        reach: f32,
    ) -> Self {
        let lights: Vec<Prepared> = lights.iter().map(|light| prepared::prepare(light, textures)).collect();
        let mut shapings = vec![None; lights.len()];
        for (i, shaping) in shaped {
            shapings[*i] = Some(Shaped::new(shaping, lights[*i].faces()));
        }
        let power = |(light, shaping): (&Prepared, &Option<Shaped>)| {
            light.power(reach) * shaping.as_ref().map_or(1.0, |shaping| shaping.mean)
        };
        let powers: Vec<f32> = lights.iter().zip(&shapings).map(power).collect();
        let any = powers.iter().any(|&power| power > 0.0);
        let chances = PiecewiseConstant1D::new(powers.into_iter());
        let shares = (0..lights.len()).map(|i| if any { chances.width(i) } else { 0.0 }).collect();
        let visible = (0..lights.len()).map(|i| !unseen.contains(&i)).collect();
        Lights { lights, shapings, shares, chances, visible }
    }

    /// Multiplies the emission of all lights by a positive factor.
    pub fn scale(&mut self, factor: f32) {
        self.lights.iter_mut().for_each(|light| light.scale(factor));
    }

    /// All lights.
    pub(crate) fn all(&self) -> &[Prepared] {
        &self.lights
    }

    /// Number of lights.
    pub(crate) fn len(&self) -> usize {
        self.lights.len()
    }

    /// The probability of a light.
    pub(crate) fn share(&self, light: usize) -> f32 {
        self.shares[light]
    }

    /// Whether the camera sees a light.
    pub(crate) fn is_visible(&self, light: usize) -> bool {
        self.visible[light]
    }

    /// The shaping of a light.
    pub(crate) fn shaping(&self, light: usize) -> Option<&Shaped> {
        self.shapings[light].as_ref()
    }

    /// The distribution of lights.
    pub(crate) fn chances(&self) -> &PiecewiseConstant1D {
        &self.chances
    }

    /// Whether no light emits anything.
    pub fn is_black(&self) -> bool {
        self.lights.iter().all(Prepared::is_black)
    }

    /// Samples a light, and a direction from `point` toward it. Returns the light's index too. `None` if this light
    /// sends nothing to the point, or no light is sampled.
    pub fn sample(&self, point: Vec3, u: [f32; 3]) -> Option<(usize, LightSample)> {
        if self.lights.is_empty() {
            return None;
        }
        let (i, _) = self.chances.pick(u[2]);
        let share = self.shares[i];
        if share <= 0.0 {
            return None;
        }
        let mut sample = self.lights[i].sample(point, [u[0], u[1]])?;
        if let Some(shaping) = &self.shapings[i] {
            let factor = shaping.factor(-sample.direction);
            if factor <= 0.0 {
                return None;
            }
            sample.radiance = sample.radiance.map(|r| r * factor);
        }
        if sample.pdf.is_infinite() {
            return Some((i, LightSample { radiance: sample.radiance.map(|r| r / share), ..sample }));
        }
        (sample.pdf > 0.0).then_some((i, LightSample { pdf: sample.pdf * share, ..sample }))
    }

    /// The nearest light with a shape that a ray hits within its length, and its index. Camera rays pass through lights
    /// that the camera does not see.
    pub fn intersect(&self, ray: &Ray, camera: bool) -> Option<(usize, Emission)> {
        let mut best: Option<(usize, Emission)> = None;
        for (i, light) in self.lights.iter().enumerate() {
            if camera && !self.visible[i] {
                continue;
            }
            let t_max = best.map_or(ray.t_max, |(_, b)| b.t);
            if let Some(mut emission) = light.intersect(&Ray { t_max, ..*ray }) {
                if let Some(shaping) = &self.shapings[i] {
                    let factor = shaping.factor(-ray.direction);
                    emission.radiance = emission.radiance.map(|r| r * factor);
                }
                best = Some((i, Emission { pdf: emission.pdf * self.shares[i], ..emission }));
            }
        }
        best
    }

    /// The light that a ray finds if it leaves the scene: the index, radiance and density of each dome and distant
    /// light. Only camera rays see the ground of a dome. They do not see lights that are invisible to the camera.
    pub fn escaped<'a>(&'a self, ray: &'a Ray, camera: bool) -> impl Iterator<Item = (usize, Emission)> + 'a {
        self.lights.iter().zip(&self.shares).enumerate().filter_map(move |(i, (light, share))| {
            let emission = light.escaped(ray, camera).filter(|_| !camera || self.visible[i])?;
            Some((i, Emission { pdf: emission.pdf * share, ..emission }))
        })
    }
}

/// The sum of the three channels.
fn brightness(c: [f32; 3]) -> f32 {
    c[0] + c[1] + c[2]
}
