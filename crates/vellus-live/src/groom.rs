//! Changes of strands: density, length and clumps of any groom, grown or from a file.

use crate::request::{Groom, within};
use glam::{Vec3, Vec4Swizzles};
use rayon::prelude::*;
use vellus_groom::{Interpolation, interpolate};
use vellus_scene::Strands;

/// Cells of the grid that finds the clumps, on each axis at most.
const CELLS: f32 = 1024.0;

impl Groom {
    /// Checks the ranges.
    pub(crate) fn check(&self) -> Result<(), String> {
        within("density", self.density, 0.01, 4.0)?;
        within("length", self.length, 0.1, 5.0)?;
        within("clump", self.clump, 0.0, 1.0)?;
        within("clump_strands", self.clump_strands as f32, 2.0, 1000.0)?;
        Ok(())
    }

    /// The strands of a set after the changes. The root of each strand stays.
    pub(crate) fn apply(&self, strands: &Strands) -> Strands {
        let mut changed = strands.clone();
        if self.density < 1.0 {
            changed = vellus_groom::thin(strands, self.density);
            // `thin` widens the strands that are left, to cover as much. A less dense coat covers less.
            changed.points.par_iter_mut().for_each(|point| point.w *= self.density);
        } else if self.density > 1.0
            && let Ok(denser) = interpolate(strands, None, self.density, Interpolation::default())
        {
            // A set that would have too many points stays as it is.
            changed = denser;
        }
        if self.clump > 0.0 {
            self.pull(&mut changed);
        }
        if self.length != 1.0 {
            lengthen(&mut changed, self.length);
        }
        changed
    }

    /// Moves tips toward the middle strand of their clump. A clump is the strands whose roots share a cell of a grid.
    fn pull(&self, strands: &mut Strands) {
        let count = strands.len();
        let Some(reference) = (0..count).find(|&i| strands.strand(i).len() > 1) else { return };
        let mean = mean_length(strands, reference);
        let cells = clumps(strands, self.clump_strands, mean);
        let old = strands.clone();
        let center = centers(&cells, count);
        for i in 0..count {
            let leader = center[i];
            if leader == i {
                continue;
            }
            let (own, other) = (old.strand(i), old.strand(leader));
            let span = old.starts[i] as usize..old.starts[i + 1] as usize;
            let offset = own[0].xyz() - other[0].xyz();
            for (k, p) in strands.points[span].iter_mut().enumerate() {
                let s = k as f32 / (own.len() - 1).max(1) as f32;
                let at = ((s * (other.len() - 1) as f32).round() as usize).min(other.len() - 1);
                // Near the root the strand keeps its place; at full strength the tip meets that of the leader.
                let pull = self.clump * s.powf(1.3);
                let toward = other[at].xyz() + offset * (1.0 - pull);
                let moved = p.xyz().lerp(toward, pull);
                *p = moved.extend(p.w);
            }
        }
    }
}

/// The mean length of up to a thousand strands.
fn mean_length(strands: &Strands, first: usize) -> f32 {
    let step = (strands.len() / 1000).max(1);
    let length = |i: usize| strands.strand(i).windows(2).map(|p| p[0].xyz().distance(p[1].xyz())).sum::<f32>();
    let lengths: Vec<f32> = (first..strands.len()).step_by(step).map(length).collect();
    lengths.iter().sum::<f32>() / lengths.len().max(1) as f32
}

/// The cell of each strand's root, in a grid whose occupied cells hold about `strands_per_clump` roots.
fn clumps(strands: &Strands, strands_per_clump: usize, mean_length: f32) -> Vec<[i32; 3]> {
    let roots: Vec<Vec3> =
        (0..strands.len()).map(|i| strands.strand(i).first().map_or(Vec3::ZERO, |p| p.xyz())).collect();
    let (low, high) = roots.iter().fold((roots[0], roots[0]), |(l, h), p| (l.min(*p), h.max(*p)));
    let reach = (high - low).max_element().max(f32::MIN_POSITIVE);
    let cells_of = |size: f32| -> Vec<[i32; 3]> {
        roots.par_iter().map(|p| ((*p - low) / size).floor().as_ivec3().to_array()).collect()
    };
    // Roots lie on a surface: the number of roots in a cell grows with the square of its size.
    let mut size = mean_length.clamp(reach / CELLS, reach);
    for _ in 0..4 {
        let mut cells = cells_of(size);
        cells.par_sort_unstable();
        cells.dedup();
        let now = roots.len() as f32 / cells.len() as f32;
        size = (size * (strands_per_clump as f32 / now).sqrt().clamp(0.2, 5.0)).clamp(reach / CELLS, reach);
    }
    cells_of(size)
}

/// For each strand, the first strand of its cell.
fn centers(cells: &[[i32; 3]], count: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    order.par_sort_unstable_by_key(|&i| (cells[i], i));
    let mut center = vec![0; count];
    let mut leader = 0;
    for (k, &i) in order.iter().enumerate() {
        if k == 0 || cells[i] != cells[order[k - 1]] {
            leader = i;
        }
        center[i] = leader;
    }
    center
}

/// Scales each strand about its root. Radii stay.
fn lengthen(strands: &mut Strands, factor: f32) {
    let starts = strands.starts.clone();
    for range in starts.windows(2).map(|pair| pair[0] as usize..pair[1] as usize) {
        let Some(root) = strands.points.get(range.start).map(|p| p.xyz()) else { continue };
        for p in &mut strands.points[range.clone()] {
            *p = (root + (p.xyz() - root) * factor).extend(p.w);
        }
        if let Some(moved) = &mut strands.moved {
            let root = moved[range.start];
            moved[range].iter_mut().for_each(|p| *p = root + (*p - root) * factor);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fur() -> Strands {
        vellus_groom::scene("cat", true).map(|scene| scene.strands[0].clone()).unwrap()
    }

    fn mean_tip_distance(strands: &Strands, center: &[usize]) -> f32 {
        let tip = |i: usize| strands.strand(i).last().unwrap().xyz();
        let pairs: Vec<f32> = (0..strands.len()).map(|i| tip(i).distance(tip(center[i]))).collect();
        pairs.iter().sum::<f32>() / pairs.len() as f32
    }

    #[test]
    fn the_default_changes_nothing() {
        let fur = fur();
        assert_eq!(Groom::default().apply(&fur), fur);
    }

    #[test]
    fn length_scales_strands_about_their_roots() {
        let fur = fur();
        let long = Groom { length: 2.0, ..Groom::default() }.apply(&fur);
        assert_eq!(long.validate(), Ok(()));
        let ratio = mean_length(&long, 0) / mean_length(&fur, 0);
        // Differences of coordinates around 10 in single precision, over segments of 0.1.
        assert!((ratio - 2.0).abs() < 1e-3, "{ratio}");
        assert!((0..fur.len()).all(|i| fur.strand(i)[0].abs_diff_eq(long.strand(i)[0], 1e-5)));
    }

    #[test]
    fn density_removes_strands_and_keeps_widths() {
        let fur = fur();
        let half = Groom { density: 0.5, ..Groom::default() }.apply(&fur);
        let share = half.len() as f32 / fur.len() as f32;
        assert!((share - 0.5).abs() < 0.05, "{share}");
        assert_eq!(half.validate(), Ok(()));
        let widest = |s: &Strands| s.points.iter().map(|p| p.w).fold(0.0, f32::max);
        assert!(widest(&half) <= 1.001 * widest(&fur));
    }

    #[test]
    fn density_above_one_adds_strands() {
        let fur = fur();
        let double = Groom { density: 2.0, ..Groom::default() }.apply(&fur);
        assert!((double.len() as f32 / fur.len() as f32 - 2.0).abs() < 0.01);
        assert_eq!((double.validate(), &double.points[..fur.points.len()]), (Ok(()), &fur.points[..]));
    }

    #[test]
    fn clumps_draw_tips_together() {
        let fur = fur();
        let center = centers(&clumps(&fur, 20, mean_length(&fur, 0)), fur.len());
        let clumped = Groom { clump: 1.0, clump_strands: 20, ..Groom::default() }.apply(&fur);
        assert_eq!(clumped.validate(), Ok(()));
        let (before, after) = (mean_tip_distance(&fur, &center), mean_tip_distance(&clumped, &center));
        assert!(after < 0.2 * before, "{after} {before}");
    }
}
