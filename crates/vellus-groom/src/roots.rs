//! Roots of strands: evenly distributed over a mesh, in proportion to a density.

use crate::error::Error;
use glam::{Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use vellus_scene::Mesh;

/// A point on a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Site {
    /// The position.
    pub position: Vec3,
    /// The shading normal; a unit vector.
    pub normal: Vec3,
    /// The texture coordinates, or 0 if the mesh has none.
    pub uv: Vec2,
}

/// Points of a cell at which the density is evaluated for its peak, in addition to the points for its mean.
const CORNERS: [(f32, f32); 3] = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)];

/// Expected number of strands in a cell. Triangles with more strands are divided into cells, which resolve the density.
const STRANDS_A_CELL: f32 = 32.0;

/// A part of a triangle that is divided into `n` parts along each edge.
#[derive(Clone, Copy)]
struct Cell {
    triangle: u32,
    n: u16,
    /// Column and row, from the first corner.
    at: [u16; 2],
    /// Whether the cell is upside down.
    flipped: bool,
}

impl Cell {
    /// Converts barycentric coordinates of the cell to those of the triangle.
    fn whole(&self, u: f32, v: f32) -> (f32, f32) {
        let [x, y] = self.at.map(f32::from);
        let n = f32::from(self.n);
        if self.flipped { ((x + 1.0 - u) / n, (y + 1.0 - v) / n) } else { ((x + u) / n, (y + v) / n) }
    }

    /// The cells of a triangle.
    fn of(triangle: u32, n: u16) -> impl Iterator<Item = Cell> {
        (0..n).flat_map(move |y| {
            let upright = (0..n - y).map(move |x| Cell { triangle, n, at: [x, y], flipped: false });
            upright.chain((1..n - y).map(move |x| Cell { triangle, n, at: [x - 1, y], flipped: true }))
        })
    }
}

/// A mesh with its cells in spatial order, and the distribution of strands over them.
pub(crate) struct Roots<'a> {
    mesh: &'a Mesh,
    density: &'a (dyn Fn(&Site) -> f32 + Sync),
    cells: Vec<Cell>,
    /// Running sum of area times density.
    sums: Vec<f64>,
    /// The largest density that was found in each cell.
    peaks: Vec<f32>,
}

impl<'a> Roots<'a> {
    /// Divides a mesh into cells for about `count` strands.
    pub fn new(mesh: &'a Mesh, density: &'a (dyn Fn(&Site) -> f32 + Sync), count: usize) -> Result<Self, Error> {
        mesh.validate()?;
        let area = |t: usize| {
            let [a, b, c] = mesh.triangles[t].map(|v| mesh.positions[v as usize]);
            0.5 * (b - a).cross(c - a).length()
        };
        let all = || 0..mesh.triangles.len();
        let whole: f64 = all().map(|t| f64::from(area(t))).sum();
        let cells = all().flat_map(|t| {
            let strands = f64::from(area(t)) / whole * count as f64;
            let n = (strands as f32 / STRANDS_A_CELL).sqrt().ceil().clamp(1.0, 256.0);
            Cell::of(t as u32, n as u16)
        });
        let mut roots = Roots { mesh, density, cells: cells.collect(), sums: Vec::new(), peaks: Vec::new() };
        let center = |cell: &Cell| roots.site(cell, 1.0 / 3.0, 1.0 / 3.0).position;
        let bounds = |(low, high): (Vec3, Vec3), p: Vec3| (low.min(p), high.max(p));
        let (low, high) = roots.cells.iter().map(center).fold((Vec3::INFINITY, Vec3::NEG_INFINITY), bounds);
        let scale = 1023.0 / (high - low).max_element().max(f32::MIN_POSITIVE);
        let mut keyed: Vec<_> = roots.cells.iter().map(|&cell| (morton((center(&cell) - low) * scale), cell)).collect();
        // The sort is stable, so cells with equal keys keep the order of the mesh.
        keyed.sort_by_key(|(key, _)| *key);
        roots.cells = keyed.into_iter().map(|(_, cell)| cell).collect();

        let mut sum = 0.0;
        for i in 0..roots.cells.len() {
            let cell = roots.cells[i];
            let area = area(cell.triangle as usize) / f32::from(cell.n).powi(2);
            let density = |(u, v): (f32, f32)| roots.density(&roots.site(&cell, u, v));
            let probes = probes(i).map(density);
            let mean = 0.25 * probes.iter().sum::<f32>();
            let peak = probes.into_iter().chain(CORNERS.map(density)).fold(0.0, f32::max);
            sum += f64::from(area * mean);
            roots.sums.push(sum);
            roots.peaks.push(peak);
        }
        if sum > 0.0 && sum.is_finite() { Ok(roots) } else { Err(Error::Nowhere(mesh.name.clone())) }
    }

    /// The integral of the density over the mesh.
    pub fn area(&self) -> f64 {
        self.sums.last().copied().unwrap_or(0.0)
    }

    /// The mean area per strand at density 1.
    pub fn area_per_strand(&self, count: usize) -> f32 {
        (self.area() / count.max(1) as f64) as f32
    }

    /// Root `i` of `count`. Each root has its own interval of the running sum, which is a compact patch of the surface.
    /// Within a cell, roots follow the R₂ sequence. Both keep roots apart.
    pub fn root(&self, i: usize, count: usize, rng: &mut Xoshiro256PlusPlus) -> Site {
        let target = (i as f64 + rng.random::<f64>()) / count as f64 * self.area();
        let index = self.sums.partition_point(|&sum| sum <= target).min(self.sums.len() - 1);
        let r2 = |a: f64| (0.5 + a * (i + 1) as f64).fract() as f32;
        let (mut u, mut v) = (r2(0.754_877_666_246_692_8), r2(0.569_840_290_998_053_3));
        let cell = &self.cells[index];
        // Rejection sampling by the density within the cell. Most roots accept the point of the sequence.
        for _ in 0..64 {
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let site = self.site(cell, u, v);
            if self.density(&site) > rng.random::<f32>() * self.peaks[index] {
                return site;
            }
            (u, v) = (rng.random(), rng.random());
        }
        // If most of the cell has a low density, this returns a point with a high density. It never returns a point
        // with density 0.
        let probes = probes(index).map(|(u, v)| self.site(cell, u, v));
        probes.into_iter().max_by(|a, b| self.density(a).total_cmp(&self.density(b))).unwrap_or(probes[0])
    }

    fn density(&self, site: &Site) -> f32 {
        // NaN becomes 0.
        (self.density)(site).max(0.0)
    }

    fn site(&self, cell: &Cell, u: f32, v: f32) -> Site {
        let t = cell.triangle as usize;
        let (u, v) = cell.whole(u, v);
        let [a, b, c] = self.mesh.triangles[t].map(|v| self.mesh.positions[v as usize]);
        let w = 1.0 - u - v;
        let flat = (b - a).cross(c - a).normalize_or(Vec3::Y);
        let normal = self.mesh.normals.as_ref().map_or(flat, |n| w * n[t][0] + u * n[t][1] + v * n[t][2]);
        let uv = self.mesh.uv.as_ref().map_or(Vec2::ZERO, |uv| w * uv[t][0] + u * uv[t][1] + v * uv[t][2]);
        Site { position: w * a + u * b + v * c, normal: normal.normalize_or(flat), uv }
    }
}

/// A random point in each quarter of cell `i`. Regular points would have a bias for regular densities.
fn probes(i: usize) -> [(f32, f32); 4] {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(i as u64);
    let mut quarters = Cell::of(0, 2);
    std::array::from_fn(|_| {
        let (u, v) = (rng.random::<f32>(), rng.random::<f32>());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        // There are four.
        quarters.next().map_or((u, v), |quarter| quarter.whole(u, v))
    })
}

/// The Morton code of three coordinates in [0, 1023].
fn morton(p: Vec3) -> u32 {
    let spread = |x: f32| (0..10).fold(0, |m, bit| m | (x as u32 >> bit & 1) << (3 * bit));
    spread(p.x) | spread(p.y) << 1 | spread(p.z) << 2
}
