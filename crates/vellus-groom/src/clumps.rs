//! Clumps: strands bend toward a central strand. Clumps differ in size and in strength.

use crate::settings::{Clump, GrowSettings};
use glam::{IVec3, Vec3};
use rayon::prelude::*;
use std::collections::HashMap;

/// The central strands, with a grid to find them by their roots.
pub(crate) struct Clumps {
    clump: Clump,
    cell: f32,
    /// Origin of the grid. Coordinates may be large relative to the cells.
    origin: Vec3,
    roots: Vec<Vec3>,
    lines: Vec<Vec3>,
    /// Central strands, by the cell of their root.
    grid: HashMap<IVec3, Vec<u32>>,
}

impl Clumps {
    /// Selects every n-th strand as a central one. Strands are in spatial order, so central strands are evenly spaced.
    /// `line` returns the root and points of a strand.
    pub fn new(settings: &GrowSettings, area: f32, line: impl Fn(usize) -> (Vec3, Vec<Vec3>) + Sync) -> Self {
        let clump = settings.clump;
        let mut clumps =
            Clumps { clump, cell: 1.0, origin: Vec3::ZERO, roots: Vec::new(), lines: Vec::new(), grid: HashMap::new() };
        if clump.strands < 2 || clump.strength == 0.0 {
            return clumps;
        }
        let middles: Vec<_> =
            (0..settings.count / clump.strands).into_par_iter().map(|i| line(i * clump.strands)).collect();
        clumps.cell = (2.0 * (area * clump.strands as f32).sqrt()).max(f32::MIN_POSITIVE);
        clumps.origin = middles.first().map_or(Vec3::ZERO, |(root, _)| *root);
        for (i, (root, line)) in middles.into_iter().enumerate() {
            clumps.grid.entry(clumps.cell_of(root)).or_default().push(i as u32);
            clumps.roots.push(root);
            clumps.lines.extend(line);
        }
        clumps
    }

    /// Bends strand `i` toward a central strand with a root nearby, if there is one.
    pub fn gather(&self, i: usize, root: Vec3, line: &mut [Vec3]) {
        let Some(nearest) = self.nearest(root) else { return };
        let middle = &self.lines[nearest * line.len()..][..line.len()];
        // Strengths vary, because all tips would meet in one point otherwise. The mean of both factors is 1.
        let own = (i as u32).wrapping_mul(0x9e37_79b9) as f32 / u32::MAX as f32;
        let strength = self.clump.strength.powf((0.5 + own) * (0.6 + 0.8 * hash(!(nearest as u32))));
        let last = line.len() - 1;
        // If strands are far apart relative to their length, this would stretch them. No tip moves by more than half
        // the length of the strand.
        let length: f32 = line.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        let away = line[last].distance(middle[last]);
        let strength = strength.min(0.5 * length / away.max(f32::MIN_POSITIVE));
        let last = last as f32;
        for (k, (p, m)) in line.iter_mut().zip(middle).enumerate().skip(1) {
            *p = p.lerp(*m, strength * (k as f32 / last).powf(self.clump.power));
        }
    }

    fn cell_of(&self, root: Vec3) -> IVec3 {
        ((root - self.origin) / self.cell).floor().as_ivec3()
    }

    /// The nearest central strand. Distances have a weight for each clump, so that some clumps are larger.
    fn nearest(&self, root: Vec3) -> Option<usize> {
        let cell = self.cell_of(root);
        let offset = |i: i32| IVec3::new(i % 3, i / 3 % 3, i / 9) - 1;
        let near = (0..27).filter_map(|i| self.grid.get(&cell.saturating_add(offset(i)))).flatten();
        let distance = |&i: &&u32| self.roots[*i as usize].distance_squared(root) * (0.4 + 1.2 * hash(*i));
        near.min_by(|a, b| distance(a).total_cmp(&distance(b))).map(|&i| i as usize)
    }
}

/// A random number in [0, 1] for an index.
pub(crate) fn hash(i: u32) -> f32 {
    let mut h = i.wrapping_mul(0x9e37_79b9);
    h = (h ^ h >> 15).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ h >> 12).wrapping_mul(0x297a_2d39);
    (h ^ h >> 15) as f32 / u32::MAX as f32
}
