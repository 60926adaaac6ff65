//! All strands of a scene, for rays.
//!
//! A leaf holds the chords of up to eight segments. A register tests them all against the ray, each as thick as the curve strays
//! from its chord; few remain, and only those are entered exactly, from their control points.

use crate::bvh::{Bounds, Bvh, WIDTH};
use crate::memory;
use crate::ray::{Ray, across};
use crate::segment::{Entry, Segment};
use glam::Vec4;
use rayon::prelude::*;
use vellus_scene::Strands;
use wide::f32x8;

/// Chords of up to eight segments.
#[derive(Clone, Debug)]
struct Block {
    /// Their ends; what is missing is infinitely far away.
    ends: [[f32x8; 3]; 2],
    /// Radius and deviation from the chord together, at most.
    reach: f32x8,
    /// First control point, counted over all strands of the scene.
    first: [u32; WIDTH],
}

/// Strands and the hierarchy over their segments.
#[derive(Clone, Debug)]
pub struct Curves {
    strands: Vec<Strands>,
    /// Control points before each of `strands`.
    offsets: Vec<u32>,
    blocks: Vec<Block>,
    bvh: Bvh,
    segments: usize,
}

/// Where a ray enters a strand.
#[derive(Clone, Copy, Debug)]
pub struct CurveHit {
    /// Which of the scene's strands.
    pub set: usize,
    /// Which strand.
    pub strand: usize,
    /// First control point of the segment, in the set.
    pub point: usize,
    /// Distance along the ray, and parameter in the segment.
    pub entry: Entry,
    /// The segment itself.
    pub segment: Segment,
}

impl Curves {
    /// Builds the hierarchy; `strands` must be valid.
    pub fn new(mut strands: Vec<Strands>) -> Self {
        for set in &mut strands {
            set.points = memory::moved(std::mem::take(&mut set.points));
        }
        let mut offsets = vec![0u32];
        for set in &strands {
            offsets.push(offsets[offsets.len() - 1] + set.points.len() as u32);
        }
        let first: Vec<u32> = strands
            .iter()
            .zip(&offsets)
            .flat_map(|(set, &offset)| {
                (0..set.len()).flat_map(move |i| {
                    let step = if set.basis == vellus_scene::Basis::Bezier { 3 } else { 1 };
                    let segments = set.basis.segments(set.strand(i).len()).unwrap_or(0) as u32;
                    (0..segments).map(move |k| offset + set.starts[i] + step * k)
                })
            })
            .collect();
        let mut curves =
            Curves { strands, offsets, blocks: Vec::new(), bvh: Bvh::build(&[], |_| {}), segments: first.len() };
        let boxes: Vec<Bounds> = first.par_iter().map(|&first| curves.segment(first).1.bounds()).collect();
        let mut leaves = Vec::with_capacity(first.len() / 5);
        curves.bvh = Bvh::build(&boxes, |primitives| {
            let mut leaf = [u32::MAX; WIDTH];
            leaf.iter_mut().zip(primitives).for_each(|(l, &p)| *l = first[p as usize]);
            leaves.push(leaf);
        });
        drop((boxes, first));
        let mut blocks = memory::with_capacity(leaves.len());
        leaves.par_iter().map(|leaf| curves.block(leaf)).collect_into_vec(&mut blocks);
        curves.blocks = blocks;
        curves
    }

    fn block(&self, first: &[u32; WIDTH]) -> Block {
        let (mut ends, mut reach) = ([[[f32::INFINITY; WIDTH]; 3]; 2], [0.0; WIDTH]);
        for (lane, &first) in first.iter().enumerate().filter(|&(_, &first)| first != u32::MAX) {
            let segment = self.segment(first).1;
            for (end, point) in [segment.points[0], segment.points[3]].into_iter().enumerate() {
                (0..3).for_each(|k| ends[end][k][lane] = point[k]);
            }
            reach[lane] = segment.largest_radius() + segment.deviation();
        }
        Block { ends: ends.map(|end| end.map(f32x8::new)), reach: f32x8::new(reach), first: *first }
    }

    /// The set and the segment that begins at that control point.
    #[inline]
    fn segment(&self, first: u32) -> (usize, Segment) {
        let (set, points) = self.points(first);
        (set, Segment::new(self.strands[set].basis, points))
    }

    /// The set and the control points of the segment that begins there.
    #[inline]
    fn points(&self, first: u32) -> (usize, &[Vec4]) {
        let set = self.offsets.partition_point(|&offset| offset <= first) - 1;
        let strands = &self.strands[set];
        let point = (first - self.offsets[set]) as usize;
        let count = if strands.basis == vellus_scene::Basis::Linear { 2 } else { 4 };
        (set, &strands.points[point..point + count])
    }

    /// The strands, in the scene's order.
    pub fn strands(&self) -> &[Strands] {
        &self.strands
    }

    /// Number of segments.
    pub fn segments(&self) -> usize {
        self.segments
    }

    /// Bytes of control points and hierarchy.
    pub fn bytes(&self) -> usize {
        let strands = |s: &Strands| size_of_val(&s.points[..]) + size_of_val(&s.starts[..]);
        self.strands.iter().map(strands).sum::<usize>() + self.blocks.len() * size_of::<Block>() + self.bvh.bytes()
    }

    /// The first strand a ray enters.
    pub fn intersect(&self, ray: &Ray) -> Option<CurveHit> {
        let mut best: Option<(u32, Entry)> = None;
        let enter = |first: u32, ray: &mut Ray, best: &mut Option<(u32, Entry)>| {
            if let Some(entry) = self.segment(first).1.intersect(ray) {
                ray.limit = entry.t;
                *best = Some((first, entry));
            }
            true
        };
        let frame = RayFrame::new(ray);
        let mut ray = *ray;
        let mut waiting = Waiting::default();
        self.bvh.traverse(&ray.clone(), |leaf| memory::fetch(&self.blocks[leaf as usize]), |leaf, limit| {
            ray.limit = limit;
            let came = self.near(leaf, &frame, limit);
            std::mem::replace(&mut waiting, came).all(|first| enter(first, &mut ray, &mut best));
            ray.limit
        });
        waiting.all(|first| enter(first, &mut ray, &mut best));
        best.map(|(first, entry)| {
            let (set, segment) = self.segment(first);
            let point = first - self.offsets[set];
            let strand = self.strands[set].starts.partition_point(|&start| start <= point) - 1;
            CurveHit { set, strand, point: point as usize, entry, segment }
        })
    }

    /// Does anything lie on the ray before its limit?
    pub fn occluded(&self, ray: &Ray) -> bool {
        let frame = RayFrame::new(ray);
        let mut waiting = Waiting::default();
        let clear = |waiting: Waiting<'_>| waiting.all(|first| self.segment(first).1.intersect(ray).is_none());
        let mut found = false;
        self.bvh.traverse(ray, |leaf| memory::fetch(&self.blocks[leaf as usize]), |leaf, limit| {
            let came = self.near(leaf, &frame, limit);
            found = !clear(std::mem::replace(&mut waiting, came));
            if found { -1.0 } else { limit }
        });
        found || !clear(waiting)
    }

    /// The segments of a leaf that a ray comes near to. Their control points are on the way from memory.
    #[inline(always)]
    fn near(&self, leaf: u32, frame: &RayFrame, limit: f32) -> Waiting<'_> {
        let block = &self.blocks[leaf as usize];
        let waiting = Waiting { first: &block.first, mask: block.near(frame, limit) };
        waiting.all(|first| {
            let (set, points) = self.points(first);
            let _ = set;
            memory::fetch(&points[0]);
            memory::fetch(&points[points.len() - 1]);
            true
        });
        waiting
    }
}

/// Segments of a leaf that are still to be entered. They wait until the next leaf has been looked at: meanwhile
/// their control points arrive.
#[derive(Clone, Copy, Default)]
struct Waiting<'a> {
    first: &'a [u32],
    mask: u32,
}

impl Waiting<'_> {
    /// Visits them while `visit` asks for more; false where it did not.
    #[inline(always)]
    fn all(self, mut visit: impl FnMut(u32) -> bool) -> bool {
        let mut mask = self.mask;
        while mask != 0 {
            if !visit(self.first[mask.trailing_zeros() as usize]) {
                return false;
            }
            mask &= mask - 1;
        }
        true
    }
}

/// A ray's origin, and a frame with the ray as its third axis.
struct RayFrame {
    origin: [f32x8; 3],
    axes: [[f32x8; 3]; 3],
}

impl RayFrame {
    #[inline]
    fn new(ray: &Ray) -> Self {
        let (u, v) = across(ray.direction);
        let lanes = |v: glam::Vec3| v.to_array().map(f32x8::splat);
        RayFrame { origin: lanes(ray.origin), axes: [lanes(u), lanes(v), lanes(ray.direction)] }
    }
}

impl Block {
    /// The lanes whose chord comes within reach of the ray between its origin and `limit`.
    #[inline(always)]
    fn near(&self, frame: &RayFrame, limit: f32) -> u32 {
        let place = |end: &[f32x8; 3]| -> [f32x8; 3] {
            let q: [f32x8; 3] = [end[0] - frame.origin[0], end[1] - frame.origin[1], end[2] - frame.origin[2]];
            frame.axes.map(|axis| q[0].mul_add(axis[0], q[1].mul_add(axis[1], q[2] * axis[2])))
        };
        let (a, b) = (place(&self.ends[0]), place(&self.ends[1]));
        let (x, y) = (b[0] - a[0], b[1] - a[1]);
        // Where the chord, seen along the ray, comes closest.
        let length2 = x.mul_add(x, y * y).fast_max(f32x8::splat(f32::MIN_POSITIVE));
        let s = (-(a[0].mul_add(x, a[1] * y)) / length2).fast_max(f32x8::ZERO).fast_min(f32x8::ONE);
        let (px, py) = (s.mul_add(x, a[0]), s.mul_add(y, a[1]));
        let close = px.mul_add(px, py * py).simd_le(self.reach * self.reach);
        // The distances at which it could be entered.
        let ahead = (a[2].fast_max(b[2]) + self.reach).simd_ge(f32x8::ZERO);
        let before = (a[2].fast_min(b[2]) - self.reach).simd_le(f32x8::splat(limit));
        (close & ahead & before).to_bitmask()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec3, Vec4, Vec4Swizzles};
    use vellus_scene::Basis;

    fn noise(i: usize, k: u32) -> f32 {
        ((i as f32 * 12.9898 + k as f32 * 78.233).sin() * 43758.547).rem_euclid(1.0)
    }

    fn strands(basis: Basis, count: usize, points: usize) -> Strands {
        let mut all = Vec::new();
        for i in 0..count {
            let mut p = Vec3::new(noise(i, 1), noise(i, 2), noise(i, 3));
            let mut d = Vec3::new(noise(i, 4) - 0.5, noise(i, 5) - 0.5, noise(i, 6) - 0.5).normalize() * 0.05;
            for k in 0..points {
                all.push(Vec4::from((p, 0.004 * (1.0 - 0.5 * k as f32 / points as f32))));
                p += d;
                d += 0.01 * Vec3::new(noise(i, 7) - 0.5, noise(i, 8) - 0.5, noise(i, 9) - 0.5);
            }
        }
        let starts = (0..=count).map(|i| (i * points) as u32).collect();
        Strands {
            name: "test".to_owned(),
            basis,
            starts,
            points: all,
            moved: None,
            root_uv: None,
            look: 0,
            varying: vec![],
        }
    }

    /// The hierarchy finds what going through all segments finds; two sets, every basis.
    #[test]
    fn hierarchy_finds_the_first_of_all() {
        for basis in [Basis::Linear, Basis::BSpline, Basis::CatmullRom, Basis::Bezier] {
            let sets = vec![strands(basis, 150, 7), strands(Basis::Linear, 50, 4)];
            assert!(sets.iter().all(|s| s.validate().is_ok()));
            let curves = Curves::new(sets.clone());
            assert_eq!(curves.segments(), sets.iter().map(Strands::segments).sum::<usize>());
            let mut hits = 0;
            for i in 0..2000 {
                let target = Vec3::new(noise(i, 20), noise(i, 21), noise(i, 22));
                let origin = Vec3::new(noise(i, 23), noise(i, 24), noise(i, 25)) * 4.0 - 1.5;
                let ray = Ray::new(origin, (target - origin).normalize());
                let mut expected: Option<f32> = None;
                for set in &sets {
                    let step = if set.basis == Basis::Bezier { 3 } else { 1 };
                    let count = if set.basis == Basis::Linear { 2 } else { 4 };
                    for s in 0..set.len() {
                        let p = set.strand(s);
                        for k in 0..set.basis.segments(p.len()).unwrap() {
                            let segment = Segment::new(set.basis, &p[step * k..step * k + count]);
                            let limit = expected.unwrap_or(f32::INFINITY);
                            let entry = segment.intersect(&Ray { limit, ..ray });
                            expected = entry.map_or(expected, |e| Some(e.t));
                        }
                    }
                }
                let found = curves.intersect(&ray);
                hits += usize::from(found.is_some());
                assert_eq!(found.map(|h| h.entry.t), expected, "{basis:?} {i}");
                assert_eq!(curves.occluded(&ray), expected.is_some());
                if let Some(hit) = found {
                    let set = &curves.strands()[hit.set];
                    let range = set.starts[hit.strand] as usize..set.starts[hit.strand + 1] as usize;
                    assert!(range.contains(&hit.point));
                    let before = Ray { limit: hit.entry.t * 0.999, ..ray };
                    assert!(!curves.occluded(&before));
                    let axis = hit.segment.at(hit.entry.u);
                    assert!(ray.at(hit.entry.t).distance(axis.xyz()) < 1.1 * axis.w + 1e-5);
                }
            }
            assert!(hits > 100, "{basis:?}: {hits}");
        }
    }
}
