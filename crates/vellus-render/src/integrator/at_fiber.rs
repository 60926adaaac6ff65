//! A path at a fibre.
//!
//! Light reaches a fibre from the whole sphere, so light sampling excludes no direction. The BCSDF includes the paths
//! inside the fibre. A path enters where the ray hits the fibre, and leaves from the side that faces its new direction.

use super::color::{Rgb, largest, scale, times, weight};
use super::path::{Path, shadow_t_max};
use super::sampler::Sampler;
use super::window::window_for;
use crate::film::{Layer, nearest};
use crate::geometry::curves::CurveHit;
use crate::geometry::ray::Ray;
use crate::shading::fibers::Fibers;
use glam::Vec3;
use std::f32::consts::PI;
use vellus::{FiberFrame, Lobe, Lobes, Model, Scattering, Window, WindowSupport};

/// A shadow ray is always traced if its contribution is at least this fraction of the contribution of an isotropic
/// fibre. Fainter shadow rays are traced with proportional probability. The first number is for fibres that the camera
/// sees, the second for all others. Measured: `docs/notes/2026-11-rendering.md`, "Shadow rays".
pub(crate) const SHADOW_RAY_THRESHOLD: [f32; 2] = [0.25, 1.0];

/// The number of light samples at a fibre that the camera sees. All other hits use one. Measured:
/// `docs/notes/2026-11-rendering.md`, "Light samples".
pub(crate) const FIRST_LIGHTS: u32 = 2;

/// Rays leave a fibre from this many radii beside its axis, so that they do not hit it again.
pub(crate) const BESIDE: f32 = 1.001;

/// The lobes to which the gain of a light for diffuse parts applies: light that the medulla scattered.
const DIFFUSE: [Lobe; 2] = [Lobe::Tts, Lobe::Trts];

/// A fibre's frame at a hit, and the time and the level of detail of the ray.
struct Place {
    frame: FiberFrame,
    time: f32,
    detail: f32,
}

impl Place {
    fn new(hit: &CurveHit, ray: &Ray) -> Self {
        Place { frame: hit.frame(), time: ray.time, detail: ray.detail }
    }

    /// A ray that leaves toward `direction`, from the side of the fibre that faces it.
    fn leave(&self, direction: Vec3, t_max: f32) -> Ray {
        let origin = self.frame.beside(direction, BESIDE);
        Ray { origin, direction, t_max, time: self.time, detail: self.detail }
    }
}

/// Adds the light that reaches a fibre. Returns the scattered ray and its density, or `None` if the path ends.
pub(super) fn at_fiber<M: Model>(
    path: &mut Path<'_>,
    fibers: &Fibers<M>,
    sampler: &mut Sampler,
    ray: &Ray,
    hit: &CurveHit,
    depth: u32,
) -> Option<(Ray, f32)> {
    let geometry = path.geometry;
    let place = Place::new(hit, ray);
    let frame = &place.frame;
    let h = frame.offset(ray.at(hit.entry.t), -ray.direction);
    let wo = frame.to_local(-ray.direction);
    let half = frame.half_width(-ray.direction);
    let width = 2.0 * half;
    let window = window_for(
        path.settings.mode,
        h,
        path.spread.map(|angle| (angle * hit.entry.t >= width, largest(path.throughput))),
        || (path.view.pixel_width(path.settings.size, ray, hit.entry.t) / half.max(1e-30)).min(4.0),
        || sampler.chance(),
    );
    let mut made = None;
    let model = fibers.at(geometry, hit, &mut made);
    let window = match model.field() {
        WindowSupport::Near => Window::near(h),
        WindowSupport::Far => Window::far(),
        WindowSupport::Any => window,
    };
    if depth == 0 {
        path.set(Layer::Tangent, &frame.tangent().to_array());
        let n = (ray.at(hit.entry.t) - frame.center()).normalize_or_zero();
        path.set(Layer::Normal, &n.to_array());
        path.set(Layer::Fibers, &[1.0]);
        path.set(Layer::RootUv, &geometry.root_uv(hit).to_array());
        if geometry.moves() {
            path.set(
                Layer::Motion,
                &geometry.motion(path.settings.size, frame.center(), geometry.movement(hit), ray.time),
            );
        }
        path.strand = nearest(hit.entry.t, geometry.strand_number(hit));
    }
    path.class = geometry.lights.class(hit.set);
    model.with_hit(wo, window, |scattering| scatter_at(path, sampler, &place, scattering, depth))
}

/// Samples a light and a direction at a fibre.
fn scatter_at(
    path: &mut Path<'_>,
    sampler: &mut Sampler,
    place: &Place,
    scattering: &impl Scattering,
    depth: u32,
) -> Option<(Ray, f32)> {
    let (geometry, frame) = (path.geometry, &place.frame);
    if depth == 0 && path.layout.has(Layer::Albedo) {
        path.set(Layer::Albedo, &scattering.energy().total());
    }
    let apart = depth == 0 && path.layout.has(Layer::Lobes);
    let [a, b] = [sampler.next(), sampler.next()];
    let lights = if depth == 0 { FIRST_LIGHTS } else { 1 };
    path.lights = lights as f32;
    for k in 0..lights {
        let u = if k == 0 { a } else { sampler.next() };
        // Stratified sampling: each sample has its own interval of the distribution of lights.
        let pick = (u[0] + k as f32) / path.lights;
        let found = geometry.lights.sample(path.class, frame.center(), [pick, u[1], u[2]]);
        let Some((which, light)) = found else { continue };
        let (mut f, pdf) = scattering.eval_pdf(frame.to_local(light.direction));
        if let Some([diffuse, specular]) = geometry.lights.gains(which) {
            for lobe in Lobe::ALL {
                f[lobe] = scale(f[lobe], if DIFFUSE.contains(&lobe) { diffuse } else { specular });
            }
        }
        let total = f.total();
        let w = weight(light.pdf * path.lights, pdf) / path.lights;
        let asked =
            (4.0 * PI / SHADOW_RAY_THRESHOLD[usize::from(depth > 0)] * path.lights * largest(total) * w).min(1.0);
        if sampler.chance() < asked && !path.blocked(&place.leave(light.direction, shadow_t_max(&light)), which) {
            let given = if light.pdf.is_infinite() { 1.0 } else { 1.0 / light.pdf };
            let w = w * given / asked;
            let lobes = path.lobes;
            if apart {
                path.lobes = Some(shares(&f));
            }
            let light = scale(times(times(path.throughput, total), light.radiance), w);
            path.add(light, geometry.groups[which], depth + 1);
            path.lobes = lobes;
        }
    }
    let sample = scattering.sample([b[0], b[1], b[2], b[3], a[3]]);
    let sample = sample.filter(|sample| largest(sample.weight) > 0.0)?;
    if apart {
        path.lobes = Some(shares(&scattering.eval(sample.wi)));
    }
    if geometry.lights.any_gains() {
        let f = scattering.eval(sample.wi);
        let total = f.total();
        let diffuse: Rgb = std::array::from_fn(|c| DIFFUSE.iter().map(|&lobe| f[lobe][c]).sum());
        path.diffuse = std::array::from_fn(|c| if total[c] > 0.0 { diffuse[c] / total[c] } else { 0.0 });
    }
    path.throughput = times(path.throughput, sample.weight);
    Some((place.leave(frame.to_world(sample.wi), f32::INFINITY), sample.pdf))
}

/// The share of each lobe in the total.
fn shares(lobes: &Lobes) -> [Rgb; 6] {
    let total = lobes.total();
    lobes.0.map(|lobe| std::array::from_fn(|c| if total[c] > 0.0 { lobe[c] / total[c] } else { 0.0 }))
}
