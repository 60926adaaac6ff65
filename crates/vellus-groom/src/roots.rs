//! Where strands grow: evenly over a mesh, in proportion to a density.

use crate::error::Error;
use glam::{Vec2, Vec3};
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;
use vellus_scene::Mesh;

/// A place on a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Site {
    /// Where it is.
    pub position: Vec3,
    /// The unit shading normal there.
    pub normal: Vec3,
    /// The texture coordinates there, or 0 if the mesh has none.
    pub uv: Vec2,
}

/// Where on a triangle the density is looked at to find its mean: corners and middle.
const PROBES: [(f32, f32); 4] = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0 / 3.0, 1.0 / 3.0)];

/// A mesh with its triangles in an order in which neighbours follow each other, and the strands that each is due.
pub(crate) struct Roots<'a> {
    mesh: &'a Mesh,
    density: &'a (dyn Fn(&Site) -> f32 + Sync),
    order: Vec<u32>,
    /// Running sum of area times density, and the largest density found on each triangle.
    sums: Vec<f64>,
    peaks: Vec<f32>,
}

impl<'a> Roots<'a> {
    pub fn new(mesh: &'a Mesh, density: &'a (dyn Fn(&Site) -> f32 + Sync)) -> Result<Self, Error> {
        mesh.validate()?;
        let center = |t: usize| mesh.triangles[t].iter().map(|&v| mesh.positions[v as usize]).sum::<Vec3>() / 3.0;
        let all = 0..mesh.triangles.len();
        let bounds = |(low, high): (Vec3, Vec3), p: Vec3| (low.min(p), high.max(p));
        let (low, high) = all.clone().map(center).fold((Vec3::INFINITY, Vec3::NEG_INFINITY), bounds);
        let scale = 1023.0 / (high - low).max_element().max(f32::MIN_POSITIVE);
        let mut order: Vec<u32> = all.map(|t| t as u32).collect();
        order.sort_by_cached_key(|&t| (morton((center(t as usize) - low) * scale), t));

        let mut roots = Roots { mesh, density, order, sums: Vec::new(), peaks: Vec::new() };
        let mut sum = 0.0;
        for i in 0..roots.order.len() {
            let [a, b, c] = mesh.triangles[roots.order[i] as usize].map(|v| mesh.positions[v as usize]);
            let area = 0.5 * (b - a).cross(c - a).length();
            let [mut mean, mut peak] = [0.0, 0.0f32];
            for (u, v) in PROBES {
                let density = roots.density(&roots.site(i, u, v));
                mean += 0.25 * density;
                peak = peak.max(density);
            }
            sum += f64::from(area * mean);
            roots.sums.push(sum);
            roots.peaks.push(peak);
        }
        if sum > 0.0 && sum.is_finite() { Ok(roots) } else { Err(Error::Nowhere(mesh.name.clone())) }
    }

    /// Mean area of a strand where the density is 1.
    pub fn area_per_strand(&self, count: usize) -> f32 {
        (self.sums.last().unwrap_or(&0.0) / count.max(1) as f64) as f32
    }

    /// Root `i` of `count`. Each has its own stretch of the running sum, a compact patch of the surface; within a
    /// triangle they follow the R₂ sequence, both of which keep them apart.
    pub fn root(&self, i: usize, count: usize, rng: &mut Xoshiro256PlusPlus) -> Site {
        let total = self.sums.last().copied().unwrap_or(0.0);
        let target = (i as f64 + rng.random::<f64>()) / count as f64 * total;
        let triangle = self.sums.partition_point(|&sum| sum <= target).min(self.sums.len() - 1);
        let r2 = |a: f64| (0.5 + a * (i + 1) as f64).fract() as f32;
        let (mut u, mut v) = (r2(0.754_877_666_246_692_8), r2(0.569_840_290_998_053_3));
        // Rejection by the density within the triangle; few need more than the sequence's point.
        for _ in 0..8 {
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let site = self.site(triangle, u, v);
            if self.density(&site) > rng.random::<f32>() * self.peaks[triangle] {
                return site;
            }
            (u, v) = (rng.random(), rng.random());
        }
        // Where the density is a mere corner of the triangle: there, and never where it is 0.
        let probes = PROBES.map(|(u, v)| self.site(triangle, u, v));
        probes.into_iter().max_by(|a, b| self.density(a).total_cmp(&self.density(b))).unwrap_or(probes[0])
    }

    fn density(&self, site: &Site) -> f32 {
        // A NaN counts as none.
        (self.density)(site).max(0.0)
    }

    fn site(&self, i: usize, u: f32, v: f32) -> Site {
        let t = self.order[i] as usize;
        let [a, b, c] = self.mesh.triangles[t].map(|v| self.mesh.positions[v as usize]);
        let w = 1.0 - u - v;
        let flat = (b - a).cross(c - a).normalize_or(Vec3::Y);
        let normal = self.mesh.normals.as_ref().map_or(flat, |n| w * n[t][0] + u * n[t][1] + v * n[t][2]);
        let uv = self.mesh.uv.as_ref().map_or(Vec2::ZERO, |uv| w * uv[t][0] + u * uv[t][1] + v * uv[t][2]);
        Site { position: w * a + u * b + v * c, normal: normal.normalize_or(flat), uv }
    }
}

/// Bits of three coordinates in [0, 1023] interleaved.
fn morton(p: Vec3) -> u32 {
    let spread = |x: f32| (0..10).fold(0, |m, bit| m | (x as u32 >> bit & 1) << (3 * bit));
    spread(p.x) | spread(p.y) << 1 | spread(p.z) << 2
}
