//! A radiance cache: the mean light that leaves fibres and surfaces, by place and direction.
//!
//! Full paths fill it before rendering. Each of them adds one record: the light that its second hit sends back along
//! the ray, with the throughput of the path up to there as weight. Later paths end at their second hit and take the
//! mean of its cell. The records come from the same distribution as the paths that use them, so the mean light of a
//! picture is kept.
//!
//! Cells are nested: cubes of six sizes, and the eight octants of directions for all but the largest. A small cell has
//! few records, so its mean is drawn toward the mean of the cell around it. A cell is divided only after it has some
//! records. Why it is built like this: `docs/notes/2026-11-radiance-cache.md`.

use super::color::Rgb;
use crate::film::Layer;
use crate::film::layout::Layout;
use glam::Vec3;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// Sides of the cells, in powers of two times the side of [`Grid::side`], from the largest.
const SIZES: [i32; 6] = [4, 3, 2, 1, 0, -1];

/// The side of a cell of size 0, in pixels.
const PIXELS: f32 = 2.0;

/// Records that a largest cell needs to be used, and that any cell needs before it is divided.
const ENOUGH: u32 = 4;

/// Weight of the parent cell's mean, in records.
const PRIOR: f32 = 4.0;

/// The light that a full path found behind its second hit.
#[derive(Clone, Debug)]
pub(crate) struct Record {
    key: Key,
    /// The throughput of the path at the hit.
    throughput: Rgb,
    /// The light that reached the camera over the hit, for each group of lights: three channels each.
    light: Vec<f32>,
}

/// Cache key of a hit. Hits with equal keys share a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Key {
    pub point: Vec3,
    /// The direction of the ray that hit.
    pub direction: Vec3,
    /// The look or mesh: hits of different things share no cell.
    pub thing: u32,
}

impl Record {
    /// A record that is not complete: `light` is what the path found before the hit.
    pub(super) fn begin(key: Key, throughput: Rgb, before: &[f32]) -> Self {
        Record { key, throughput, light: before.to_vec() }
    }

    /// Completes the record. `after` is what the path found in all.
    pub(super) fn end(&mut self, after: &[f32]) {
        self.light.iter_mut().zip(after).for_each(|(light, after)| *light = after - *light);
    }
}

/// The channels of a path's values that a record keeps: the light of each group, or the beauty if there are no groups.
pub(super) fn channels(layout: &Layout) -> std::ops::Range<usize> {
    match layout.start(Layer::Lights) {
        Some(start) => start..start + 3 * layout.groups().len(),
        None => 0..3,
    }
}

/// The sizes of cells. They grow with the distance from the camera.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    eye: Vec3,
    /// The width of a pixel at distance 1.
    slope: f32,
}

impl Grid {
    /// Whether a path that spread to this width at a point no longer shows the cells there.
    pub(super) fn is_finer(&self, point: Vec3, width: f32) -> bool {
        width >= self.side(point)
    }

    /// The side of a cell of size 0 at a point: a power of two.
    fn side(&self, point: Vec3) -> f32 {
        ((point - self.eye).length() * self.slope * PIXELS).max(f32::MIN_POSITIVE).log2().round().exp2()
    }

    /// The cell of a point. `side` is that of size 0.
    fn cell(&self, key: &Key, side: f32, size: i32) -> u64 {
        let [x, y, z] = (key.point / (side * (size as f32).exp2())).floor().as_ivec3().to_array();
        let octant = match size == SIZES[0] {
            true => 8,
            false => (0..3).map(|axis| u64::from(key.direction[axis] < 0.0) << axis).sum(),
        };
        let pack = |low: i32, high: u32| u64::from(low as u32) | u64::from(high) << 32;
        let hash = mix(pack(x, y as u32) ^ 0x9e37_79b9_7f4a_7c15);
        let hash = mix(hash ^ pack(z, key.thing));
        mix(hash ^ u64::from(side.to_bits()) << 8 ^ octant << 4 ^ (size + 8) as u64)
    }
}

/// Mixes the bits of a number: two rounds of a multiplication and a shift.
fn mix(mut x: u64) -> u64 {
    for _ in 0..2 {
        x = (x ^ x >> 32).wrapping_mul(0xd6e8_feb8_6659_fd93);
    }
    x ^ x >> 32
}

/// The keys of the table are mixed already.
#[derive(Default)]
struct Mixed(u64);

impl Hasher for Mixed {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write_u64(&mut self, x: u64) {
        self.0 = x;
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.0 = mix(self.0 ^ u64::from(byte)));
    }
}

type Table = HashMap<u64, u32, BuildHasherDefault<Mixed>>;

/// A cell while the cache is filled.
#[derive(Clone, Copy, Debug)]
struct Cell {
    /// The cell around it. A largest cell is its own parent.
    parent: u32,
    records: u32,
    throughput: Rgb,
}

/// A cache that is being filled.
#[derive(Debug)]
pub(crate) struct Filling {
    grid: Grid,
    channels: usize,
    table: Table,
    cells: Vec<Cell>,
    /// The sum of the light of each cell.
    light: Vec<f32>,
}

impl Filling {
    /// An empty cache for a camera at `eye` whose pixels have the width `slope` at distance 1.
    pub(crate) fn new(eye: Vec3, slope: f32, layout: &Layout) -> Self {
        let channels = channels(layout).len();
        Filling { grid: Grid { eye, slope }, channels, table: Table::default(), cells: Vec::new(), light: Vec::new() }
    }

    /// How paths make records.
    pub(crate) fn recorded(&self) -> Indirect<'static> {
        Indirect::Recorded(self.grid)
    }

    /// Adds a record. Records with values that are not finite are left out. The result depends on the order.
    pub(crate) fn add(&mut self, record: &Record) {
        if !record.light.iter().chain(&record.throughput).all(|x| x.is_finite()) {
            return;
        }
        let side = self.grid.side(record.key.point);
        let mut parent = None;
        for size in SIZES {
            let new = self.cells.len() as u32;
            let index = *self.table.entry(self.grid.cell(&record.key, side, size)).or_insert(new);
            if index == new {
                self.cells.push(Cell { parent: parent.unwrap_or(new), records: 0, throughput: [0.0; 3] });
                self.light.resize(self.light.len() + self.channels, 0.0);
            }
            let cell = &mut self.cells[index as usize];
            cell.records += 1;
            (0..3).for_each(|c| cell.throughput[c] += record.throughput[c]);
            let light = &mut self.light[index as usize * self.channels..][..self.channels];
            light.iter_mut().zip(&record.light).for_each(|(sum, x)| *sum += x);
            if cell.records < ENOUGH {
                break;
            }
            parent = Some(index);
        }
    }

    /// The means of all cells.
    pub(crate) fn finish(mut self) -> RadianceCache {
        let mut used = vec![true; self.cells.len()];
        // A parent comes before its children.
        for (i, cell) in self.cells.iter().enumerate() {
            let (parent, n) = (cell.parent as usize, cell.records as f32);
            let root = parent == i;
            used[i] = if root { cell.records >= ENOUGH } else { used[parent] };
            for k in 0..self.channels {
                // The mean of the cell around this one counts as this many records of the same throughput.
                let weight = cell.throughput[k % 3];
                let (prior, around) =
                    if root { (0.0, 0.0) } else { (PRIOR / n, self.light[parent * self.channels + k]) };
                let sum = self.light[i * self.channels + k] + prior * weight * around;
                let mean = sum / (weight * (1.0 + prior));
                self.light[i * self.channels + k] = if weight > 0.0 { mean } else { around };
            }
        }
        self.table.retain(|_, index| used[*index as usize]);
        RadianceCache { grid: self.grid, channels: self.channels, table: self.table, light: self.light }
    }
}

/// The mean light that leaves the things in a scene, seen from the second hits of paths.
///
/// [`World::fill_cache`](crate::World::fill_cache) makes it.
#[derive(Debug)]
pub struct RadianceCache {
    grid: Grid,
    channels: usize,
    table: Table,
    /// The mean light of each cell.
    light: Vec<f32>,
}

impl RadianceCache {
    /// The mean radiance that leaves a thing against the direction of the ray that hit it, three channels for each
    /// group of lights, from the smallest cell with records. `None` if there are too few.
    ///
    /// `u` in [0, 1)³ moves the point by up to half a cell of size 0, so that the edges of cells do not show.
    pub(super) fn radiance(&self, key: &Key, u: [f32; 3]) -> Option<&[f32]> {
        let side = self.grid.side(key.point);
        let moved = Key { point: key.point + (Vec3::from(u) - 0.5) * side, ..*key };
        let found = SIZES.iter().rev().find_map(|&size| self.table.get(&self.grid.cell(&moved, side, size)));
        found.map(|&index| &self.light[index as usize * self.channels..][..self.channels])
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.table.len()
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> usize {
        self.table.capacity() * (size_of::<(u64, u32)>() + 1) + self.light.capacity() * size_of::<f32>()
    }

    /// Whether it has the light of these layers.
    pub(crate) fn fits(&self, layout: &Layout) -> bool {
        self.channels == channels(layout).len()
    }
}

/// How paths find indirect light.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Indirect<'c> {
    /// They are traced to their ends.
    Traced,
    /// They are traced to their ends, and make records for a cache with these cells.
    Recorded(Grid),
    /// They end at their second hit, where the cache has light for it.
    Cached(&'c RadianceCache),
}

impl Indirect<'_> {
    /// The cells of the cache.
    pub(super) fn grid(&self) -> Option<&Grid> {
        match self {
            Indirect::Traced => None,
            Indirect::Recorded(grid) => Some(grid),
            Indirect::Cached(cache) => Some(&cache.grid),
        }
    }
}
