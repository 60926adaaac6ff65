//! Clumps: strands that draw together toward the middle one.

use crate::settings::{Clump, GrowSettings};
use glam::{IVec3, Vec3};
use rayon::prelude::*;
use std::collections::HashMap;

/// The middle strands, found by their roots.
pub(crate) struct Clumps {
    clump: Clump,
    cell: f32,
    /// Where cells are counted from: coordinates may be large against them.
    origin: Vec3,
    roots: Vec<Vec3>,
    lines: Vec<Vec3>,
    /// Middle strands by the cell their root is in.
    grid: HashMap<IVec3, Vec<u32>>,
}

impl Clumps {
    /// Every so-many-th strand is a middle one: neighbours follow each other, which spreads them evenly. `line` gives
    /// root and points of a strand.
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

    /// Draws strand `i` toward the middle strand with the nearest root, if one is near.
    pub fn gather(&self, i: usize, root: Vec3, line: &mut [Vec3]) {
        let Some(nearest) = self.nearest(root) else { return };
        let middle = &self.lines[nearest * line.len()..][..line.len()];
        // Not all alike, or tips would meet in one point: the exponent is a hash of the index, as a fraction, and a
        // half.
        let own = (i as u32).wrapping_mul(0x9e37_79b9) as f32 / u32::MAX as f32;
        let strength = self.clump.strength.powf(0.5 + own);
        let last = line.len() - 1;
        // Where strands are far apart against their length, they would be stretched across the gaps: no tip goes further than
        // half of its length.
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

    fn nearest(&self, root: Vec3) -> Option<usize> {
        let cell = self.cell_of(root);
        let offset = |i: i32| IVec3::new(i % 3, i / 3 % 3, i / 9) - 1;
        let near = (0..27).filter_map(|i| self.grid.get(&cell.saturating_add(offset(i)))).flatten();
        let distance = |&i: &&u32| self.roots[*i as usize].distance_squared(root);
        near.min_by(|a, b| distance(a).total_cmp(&distance(b))).map(|&i| i as usize)
    }
}
