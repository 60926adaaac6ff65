//! The path of one sample: from the camera through fur to the lights.

use super::at_fiber::at_fiber;
use super::at_surface::at_surface;
use super::cache::{Indirect, Key, Record, channels};
use super::color::{Rgb, largest, scale, times, weight};
use super::geometry::Geometry;
use super::sampler::Sampler;
use super::settings::Settings;
use super::view::View;
use crate::film::Layer;
use crate::film::layout::Layout;
use crate::geometry::instances::Hit;
use crate::geometry::ray::Ray;
use crate::light::{Emission, LightSample};
use crate::shading::fibers::Fibers;
use std::any::TypeId;
use std::f32::consts::PI;
use vellus::{Bcsdf, Model};

/// The number of scattering events without Russian roulette.
pub(crate) const ROULETTE: u32 = 2;

/// A path survives with probability √(`SURVIVAL` × throughput).
/// Measured: `docs/notes/2026-11-rendering.md`, "Russian roulette".
pub(crate) const SURVIVAL: f32 = 2.0;

/// The result of a path, besides the values of its channels.
pub(crate) struct Seen {
    /// The strand that the camera sees, made by [`nearest`](crate::film::nearest); 0 for none.
    pub strand: u64,
    /// The thing that the camera sees: sets of strands first, then meshes. See [`Thing`](crate::Thing).
    pub thing: Option<u32>,
    /// Rays traced.
    pub rays: u64,
    /// The throughput of the path, if [`Settings::max_depth`] cut it off.
    pub cut: f32,
    /// The light that [`Settings::clamp_indirect`] removed: the sum of the three channels.
    pub removed: f32,
    /// What the radiance cache learns from the path, with [`Indirect::Recorded`].
    pub record: Option<Box<Record>>,
}

/// What the samples of a picture share, besides the scene.
#[derive(Clone, Copy)]
pub(crate) struct Shared<'w> {
    pub settings: &'w Settings,
    pub layout: &'w Layout,
    /// The camera.
    pub view: &'w View,
    pub indirect: Indirect<'w>,
}

/// Traces samples through a scene with one scattering model. The code is compiled for each model, and the choice of a
/// model costs one indirect call per sample.
pub(crate) trait Trace: Send + Sync {
    /// Traces sample `index` of a pixel. It overwrites `values`, one for each channel of the layout.
    fn trace(&self, geometry: &Geometry, shared: Shared<'_>, pixel: [usize; 2], index: u64, values: &mut [f32])
    -> Seen;

    /// Whether the model is [`Bcsdf`].
    fn is_bcsdf(&self) -> bool;

    /// The same model for changed looks and strands.
    fn rebuilt(&self, geometry: &Geometry) -> Result<Box<dyn Trace>, vellus_scene::Error>;
}

impl<M: Model + Send + 'static> Trace for Fibers<M> {
    fn trace(
        &self,
        geometry: &Geometry,
        shared: Shared<'_>,
        pixel: [usize; 2],
        index: u64,
        values: &mut [f32],
    ) -> Seen {
        trace(geometry, self, shared, pixel, index, values)
    }

    fn is_bcsdf(&self) -> bool {
        TypeId::of::<M>() == TypeId::of::<Bcsdf<'static>>()
    }

    fn rebuilt(&self, geometry: &Geometry) -> Result<Box<dyn Trace>, vellus_scene::Error> {
        Ok(Box::new(Fibers::rebuilt(self, geometry)?))
    }
}

/// A path while it is traced.
pub(super) struct Path<'w> {
    pub(super) geometry: &'w Geometry,
    pub(super) settings: &'w Settings,
    pub(super) layout: &'w Layout,
    pub(super) view: &'w View,
    /// The values of the layout's channels.
    pub(super) values: &'w mut [f32],
    pub(super) strand: u64,
    pub(super) throughput: Rgb,
    /// The share of each lobe in the light that comes from the fibre seen by the camera.
    pub(super) lobes: Option<[Rgb; 6]>,
    /// The angle over which the last scattering event spread the path, in radians. `None` for camera rays.
    pub(super) spread: Option<f32>,
    /// The class of the thing of the last scattering event: see [`Lights::class`](crate::light::Lights::class).
    pub(super) class: usize,
    /// The share of diffuse parts in the last scattering event, if any light has gains.
    pub(super) diffuse: Rgb,
    /// The number of light samples at the last scattering event.
    pub(super) lights: f32,
    pub(super) rays: u64,
    /// The light that [`Settings::clamp_indirect`] removed: the sum of the three channels.
    pub(super) removed: f32,
}

impl Path<'_> {
    /// Adds light from a light group. It reached the camera after `events` scattering events.
    pub(super) fn add(&mut self, light: Rgb, group: usize, events: u32) {
        let light = self.clamp(light, events);
        for c in 0..3 {
            self.values[c] += light[c];
        }
        if let Some(start) = self.layout.start(Layer::Lights) {
            (0..3).for_each(|c| self.values[start + 3 * group + c] += light[c]);
        }
        if let (Some(lobes), Some(start)) = (&self.lobes, self.layout.start(Layer::Lobes)) {
            for (p, lobe) in lobes.iter().enumerate() {
                (0..3).for_each(|c| self.values[start + 3 * p + c] += light[c] * lobe[c]);
            }
        }
    }

    /// Adds the radiance of each group that something sends along the path, or the whole radiance if the film has no
    /// groups.
    fn add_groups(&mut self, radiance: &[f32], events: u32) {
        for (group, radiance) in radiance.chunks_exact(3).enumerate() {
            self.add(times(self.throughput, [radiance[0], radiance[1], radiance[2]]), group, events);
        }
    }

    /// Limits indirect light to [`Settings::clamp_indirect`].
    fn clamp(&mut self, light: Rgb, events: u32) -> Rgb {
        match self.settings.clamp_indirect {
            Some(limit) if events > 1 && largest(light) > limit => {
                let clamped = scale(light, limit / largest(light));
                self.removed += light.iter().sum::<f32>() - clamped.iter().sum::<f32>();
                clamped
            }
            _ => light,
        }
    }

    /// Sets a layer, if the film keeps it.
    pub(super) fn set(&mut self, layer: Layer, value: &[f32]) {
        if let Some(start) = self.layout.start(layer) {
            self.values[start..][..value.len()].copy_from_slice(value);
        }
    }

    /// Whether anything blocks a shadow ray to a light.
    pub(super) fn blocked(&mut self, ray: &Ray, light: usize) -> bool {
        self.rays += 1;
        self.geometry.shadows(ray, light)
    }

    /// Adds the light that the last scattered ray finds behind things that cast no shadow in it.
    fn find_through(&mut self, ray: &Ray, pdf: f32, events: u32) {
        let geometry = self.geometry;
        for (light, emission) in geometry.lights.through(ray, self.class) {
            if !self.blocked(&Ray { t_max: emission.t * BEFORE, ..*ray }, light) {
                self.found((light, emission), Some(pdf), events);
            }
        }
    }

    /// Adds the light of an emitter that a ray hit after `events` scattering events. `pdf` is the density with which
    /// the ray was sampled. `None` for camera rays.
    fn found(&mut self, (light, emission): (usize, Emission), pdf: Option<f32>, events: u32) {
        let w = pdf.map_or(1.0, |pdf| weight(pdf, emission.pdf * self.lights));
        let mut radiance = emission.radiance;
        if let (Some([diffuse, specular]), Some(_)) = (self.geometry.lights.gains(light), pdf) {
            radiance = std::array::from_fn(|c| radiance[c] * (specular + (diffuse - specular) * self.diffuse[c]));
        }
        self.add(scale(times(self.throughput, radiance), w), self.geometry.groups[light], events);
    }
}

/// The length of a shadow ray relative to the distance of the light: it ends a little before the light.
pub(crate) const BEFORE: f32 = 0.9999;

/// The length of a shadow ray.
pub(crate) fn shadow_t_max(sample: &LightSample) -> f32 {
    sample.distance * BEFORE
}

/// Traces a sample: see [`Trace::trace`].
pub(crate) fn trace<M: Model>(
    geometry: &Geometry,
    fibers: &Fibers<M>,
    shared: Shared<'_>,
    pixel: [usize; 2],
    index: u64,
    values: &mut [f32],
) -> Seen {
    let Shared { settings, layout, view, indirect } = shared;
    values.fill(0.0);
    let (mut sampler, u, mut ray) = camera_ray(geometry, view, settings, pixel, index);
    let mut path = Path {
        geometry,
        settings,
        layout,
        view,
        values,
        strand: 0,
        throughput: [1.0; 3],
        lobes: None,
        spread: None,
        class: 0,
        diffuse: [0.0; 3],
        lights: 1.0,
        rays: 0,
        removed: 0.0,
    };
    // Density of the last scattered direction, for multiple importance sampling. `None` for camera rays.
    let mut pdf = None;
    let mut cut = 0.0;
    let mut thing = None;
    let mut record = None;
    // Whether the camera sees a strand.
    let mut strands_first = false;
    for depth in 0.. {
        path.rays += 1;
        let hit = geometry.intersect(&ray);
        let t = hit.as_ref().map(Hit::t);
        let open = Ray { t_max: t.unwrap_or(f32::INFINITY), ..ray };
        let from = (depth > 0).then_some(path.class);
        if let (true, Some(pdf)) = (geometry.lights.is_linked(), pdf) {
            path.find_through(&ray, pdf, depth);
        }
        if let Some(emission) = geometry.lights.intersect(&open, from) {
            path.found(emission, pdf, depth);
            break;
        }
        let Some((hit, t)) = hit.zip(t) else {
            if let (0, Some(background)) = (depth, &geometry.background) {
                let uv = view.place(settings.size, pixel, settings.filter, u);
                path.add(background.at(&geometry.textures, settings.size, uv), background.group, depth);
                break;
            }
            for emission in geometry.lights.escaped(&ray, from) {
                path.found(emission, pdf, depth);
            }
            break;
        };
        if depth == 0 {
            path.set(Layer::Alpha, &[1.0]);
            path.set(Layer::Depth, &[t]);
            thing = Some(geometry.thing(&hit) as u32);
            strands_first = matches!(hit, Hit::Curve(_));
        }
        let left = settings.max_depth.is_none_or(|max| depth < max);
        if !left {
            cut = largest(path.throughput);
            break;
        }
        if depth == 1
            && let Some(grid) = indirect.grid()
            && (strands_first || path.spread.is_some_and(|spread| grid.is_finer(ray.at(t), spread * t)))
        {
            let key = Key { point: ray.at(t), direction: ray.direction, thing: geometry.alike(&hit) };
            match indirect {
                Indirect::Traced => {}
                Indirect::Recorded(_) => {
                    let before = &path.values[channels(layout)];
                    record = Some(Box::new(Record::begin(key, path.throughput, before)));
                }
                Indirect::Cached(cache) => {
                    let [x, y, z, _] = sampler.next();
                    if let Some((radiance, error)) = cache.radiance(&key, [x, y, z]) {
                        path.add_groups(radiance, depth + 1);
                        path.set(Layer::CacheError, &[times(path.throughput, error).iter().sum::<f32>() / 3.0]);
                        break;
                    }
                }
            }
        }
        let next = match hit {
            Hit::Curve(hit) => at_fiber(&mut path, fibers, &mut sampler, &ray, &hit, depth),
            Hit::Triangle(hit) => at_surface(&mut path, &mut sampler, &ray, &hit, depth),
        };
        let Some((onward, density)) = next else { break };
        (ray, pdf) = (onward, Some(density));
        path.spread = Some(spread(density));
        if depth >= ROULETTE {
            let survive = (SURVIVAL * largest(path.throughput)).sqrt().min(1.0);
            if sampler.next()[0] >= survive {
                break;
            }
            path.throughput = scale(path.throughput, 1.0 / survive);
        }
    }
    if let Some(record) = &mut record {
        record.end(&path.values[channels(layout)]);
    }
    Seen { strand: path.strand, thing, rays: path.rays, cut, removed: path.removed, record }
}

/// The camera ray of a sample, with the numbers that chose its place in the pixel and on the lens. The random numbers
/// of the path follow.
pub(crate) fn camera_ray(
    geometry: &Geometry,
    view: &View,
    settings: &Settings,
    pixel: [usize; 2],
    index: u64,
) -> (Sampler, [f32; 4], Ray) {
    let mut sampler = Sampler::new(pixel.map(|x| x as u32), index, settings.seed);
    let u = sampler.next();
    let draws = geometry.things_move || view.moves() || geometry.is_simplified;
    let [time, detail, ..] = if draws { sampler.next() } else { [0.0; 4] };
    (sampler, u, Ray { detail, ..view.ray(settings.size, pixel, settings.filter, u, time) })
}

/// The angle over which a direction with this density per solid angle spreads: the width of a box with the same
/// variance as a uniform cone of this density.
fn spread(pdf: f32) -> f32 {
    (3.0 / (PI * pdf)).sqrt()
}
