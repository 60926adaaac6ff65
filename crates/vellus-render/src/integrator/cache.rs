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
//!
//! The cache grows with the picture: each time the number of samples doubles, so does the number that filled it, once
//! it is an eighth. So its error becomes smaller with the samples, and that of the first ones counts less and less.
//! Which samples fill the cache of a sample depends on its number alone, so a picture does not depend on its division.

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

/// A picture of so many samples has a cache of an eighth of them.
const SHARE: u64 = 8;

/// How many samples of each pixel fill the cache of a sample, if the first have `least`.
pub(crate) fn samples_for(least: u32, sample: u64) -> u32 {
    let grown = if sample == 0 { 0 } else { (1 << sample.ilog2()) / SHARE };
    u32::try_from(grown).unwrap_or(u32::MAX).max(least)
}

/// The first sample after this one whose cache has more samples.
pub(crate) fn next_growth(least: u32, sample: u64) -> u64 {
    let more = (u64::from(least) * SHARE + 1).max(sample.saturating_add(1));
    more.checked_next_power_of_two().unwrap_or(u64::MAX)
}

/// The light that a full path found behind its second hit.
#[derive(Debug)]
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

/// Records with the light of equally many channels, without an allocation for each.
#[derive(Debug, Default)]
pub(crate) struct Records {
    keys: Vec<Key>,
    /// The throughput and the light of each.
    numbers: Vec<f32>,
}

impl Records {
    pub(crate) fn push(&mut self, record: &Record) {
        self.keys.push(record.key);
        self.numbers.extend(record.throughput.iter().chain(&record.light));
    }

    /// Those of others, behind its own.
    pub(crate) fn append(&mut self, others: &mut Records) {
        self.keys.append(&mut others.keys);
        self.numbers.append(&mut others.numbers);
    }
}

/// The channels of a path's values that a record keeps: the light of each group, or the beauty if there are no groups.
pub(super) fn channels(layout: &Layout) -> std::ops::Range<usize> {
    match layout.start(Layer::Lights) {
        Some(start) => start..start + 3 * layout.groups().len(),
        None => 0..3,
    }
}

/// The sum over the groups of lights.
fn sum_of_groups(light: &[f32]) -> Rgb {
    let groups = light.as_chunks::<3>().0;
    groups.iter().fold([0.0; 3], |sum, group| std::array::from_fn(|c| sum[c] + group[c]))
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
#[derive(Clone, Copy, Debug, Default)]
struct Cell {
    /// The cell around it. A largest cell is its own parent.
    parent: u32,
    records: u32,
    throughput: Rgb,
    /// The sums of light and throughput, each record with its sign.
    signed: [Rgb; 2],
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
    /// The number of records.
    records: u64,
}

impl Filling {
    /// An empty cache for a camera at `eye` whose pixels have the width `slope` at distance 1.
    pub(crate) fn new(eye: Vec3, slope: f32, layout: &Layout) -> Self {
        let channels = channels(layout).len();
        Filling {
            grid: Grid { eye, slope },
            channels,
            table: Table::default(),
            cells: Vec::new(),
            light: Vec::new(),
            records: 0,
        }
    }

    /// How paths make records.
    pub(crate) fn recorded(&self) -> Indirect<'static> {
        Indirect::Recorded(self.grid)
    }

    /// Adds records. Those with values that are not finite are left out. The result depends on the order.
    pub(crate) fn add(&mut self, records: &Records) {
        for (key, numbers) in records.keys.iter().zip(records.numbers.chunks_exact(3 + self.channels)) {
            if let (true, Some((throughput, light))) =
                (numbers.iter().all(|x| x.is_finite()), numbers.split_first_chunk::<3>())
            {
                self.add_one(key, throughput, light);
            }
        }
    }

    fn add_one(&mut self, key: &Key, throughput: &Rgb, record_light: &[f32]) {
        let side = self.grid.side(key.point);
        self.records += 1;
        let sign = if mix(self.records) & 1 == 0 { 1.0 } else { -1.0 };
        let all_light = sum_of_groups(record_light);
        let mut parent = None;
        for size in SIZES {
            let new = self.cells.len() as u32;
            let index = *self.table.entry(self.grid.cell(key, side, size)).or_insert(new);
            if index == new {
                self.cells.push(Cell { parent: parent.unwrap_or(new), ..Cell::default() });
                self.light.resize(self.light.len() + self.channels, 0.0);
            }
            let cell = &mut self.cells[index as usize];
            cell.records += 1;
            for c in 0..3 {
                cell.throughput[c] += throughput[c];
                cell.signed[0][c] += sign * all_light[c];
                cell.signed[1][c] += sign * throughput[c];
            }
            let light = &mut self.light[index as usize * self.channels..][..self.channels];
            light.iter_mut().zip(record_light).for_each(|(sum, x)| *sum += x);
            if cell.records < ENOUGH {
                break;
            }
            parent = Some(index);
        }
    }

    /// The means of all cells, after this many samples of each pixel.
    pub(crate) fn finish(self, samples: u32) -> RadianceCache {
        let mut used = vec![true; self.cells.len()];
        let mut light = self.light.clone();
        let mut error: Vec<Rgb> = Vec::with_capacity(self.cells.len());
        // A parent comes before its children.
        for (i, cell) in self.cells.iter().enumerate() {
            let (parent, n) = (cell.parent as usize, cell.records as f32);
            let root = parent == i;
            used[i] = if root { cell.records >= ENOUGH } else { used[parent] };
            // The mean of the cell around this one counts as this many records of the same throughput.
            let prior = if root { 0.0 } else { PRIOR / n };
            for k in 0..self.channels {
                let weight = cell.throughput[k % 3];
                let around = if root { 0.0 } else { light[parent * self.channels + k] };
                let sum = light[i * self.channels + k] + prior * weight * around;
                let mean = sum / (weight * (1.0 + prior));
                light[i * self.channels + k] = if weight > 0.0 { mean } else { around };
            }
            let center = if root { i } else { parent };
            let [own, around] = [i, center].map(|i| sum_of_groups(&light[i * self.channels..][..self.channels]));
            // Means of nested cells differ as much as the light does inside the smaller one, if it has edges.
            let of_parent = if root { [0.0; 3] } else { error[parent] };
            let [signed, throughput] = cell.signed;
            error.push(std::array::from_fn(|c| {
                let weight = cell.throughput[c];
                let noise = if weight > 0.0 { (signed[c] - around[c] * throughput[c]) / weight } else { 0.0 };
                (noise + prior * of_parent[c]) / (1.0 + prior) + own[c] - around[c]
            }));
        }
        RadianceCache { filling: self, samples, used, light, error }
    }
}

/// The mean light that leaves the things in a scene, seen from the second hits of paths.
///
/// [`World::fill_cache`](crate::World::fill_cache) makes it.
#[derive(Debug)]
pub struct RadianceCache {
    filling: Filling,
    samples: u32,
    /// Whether a cell has enough records around it.
    used: Vec<bool>,
    /// The mean light of each cell.
    light: Vec<f32>,
    /// The error of the sum of all groups in each cell.
    error: Vec<Rgb>,
}

impl RadianceCache {
    /// The mean radiance that leaves a thing against the direction of the ray that hit it, three channels for each
    /// group of lights, from the smallest cell with records; and the error of their sum. `None` if there are too few
    /// records.
    ///
    /// The error has two parts: the noise of the records, and what the cell differs from those around it, because it
    /// differs as much inside. The noise is the sum of what the records differ from the mean, each with a sign by
    /// chance. So a path may add up the errors of several cells: the mean square of the sum is right, though they share
    /// records.
    ///
    /// `u` in [0, 1)³ moves the point by up to half a cell of size 0, so that the edges of cells do not show.
    pub(super) fn radiance(&self, key: &Key, u: [f32; 3]) -> Option<(&[f32], Rgb)> {
        let Filling { grid, channels, table, .. } = &self.filling;
        let side = grid.side(key.point);
        let moved = Key { point: key.point + (Vec3::from(u) - 0.5) * side, ..*key };
        let found = SIZES.iter().rev().find_map(|&size| table.get(&grid.cell(&moved, side, size)));
        let index = found.map(|&index| index as usize).filter(|&index| self.used[index])?;
        Some((&self.light[index * channels..][..*channels], self.error[index]))
    }

    /// The samples of each pixel that filled it.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Goes on with filling it.
    pub(crate) fn into_filling(self) -> Filling {
        self.filling
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.filling.cells.len()
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> usize {
        let Filling { table, cells, light, .. } = &self.filling;
        let means = (light.capacity() + self.light.capacity()) * size_of::<f32>() + self.used.capacity();
        let means = means + self.error.capacity() * size_of::<Rgb>();
        table.capacity() * (size_of::<(u64, u32)>() + 1) + cells.capacity() * size_of::<Cell>() + means
    }

    /// Whether it has the light of these layers.
    pub(crate) fn fits(&self, layout: &Layout) -> bool {
        self.filling.channels == channels(layout).len()
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
            Indirect::Cached(cache) => Some(&cache.filling.grid),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cache_grows_to_an_eighth_of_the_samples() {
        for least in [1, 3, 8, 16] {
            let mut next = 0;
            for sample in 0..5000 {
                let filled = samples_for(least, sample);
                assert!(filled >= least && u64::from(filled) <= (sample / SHARE).max(least.into()), "{least} {sample}");
                assert!(u64::from(filled) * 2 * SHARE > sample, "{least} {sample}: {filled}");
                if sample == next {
                    next = next_growth(least, sample);
                    assert!(samples_for(least, next) > filled);
                }
                assert_eq!(samples_for(least, next - 1), filled);
            }
        }
        assert_eq!(next_growth(16, u64::MAX), u64::MAX);
    }
}
