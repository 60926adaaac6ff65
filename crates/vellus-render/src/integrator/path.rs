//! The path of one sample: from the camera through fur to lights.
//!
//! Light reaches a fibre from the whole sphere, so that no direction is excluded in sampling the lights. What is inside the fibre is
//! inside its BCSDF: a path enters the surface where the ray does, and leaves from the side it goes to.

use crate::film::layout::Layout;
use crate::film::{Layer, nearest};
use crate::geometry::curves::CurveHit;
use crate::geometry::ray::{Ray, across};
use crate::geometry::triangles::TriangleHit;
use crate::integrator::sampler::Sampler;
use crate::integrator::view::Filter;
use crate::light::{Emission, LightSample};
use crate::shading::fibers::Fibers;
use crate::world::World;
use glam::{Vec3, Vec4Swizzles};
use std::f32::consts::PI;
use vellus::{FiberFrame, Field, Lobes, Model, Scattering, Window};

/// Which offsets a hit stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Those the pixel sees where the camera sees a fibre; deeper, all where the path was spread over the whole width, else where it is
    /// hit.
    MultiScale,
    /// Where it is hit.
    Near,
    /// The whole width, always.
    Far,
}

/// How paths are traced.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Pixels a row, and rows, of the whole picture.
    pub size: [usize; 2],
    /// The part of it that is rendered: left column, top row, width, height. `None` is all of it.
    pub crop: Option<[usize; 4]>,
    /// Near, far or between.
    pub mode: Mode,
    /// What a pixel's samples see.
    pub filter: Filter,
    /// Another seed is another noise.
    pub seed: u32,
    /// Scattering events after which a path is cut; `None` lets Russian roulette alone end it.
    pub max_depth: Option<u32>,
}

impl Settings {
    /// Left column, top row, width and height of what is rendered.
    pub fn area(&self) -> [usize; 4] {
        self.crop.unwrap_or([0, 0, self.size[0], self.size[1]])
    }
}

/// What a sample saw.
pub(crate) struct Seen {
    /// The strand, as [`nearest`] has it.
    pub strand: u64,
    /// Rays traced.
    pub rays: u64,
    /// Mean throughput lost to the largest depth.
    pub cut: f32,
}

/// A light sample that is scattered, weighted, at least this share of what a fibre would that scattered evenly in all directions is
/// always asked for; fainter ones in proportion. The first number is for fibres the camera sees, the other for those deeper in the fur,
/// from which less arrives. Most miss all sharp lobes: a picture takes a quarter less time (200,000 strands, sky and one lamp), and has about
/// a hundredth more of the noise's mean square (raccoon, cat, hamster). To ask as much deeper as before the camera takes 1 to 3 % more time with
/// animals and 7 to 12 % with those strands, for 1 % less of the mean square.
const ASKED: [f32; 2] = [0.25, 1.0];

/// Light samples where the camera sees a fibre: a second one takes 23 % of the noise's mean square away from a lock of hair, for 2 to 8 %
/// of the time. Of animals, deeper in fur, it is worth what it costs.
const FIRST_LIGHTS: u32 = 2;

/// Scattering events before Russian roulette begins.
const ROULETTE: u32 = 2;

/// A path survives with the square root of this times its throughput. Faint paths make more noise than they bring light: under a
/// lamp, 3 % of the light of 200,000 strands comes from the third scattering on, and 70 % of the noise's mean square. The same
/// noise takes 8 to 20 % less time (cat, raccoon, hamster, those strands) than with the throughput itself from the fifth on.
const SURVIVAL: f32 = 2.0;

/// Paths fainter than that see fibres where they hit them: they make too little of the noise for a far field, which costs three times
/// as much. A frame takes 4 to 15 % less time (cat, raccoon), with 2 to 5 % more of the noise's mean square.
const FAINT: f32 = 0.3;

type Rgb = [f32; 3];

fn times(a: Rgb, b: Rgb) -> Rgb {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}

fn scale(a: Rgb, s: f32) -> Rgb {
    a.map(|x| x * s)
}

fn largest(a: Rgb) -> f32 {
    a[0].max(a[1]).max(a[2])
}

/// The weight of a sample among two techniques: power heuristic (Veach 1997).
fn weight(own: f32, other: f32) -> f32 {
    if own.is_infinite() {
        return 1.0;
    }
    let (a, b) = (own * own, other * other);
    if a + b > 0.0 { a / (a + b) } else { 0.0 }
}

/// The frame of a fibre at a hit.
fn frame_at(hit: &CurveHit) -> FiberFrame {
    let point = hit.segment.at(hit.entry.u);
    FiberFrame::new(hit.segment.tangent(hit.entry.u), point.xyz(), point.w)
}

/// A ray that leaves toward `direction`, from the side of the fibre that faces it.
fn leave(frame: &FiberFrame, direction: Vec3, limit: f32, time: f32) -> Ray {
    Ray { origin: frame.center() + frame.outward(direction) * (1.001 * frame.radius()), direction, limit, time }
}

/// One sample being traced.
struct Path<'w> {
    world: &'w World,
    settings: &'w Settings,
    layout: &'w Layout,
    /// Of the layout's channels.
    values: &'w mut [f32],
    strand: u64,
    throughput: Rgb,
    /// Of the light that comes through the fibre seen first, the share that each lobe scattered.
    lobes: Option<[Rgb; 6]>,
    /// Angle over which the last scattering spread the path, radians; none for the camera's ray.
    spread: Option<f32>,
    /// Light samples that were taken there.
    lights: f32,
    rays: u64,
}

impl Path<'_> {
    /// Adds light that came from a group of lights.
    fn add(&mut self, light: Rgb, group: usize) {
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

    /// Sets a layer, if it is kept.
    fn set(&mut self, layer: Layer, value: &[f32]) {
        if let Some(start) = self.layout.start(layer) {
            self.values[start..][..value.len()].copy_from_slice(value);
        }
    }

    /// What lies on the way toward a light?
    fn blocked(&mut self, ray: &Ray) -> bool {
        self.rays += 1;
        self.world.curves.occluded(ray) || self.world.triangles.occluded(ray)
    }

    /// Light from beyond the scene, or from a light's shape, found by a ray that was drawn with density `pdf`.
    fn found(&mut self, (light, emission): (usize, Emission), pdf: Option<f32>) {
        let w = pdf.map_or(1.0, |pdf| weight(pdf, emission.pdf * self.lights));
        self.add(scale(times(self.throughput, emission.radiance), w), self.world.groups[light]);
    }
}

/// Distance up to which a shadow ray is asked: a little before the light itself.
fn shadow_limit(sample: &LightSample) -> f32 {
    sample.distance * 0.9999
}

impl World {
    /// As [`Trace::trace`](crate::shading::fibers::Trace::trace) says.
    pub(crate) fn trace<M: Model>(
        &self,
        fibers: &Fibers<M>,
        settings: &Settings,
        layout: &Layout,
        pixel: [usize; 2],
        index: u64,
        values: &mut [f32],
    ) -> Seen {
        values.fill(0.0);
        let mut sampler = Sampler::new(pixel.map(|x| x as u32), index, settings.seed);
        let u = sampler.next();
        let time = if self.moves { sampler.next()[0] } else { 0.0 };
        let mut ray = self.view.ray(settings.size, pixel, settings.filter, u, time);
        let mut path = Path {
            world: self,
            settings,
            layout,
            values,
            strand: 0,
            throughput: [1.0; 3],
            lobes: None,
            spread: None,
            lights: 1.0,
            rays: 0,
        };
        // The density the ray was drawn with, if lights could have been sampled instead.
        let mut pdf = None;
        let mut cut = 0.0;
        for depth in 0.. {
            path.rays += 1;
            let triangle = self.triangles.intersect(&ray);
            let curve = self.curves.intersect(&Ray { limit: triangle.map_or(ray.limit, |hit| hit.t), ..ray });
            let t = curve.map(|hit| hit.entry.t).or(triangle.map(|hit| hit.t));
            if let Some(emission) = self.lights.met(&Ray { limit: t.unwrap_or(f32::INFINITY), ..ray }) {
                path.found(emission, pdf);
                break;
            }
            let Some(t) = t else {
                for emission in self.lights.beyond(&ray, depth == 0) {
                    path.found(emission, pdf);
                }
                break;
            };
            if depth == 0 {
                path.set(Layer::Alpha, &[1.0]);
                path.set(Layer::Depth, &[t]);
            }
            let left = settings.max_depth.is_none_or(|max| depth < max);
            if !left {
                cut = largest(path.throughput);
                break;
            }
            let next = match (curve, triangle) {
                (Some(hit), _) => self.at_fiber(fibers, &mut path, &mut sampler, &ray, &hit, depth),
                (None, Some(hit)) => self.at_surface(&mut path, &mut sampler, &ray, &hit, depth),
                (None, None) => None,
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
        Seen { strand: path.strand, rays: path.rays, cut }
    }

    fn at_fiber<M: Model>(
        &self,
        fibers: &Fibers<M>,
        path: &mut Path,
        sampler: &mut Sampler,
        ray: &Ray,
        hit: &CurveHit,
        depth: u32,
    ) -> Option<(Ray, f32)> {
        let frame = frame_at(hit);
        let h = frame.offset(ray.at(hit.entry.t), -ray.direction);
        let wo = frame.to_local(-ray.direction);
        let window = match path.settings.mode {
            Mode::Near => Window::near(h),
            Mode::Far => Window::far(),
            Mode::MultiScale => match path.spread {
                None => {
                    let pixel = self.view.pixel_width(path.settings.size, ray, hit.entry.t);
                    // Hits are spread over the pixel already: half of it more keeps the picture as sharp as its filter.
                    Window::cell(h, 0.5 * frame.pixel_width(pixel), sampler.chance())
                }
                // D15: the far field where the last scattering spread the path over all of the fibre's width.
                Some(angle) if angle * hit.entry.t >= 2.0 * frame.radius() && largest(path.throughput) >= FAINT => {
                    Window::far()
                }
                Some(_) => Window::near(h),
            },
        };
        let mut made = None;
        let model = fibers.at(self, hit, &mut made);
        let window = match model.field() {
            Field::Near => Window::near(h),
            Field::Far => Window::far(),
            Field::Any => window,
        };
        if depth == 0 {
            path.set(Layer::Tangent, &frame.tangent().to_array());
            let n = (ray.at(hit.entry.t) - frame.center()).normalize_or_zero();
            path.set(Layer::Normal, &n.to_array());
            path.set(Layer::Fibers, &[1.0]);
            path.set(Layer::RootUv, &self.root_uv(hit).to_array());
            if self.moves {
                path.set(
                    Layer::Motion,
                    &self.motion(path.settings, frame.center(), self.curves.movement(hit), ray.time),
                );
            }
            path.strand = nearest(hit.entry.t, self.strand_number(hit));
        }
        model.with_hit(wo, window, |scattering| self.scatter_at(path, sampler, (&frame, ray.time), scattering, depth))
    }

    /// Samples a light and a direction at a fibre.
    fn scatter_at(
        &self,
        path: &mut Path,
        sampler: &mut Sampler,
        (frame, time): (&FiberFrame, f32),
        scattering: &impl Scattering,
        depth: u32,
    ) -> Option<(Ray, f32)> {
        if depth == 0 && path.layout.has(Layer::Albedo) {
            path.set(Layer::Albedo, &scattering.energy().total());
        }
        let apart = depth == 0 && path.layout.has(Layer::Lobes);
        let [a, b] = [sampler.next(), sampler.next()];
        let lights = if depth == 0 { FIRST_LIGHTS } else { 1 };
        path.lights = lights as f32;
        for k in 0..lights {
            let u = if k == 0 { a } else { sampler.next() };
            // Each in its own share of the lights.
            let pick = (u[0] + k as f32) / path.lights;
            let Some((which, light)) = self.lights.sample(frame.center(), [pick, u[1], u[2]]) else { continue };
            let (f, pdf) = scattering.eval_pdf(frame.to_local(light.direction));
            let total = f.total();
            let w = weight(light.pdf * path.lights, pdf) / path.lights;
            let asked = (4.0 * PI / ASKED[usize::from(depth > 0)] * path.lights * largest(total) * w).min(1.0);
            if sampler.chance() < asked && !path.blocked(&leave(frame, light.direction, shadow_limit(&light), time)) {
                let given = if light.pdf.is_infinite() { 1.0 } else { 1.0 / light.pdf };
                let w = w * given / asked;
                let lobes = path.lobes;
                if apart {
                    path.lobes = Some(shares(&f));
                }
                path.add(scale(times(times(path.throughput, total), light.radiance), w), self.groups[which]);
                path.lobes = lobes;
            }
        }
        let sample = scattering.sample([b[0], b[1], b[2], b[3], a[3]]);
        let sample = sample.filter(|sample| largest(sample.weight) > 0.0)?;
        if apart {
            path.lobes = Some(shares(&scattering.eval(sample.wi)));
        }
        path.throughput = times(path.throughput, sample.weight);
        Some((leave(frame, frame.to_world(sample.wi), f32::INFINITY, time), sample.pdf))
    }

    /// How many pixels a point moves right and up while the shutter is open; `movement` is its own way in that time.
    fn motion(&self, settings: &Settings, now: Vec3, movement: Vec3, time: f32) -> [f32; 2] {
        let open = self.view.seen(settings.size, now - movement * time, 0.0);
        let closed = self.view.seen(settings.size, now + movement * (1.0 - time), 1.0);
        open.zip(closed).map_or([0.0; 2], |(open, closed)| [closed.x - open.x, open.y - closed.y])
    }

    fn at_surface(
        &self,
        path: &mut Path,
        sampler: &mut Sampler,
        ray: &Ray,
        hit: &TriangleHit,
        depth: u32,
    ) -> Option<(Ray, f32)> {
        let (scatter, emission) = self.scatter(hit);
        path.add(times(path.throughput, emission), self.glow);
        let (x, y) = across(hit.normal);
        let local = |w: Vec3| Vec3::new(w.dot(x), w.dot(y), w.dot(hit.normal));
        let point = ray.at(hit.t);
        // A few roundings of the largest coordinate off the plane.
        let start = point + hit.plane * (2e-5 * point.abs().max_element().max(hit.t * 0.1));
        let wo = local(-ray.direction);
        let [a, b] = [sampler.next(), sampler.next()];
        if depth == 0 {
            path.set(Layer::Normal, &hit.normal.to_array());
            if self.moves {
                path.set(Layer::Motion, &self.motion(path.settings, point, hit.movement, ray.time));
            }
        }
        path.lights = 1.0;
        if let Some((which, light)) = self.lights.sample(start, [a[0], a[1], a[2]]) {
            let (f, pdf) = scatter.eval_pdf(wo, local(light.direction));
            let shadow = Ray { origin: start, direction: light.direction, limit: shadow_limit(&light), time: ray.time };
            if largest(f) > 0.0 && light.direction.dot(hit.plane) > 0.0 && !path.blocked(&shadow) {
                let given = if light.pdf.is_infinite() { 1.0 } else { 1.0 / light.pdf };
                let w = weight(light.pdf, pdf) * given;
                path.add(scale(times(times(path.throughput, f), light.radiance), w), self.groups[which]);
            }
        }
        let (wi, pdf, f) = scatter.sample(wo, [b[0], b[1], b[2]])?;
        let direction = x * wi.x + y * wi.y + hit.normal * wi.z;
        if depth == 0 {
            path.set(Layer::Albedo, &f.map(|f| f.min(1.0)));
        }
        if direction.dot(hit.plane) <= 0.0 {
            return None;
        }
        path.throughput = times(path.throughput, f);
        Some((Ray { time: ray.time, ..Ray::new(start, direction) }, pdf))
    }
}

/// The angle over which a direction was spread that was drawn with a density per solid angle: the width of a box with the variance of the
/// cone that it would fill evenly.
fn spread(pdf: f32) -> f32 {
    (3.0 / (PI * pdf)).sqrt()
}

/// Each lobe's share of the total.
fn shares(lobes: &Lobes) -> [Rgb; 6] {
    let total = lobes.total();
    lobes.0.map(|lobe| std::array::from_fn(|c| if total[c] > 0.0 { lobe[c] / total[c] } else { 0.0 }))
}
