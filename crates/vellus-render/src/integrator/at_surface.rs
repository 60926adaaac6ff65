//! A path at a mesh.

use super::color::{Rgb, largest, scale, times, weight};
use super::path::{Path, shadow_t_max};
use super::sampler::Sampler;
use crate::film::Layer;
use crate::geometry::ray::{Ray, orthonormal_basis};
use crate::geometry::triangles::TriangleHit;
use glam::Vec3;

/// Adds the light that a mesh emits, and the light that reaches it. Returns the scattered ray and its density, or
/// `None` if the path ends.
pub(super) fn at_surface(
    path: &mut Path<'_>,
    sampler: &mut Sampler,
    ray: &Ray,
    hit: &TriangleHit,
    depth: u32,
) -> Option<(Ray, f32)> {
    let geometry = path.geometry;
    let (scatter, emission) = geometry.scatter(hit);
    path.add(times(path.throughput, emission), geometry.emission_group, depth);
    let (x, y) = orthonormal_basis(hit.normal);
    let local = |w: Vec3| Vec3::new(w.dot(x), w.dot(y), w.dot(hit.normal));
    let point = ray.at(hit.t);
    // Moves the origin off the plane by a few rounding errors of the largest coordinate.
    let start = point + hit.plane * (2e-5 * point.abs().max_element().max(hit.t * 0.1));
    let wo = local(-ray.direction);
    let [a, b] = [sampler.next(), sampler.next()];
    if depth == 0 {
        path.set(Layer::Normal, &hit.normal.to_array());
        if geometry.moves() {
            path.set(Layer::Motion, &geometry.motion(path.settings.size, point, hit.movement, ray.time));
        }
    }
    path.lights = 1.0;
    path.class = geometry.lights.class(geometry.mesh_thing(hit));
    if let Some((which, light)) = geometry.lights.sample(path.class, start, [a[0], a[1], a[2]]) {
        let ([mut base, mut coat], pdf) = scatter.eval_parts(wo, local(light.direction));
        if let Some([diffuse, specular]) = geometry.lights.gains(which) {
            (base, coat) = (scale(base, diffuse), scale(coat, specular));
        }
        let f: Rgb = std::array::from_fn(|c| base[c] + coat[c]);
        let shadow = Ray { origin: start, direction: light.direction, t_max: shadow_t_max(&light), ..*ray };
        if largest(f) > 0.0 && light.direction.dot(hit.plane) > 0.0 && !path.blocked(&shadow, which) {
            let given = if light.pdf.is_infinite() { 1.0 } else { 1.0 / light.pdf };
            let w = weight(light.pdf, pdf) * given;
            let light = scale(times(times(path.throughput, f), light.radiance), w);
            path.add(light, geometry.groups[which], depth + 1);
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
    if geometry.lights.any_gains() {
        let ([base, coat], _) = scatter.eval_parts(wo, wi);
        path.diffuse = std::array::from_fn(|c| if base[c] > 0.0 { base[c] / (base[c] + coat[c]) } else { 0.0 });
    }
    path.throughput = times(path.throughput, f);
    Some((Ray { origin: start, direction, t_max: f32::INFINITY, ..*ray }, pdf))
}
