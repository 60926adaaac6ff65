//! Lights: their intersection with rays, their emission, and their sampling.

pub mod background;
pub(crate) mod distribution;
pub(crate) mod environment;
mod links;
pub(crate) mod prepared;
pub mod sampling;
pub(crate) mod shaped;
#[cfg(test)]
mod tests;

use crate::geometry::ray::Ray;
use distribution::PiecewiseConstant1D;
use glam::Vec3;
use links::Links;
use prepared::Prepared;
use shaped::Shaped;
use vellus_scene::{Light, Texture};

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

/// What [`Lights::new`] needs besides lights and textures.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lighting {
    /// The names of all things, sets of strands first, if there are links.
    pub things: Vec<String>,
    /// The radius of the scene. Domes and distant lights illuminate a disk of this radius.
    pub reach: f32,
}

/// The lights that reach a class of things.
#[derive(Clone, Debug)]
pub(crate) struct Reaching {
    /// The probability of each light, and their distribution. All are 0 if no light is sampled.
    pub shares: Vec<f32>,
    pub chances: PiecewiseConstant1D,
    /// Whether a ray that such a thing scattered may find each light by hitting it. A light that lacks the shadows of
    /// some things is found by [`Lights::through`].
    pub found: Vec<bool>,
}

/// All lights of a scene.
#[derive(Clone, Debug)]
pub struct Lights {
    lights: Vec<Prepared>,
    /// How the emission of each light depends on the direction.
    shapings: Vec<Option<Shaped>>,
    /// For each class of things. All lights reach those of the first class.
    pub(crate) reaching: Vec<Reaching>,
    /// Whether the camera sees each light directly.
    visible: Vec<bool>,
    pub(crate) links: Option<Links>,
}

impl Lights {
    /// Prepares lights.
    pub(crate) fn new(all: &[Light], lighting: &Lighting, textures: &[Texture]) -> Self {
        let lights: Vec<Prepared> = all.iter().map(|light| prepared::prepare(&light.shape, textures)).collect();
        let shaped = |(light, prepared): (&Light, &Prepared)| {
            Some(Shaped::new(light.shaping.as_ref()?, prepared.faces(), textures))
        };
        let shapings: Vec<Option<Shaped>> = all.iter().zip(&lights).map(shaped).collect();
        let power = |(light, shaping): (&Prepared, &Option<Shaped>)| {
            light.power(lighting.reach) * shaping.as_ref().map_or(1.0, |shaping| shaping.mean)
        };
        let powers: Vec<f32> = lights.iter().zip(&shapings).map(power).collect();
        let is_linked = all.iter().any(|light| light.link.is_some());
        let links = is_linked.then(|| Links::new(all, &lighting.things));
        let reaching = |reached: &Vec<bool>| {
            let powers: Vec<f32> =
                powers.iter().zip(reached).map(|(p, reached)| if *reached { *p } else { 0.0 }).collect();
            let any = powers.iter().any(|&power| power > 0.0);
            let chances = PiecewiseConstant1D::new(powers.into_iter());
            let shares = (0..lights.len()).map(|i| if any { chances.width(i) } else { 0.0 }).collect();
            let casts = |i| links.as_ref().is_none_or(|links| links.casters(i).is_none());
            let found = reached.iter().enumerate().map(|(i, reached)| *reached && casts(i)).collect();
            Reaching { shares, chances, found }
        };
        let reaching = match &links {
            Some(links) => links.reaches.iter().map(reaching).collect(),
            None => vec![reaching(&vec![true; lights.len()])],
        };
        let visible = all.iter().map(|light| light.visible).collect();
        Lights { lights, shapings, reaching, visible, links }
    }

    /// The class of a thing: the same lights reach all things of a class. Sets of strands come first, then meshes.
    pub(crate) fn class(&self, thing: usize) -> usize {
        self.links.as_ref().map_or(0, |links| links.class(thing))
    }

    /// Whether each thing casts shadows in a light. `None` if all do.
    pub(crate) fn casters(&self, light: usize) -> Option<&[bool]> {
        self.links.as_ref()?.casters(light)
    }

    /// The gains of a light, for light that diffuse and specular parts scatter. `None` if they change nothing.
    pub(crate) fn gains(&self, light: usize) -> Option<[f32; 2]> {
        self.links.as_ref()?.gains(light)
    }

    /// Whether any light has gains.
    pub(crate) fn any_gains(&self) -> bool {
        self.links.as_ref().is_some_and(Links::any_gains)
    }

    /// Whether any light has a link.
    pub(crate) fn is_linked(&self) -> bool {
        self.links.is_some()
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

    /// Whether the camera sees a light.
    pub(crate) fn is_visible(&self, light: usize) -> bool {
        self.visible[light]
    }

    /// The shaping of a light.
    pub(crate) fn shaping(&self, light: usize) -> Option<&Shaped> {
        self.shapings[light].as_ref()
    }

    /// Whether no light emits anything.
    pub fn is_black(&self) -> bool {
        self.lights.iter().all(Prepared::is_black)
    }

    /// Samples a light, and a direction from `point` toward it. Returns the light's index too. `None` if this light
    /// sends nothing to the point, or no light is sampled. `class` is that of the thing at the point.
    pub fn sample(&self, class: usize, point: Vec3, u: [f32; 3]) -> Option<(usize, LightSample)> {
        if self.lights.is_empty() {
            return None;
        }
        let Reaching { shares, chances, .. } = &self.reaching[class];
        let (i, _) = chances.pick(u[2]);
        let share = shares[i];
        if share <= 0.0 {
            return None;
        }
        let mut sample = self.lights[i].sample(point, [u[0], u[1]])?;
        if let Some(shaping) = &self.shapings[i] {
            let factor = shaping.factor(-sample.direction);
            if factor == [0.0; 3] {
                return None;
            }
            sample.radiance = std::array::from_fn(|c| sample.radiance[c] * factor[c]);
        }
        if sample.pdf.is_infinite() {
            return Some((i, LightSample { radiance: sample.radiance.map(|r| r / share), ..sample }));
        }
        (sample.pdf > 0.0).then_some((i, LightSample { pdf: sample.pdf * share, ..sample }))
    }

    /// The nearest light with a shape that a ray hits within its length, and its index. `from` is the class of the
    /// thing that scattered the ray; rays find the lights that reach it. Without it, the ray comes from the camera, and
    /// passes through lights that the camera does not see.
    pub fn intersect(&self, ray: &Ray, from: Option<usize>) -> Option<(usize, Emission)> {
        self.nearest(ray, self.found(from), from.unwrap_or(0))
    }

    /// Whether a ray may find each light by hitting it.
    fn found(&self, from: Option<usize>) -> &[bool] {
        from.map_or(&self.visible, |class| &self.reaching[class].found)
    }

    /// The nearest of some lights with a shape.
    fn nearest(&self, ray: &Ray, among: &[bool], class: usize) -> Option<(usize, Emission)> {
        let mut best: Option<(usize, Emission)> = None;
        for (i, light) in self.lights.iter().enumerate() {
            if !among[i] {
                continue;
            }
            let t_max = best.map_or(ray.t_max, |(_, b)| b.t);
            if let Some(mut emission) = light.intersect(&Ray { t_max, ..*ray }) {
                if let Some(shaping) = &self.shapings[i] {
                    let factor = shaping.factor(-ray.direction);
                    emission.radiance = std::array::from_fn(|c| emission.radiance[c] * factor[c]);
                }
                best = Some((i, Emission { pdf: emission.pdf * self.reaching[class].shares[i], ..emission }));
            }
        }
        best
    }

    /// The light that a ray finds if it leaves the scene: the index, radiance and density of each dome and distant
    /// light. Only camera rays see the ground of a dome. `from` as in [`Lights::intersect`].
    pub fn escaped<'a>(&'a self, ray: &'a Ray, from: Option<usize>) -> impl Iterator<Item = (usize, Emission)> + 'a {
        self.far(ray, self.found(from), from)
    }

    /// Those of some domes and distant lights.
    fn far<'a>(
        &'a self,
        ray: &'a Ray,
        among: &'a [bool],
        from: Option<usize>,
    ) -> impl Iterator<Item = (usize, Emission)> + 'a {
        let shares = &self.reaching[from.unwrap_or(0)].shares;
        self.lights.iter().zip(shares).enumerate().filter_map(move |(i, (light, share))| {
            let emission = light.escaped(ray, from.is_none()).filter(|_| among[i])?;
            Some((i, Emission { pdf: emission.pdf * share, ..emission }))
        })
    }

    /// The lights that an infinite ray from a thing of a class finds although other things may be in front of them:
    /// those in whose light some things cast no shadow. The caller asks for the shadows of the others.
    pub fn through<'a>(&'a self, ray: &'a Ray, class: usize) -> impl Iterator<Item = (usize, Emission)> + 'a {
        self.links.iter().flat_map(move |links| {
            let reached = &links.reaches[class];
            // Lights hide those behind them.
            let nearest = self.nearest(ray, reached, class);
            let far = self.far(ray, reached, Some(class)).filter(move |_| nearest.is_none());
            nearest.into_iter().chain(far).filter(|(light, _)| links.casters(*light).is_some())
        })
    }
}

/// The sum of the three channels.
fn brightness(c: [f32; 3]) -> f32 {
    c[0] + c[1] + c[2]
}
