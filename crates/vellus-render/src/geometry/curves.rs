//! All strands of a scene, prepared for rays.
//!
//! A leaf of the hierarchy holds the chords of up to eight segments. SIMD tests all of them against the ray. The margin
//! of each test is the curve's deviation from its chord. Only the few segments that pass are intersected exactly.

use crate::geometry::bvh::{Bvh, EMPTY, NONE, WIDTH, join};
use crate::geometry::flat::Section;
use crate::geometry::memory;
use crate::geometry::ray::{Ray, orthonormal_basis};
use crate::geometry::segment::{Entry, Segment};
use glam::{Vec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;
use vellus_scene::{Basis, Strands};
use wide::{f32x8, u32x8};

/// Both ends of eight chords ([`Segment::chord`]). Missing ones are infinitely far away.
pub(crate) type Ends = [[f32x8; 3]; 2];

/// Chords of up to eight segments.
#[derive(Clone, Debug)]
pub(super) struct Block {
    /// When the shutter opens.
    ends: Ends,
    /// Two margins of each chord, and whether its ends have caps ([`pack`]).
    pub(super) margins: u32x8,
    /// The first control point of each segment, counted over all strands of the scene.
    pub(super) first: [u32; WIDTH],
}

/// Strands of hair and fur with a hierarchy over their segments. It finds where rays enter them.
///
/// Curves are not tessellated. Segments of cubic bases are round tubes of varying radius, with a ball at both ends of a
/// strand. Segments of the linear basis are round cones with balls at their ends.
#[derive(Clone, Debug)]
pub struct Curves {
    pub(super) strands: Vec<Strands>,
    /// The number of control points before each set of `strands`.
    pub(super) offsets: Vec<u32>,
    pub(super) blocks: Vec<Block>,
    /// The ends of the blocks' chords when the shutter closes, if anything moves.
    closed: Vec<Ends>,
    bvh: Bvh,
    segments: usize,
    /// The aspect ratio of the fibres of each set, if any is not round.
    pub(super) flat: Vec<f32>,
}

/// The largest error of an entry, from Newton's method and rounding, in radii.
const ROUNDING: f32 = 0.01;

/// Packs two margins of a chord into one number, each rounded up to 15 bits, and after each of them whether an end of
/// the segment has a cap. A margin may be read with that bit, which only makes it larger.
///
/// The first margin is the reach: the radius plus the deviation. The second margin is how far behind the ray's origin
/// the chord may be if the ray enters the segment ahead of its origin. A ray enters a surface against its normal, so
/// the axis is further along the ray than the entry. A taper inclines the normal, so the axis may be nearer by the
/// radius times the taper. The distance between chord and axis is at most the deviation.
fn pack(reach: f32, before: f32, caps: [bool; 2]) -> u32 {
    let upper = |x: f32, cap: bool| (x.to_bits() + 0x1_ffff) >> 17 << 1 | u32::from(cap);
    upper(reach, caps[0]) << 16 | upper(before, caps[1])
}

/// The bits of [`pack`] for the caps at the start and at the end.
const CAPS: [u32; 2] = [1 << 16, 1];

/// Where a ray enters a strand.
#[derive(Clone, Copy, Debug)]
pub struct CurveHit {
    /// Index of the set of strands in the scene.
    pub set: usize,
    /// Index of the strand in the set.
    pub strand: usize,
    /// Index of the first control point of the segment in the set.
    pub point: usize,
    /// Distance along the ray, and parameter along the segment.
    pub entry: Entry,
    /// The segment, at the time of the ray.
    pub segment: Segment,
    /// The section, unless it is a circle.
    pub section: Option<Section>,
    /// Index of the instance, if the strand is part of one.
    pub instance: Option<u32>,
}

impl Curves {
    /// Builds the hierarchy, on all cores.
    ///
    /// # Panics
    /// May panic if [`Strands::validate`] returns an error.
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
                    let step = if set.basis == Basis::Bezier { 3 } else { 1 };
                    let segments = set.basis.segments(set.strand(i).len()).unwrap_or(0) as u32;
                    (0..segments).map(move |k| offset + set.starts[i] + step * k)
                })
            })
            .collect();
        let mut curves = Curves {
            strands,
            offsets,
            blocks: Vec::new(),
            closed: Vec::new(),
            bvh: Bvh::build(0, |_| EMPTY).0,
            segments: first.len(),
            flat: Vec::new(),
        };
        let moves = curves.strands.iter().any(|set| set.moved.is_some());
        let (mut bvh, mut leaves) = Bvh::build(first.len(), |i| curves.segment(first[i], 0.5).1.bounds());
        leaves.par_iter_mut().flatten().filter(|p| **p != NONE).for_each(|p| *p = first[*p as usize]);
        drop(first);
        let mut blocks = memory::with_capacity(leaves.len());
        leaves.par_iter().map(|leaf| curves.block(leaf, moves)).collect_into_vec(&mut blocks);
        if moves {
            let bounds = |leaf: usize, time: f32| {
                let all = leaves[leaf].iter().filter(|&&first| first != NONE);
                all.map(|&first| curves.segment(first, time).1.bounds()).fold(EMPTY, join)
            };
            bvh.set_motion([&|leaf| bounds(leaf, 0.0), &|leaf| bounds(leaf, 1.0)]);
            curves.closed = leaves.par_iter().map(|leaf| curves.ends(leaf, 1.0)).collect();
        }
        (curves.blocks, curves.bvh) = (blocks, bvh);
        curves
    }

    fn ends(&self, first: &[u32; WIDTH], time: f32) -> Ends {
        let mut ends = [[[f32::INFINITY; WIDTH]; 3]; 2];
        for (lane, &first) in first.iter().enumerate().filter(|&(_, &first)| first != NONE) {
            let segment = self.segment(first, time).1;
            for (end, point) in segment.chord().into_iter().enumerate() {
                (0..3).for_each(|k| ends[end][k][lane] = point[k]);
            }
        }
        ends.map(|end| end.map(f32x8::new))
    }

    fn block(&self, first: &[u32; WIDTH], moves: bool) -> Block {
        Block { ends: self.ends(first, 0.0), margins: self.margins(first, moves), first: *first }
    }

    pub(super) fn margins(&self, first: &[u32; WIDTH], moves: bool) -> u32x8 {
        u32x8::new(first.map(|first| {
            if first == NONE {
                return 0;
            }
            let open = self.segment(first, 0.0).1;
            let (radius, caps) = (open.largest_radius(), self.caps(first, &open));
            if moves {
                // The tapers at opening and closing do not bound the taper between these times.
                let reach = radius + open.stray().max(self.segment(first, 1.0).1.stray());
                return pack(reach, reach, caps);
            }
            let stray = open.deviation();
            if self.aspect_ratio(first).is_some() {
                // The entry into an ellipse may lie behind the point of the ray next to the axis.
                return pack(radius + stray, radius + stray, caps);
            }
            pack(radius + stray, radius * (open.taper() + ROUNDING).min(1.0) + stray, caps)
        }))
    }

    /// Which ends of a segment close its strand with a ball. Linear segments have their own, and points need none.
    fn caps(&self, first: u32, segment: &Segment) -> [bool; 2] {
        let (set, points) = self.points(first);
        let starts = &self.strands[set].starts;
        let point = first - self.offsets[set];
        let strand = strand_of(starts, point);
        let is_end = [point == starts[strand], point + points.len() as u32 == starts[strand + 1]];
        let radii = [segment.points[0].w, segment.points[3].w];
        [0, 1].map(|end| !segment.linear && is_end[end] && radii[end] > 0.0)
    }

    /// Where a ray enters a segment, or the cap at its end. `margins` are those of its chord.
    #[inline]
    fn enter(&self, first: u32, margins: u32, ray: &Ray) -> Option<Entry> {
        let caps = CAPS.map(|bit| margins & bit != 0);
        let (set, segment) = self.segment(first, ray.time);
        if !self.flat.is_empty() && self.flat[set] < 1.0 {
            return self.enter_flat(first, &segment, caps, ray);
        }
        segment.intersect_capped(ray, caps)
    }

    /// The set and the segment that start at a control point.
    #[inline]
    fn segment(&self, first: u32, time: f32) -> (usize, Segment) {
        let (set, points) = self.points(first);
        let basis = self.strands[set].basis;
        let Some(moved) = &self.strands[set].moved else { return (set, Segment::new(basis, points)) };
        let start = (first - self.offsets[set]) as usize;
        let mut now = [Vec4::ZERO; 4];
        for (k, point) in points.iter().enumerate() {
            now[k] = point.xyz().lerp(moved[start + k], time).extend(point.w);
        }
        (set, Segment::new(basis, &now[..points.len()]))
    }

    /// The set and the control points of the segment that starts at a control point.
    #[inline]
    pub(super) fn points(&self, first: u32) -> (usize, &[Vec4]) {
        let set = self.offsets.partition_point(|&offset| offset <= first) - 1;
        let strands = &self.strands[set];
        let point = (first - self.offsets[set]) as usize;
        let count = if strands.basis == Basis::Linear { 2 } else { 4 };
        (set, &strands.points[point..point + count])
    }

    /// The strands, in the scene's order.
    pub fn strands(&self) -> &[Strands] {
        &self.strands
    }

    /// The chords of each leaf when the shutter opens and when it closes, their margins and first control points.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = ([&Ends; 2], u32x8, [u32; WIDTH])> {
        self.blocks
            .iter()
            .enumerate()
            .map(|(i, block)| ([&block.ends, self.closed.get(i).unwrap_or(&block.ends)], block.margins, block.first))
    }

    /// The hierarchy.
    pub(crate) fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// The parameters that vary over a set of strands, to replace them. The hierarchy does not depend on them.
    pub(crate) fn varying_mut(&mut self, set: usize) -> &mut Vec<(vellus::Parameter, vellus_scene::Values<[f32; 3]>)> {
        &mut self.strands[set].varying
    }

    /// Number of segments.
    pub fn segments(&self) -> usize {
        self.segments
    }

    /// Bytes in memory: control points and hierarchy.
    pub fn bytes(&self) -> usize {
        let moved = |s: &Strands| s.moved.as_ref().map_or(0, |moved| size_of_val(&moved[..]));
        let strands = |s: &Strands| size_of_val(&s.points[..]) + size_of_val(&s.starts[..]) + moved(s);
        self.strands.iter().map(strands).sum::<usize>()
            + size_of_val(&self.blocks[..])
            + size_of_val(&self.closed[..])
            + self.bvh.bytes()
    }

    /// The nearest point at which a ray enters a strand from outside.
    pub fn intersect(&self, ray: &Ray) -> Option<CurveHit> {
        let mut best: Option<(u32, Entry)> = None;
        let enter = |first: u32, margins: u32, ray: &mut Ray, best: &mut Option<(u32, Entry)>| {
            if let Some(entry) = self.enter(first, margins, ray) {
                ray.t_max = entry.t;
                *best = Some((first, entry));
            }
            true
        };
        let frame = RayFrame::new(ray);
        let mut ray = *ray;
        let mut waiting = Waiting::default();
        self.bvh.traverse(
            &ray.clone(),
            |leaf| memory::fetch(&self.blocks[leaf as usize]),
            |leaf, t_max| {
                ray.t_max = t_max;
                let came = self.near(leaf, &frame, t_max);
                std::mem::replace(&mut waiting, came).all(|first, margins| enter(first, margins, &mut ray, &mut best));
                ray.t_max
            },
        );
        waiting.all(|first, margins| enter(first, margins, &mut ray, &mut best));
        best.map(|(first, entry)| {
            let (set, segment) = self.segment(first, ray.time);
            let point = first - self.offsets[set];
            let strand = strand_of(&self.strands[set].starts, point);
            let section = if self.flat.is_empty() { None } else { self.section(first, &segment, entry.u) };
            CurveHit { set, strand, point: point as usize, entry, segment, section, instance: None }
        })
    }

    /// A sphere around the control points: its centre and radius. `None` without strands.
    pub(crate) fn sphere(&self) -> Option<(Vec3, f32)> {
        let points = self.strands.iter().flat_map(|set| &set.points).map(|point| point.truncate());
        let (low, high) = points.fold(EMPTY, |bounds, p| join(bounds, (p, p)));
        (low.x <= high.x).then(|| (0.5 * (low + high), (0.5 * (high - low).length()).max(f32::MIN_POSITIVE)))
    }

    /// The motion of the fibre's axis at a hit while the shutter is open.
    pub fn movement(&self, hit: &CurveHit) -> Vec3 {
        let first = self.offsets[hit.set] + hit.point as u32;
        let [open, closed] = [0.0, 1.0].map(|time| self.segment(first, time).1.at(hit.entry.u).xyz());
        closed - open
    }

    /// Whether anything moves.
    pub fn moves(&self) -> bool {
        !self.closed.is_empty()
    }

    /// Whether a ray enters a strand within the ray's length.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.occluded_by(ray, |_| true)
    }

    /// As [`Curves::occluded`], for the sets of strands that `casts` accepts.
    pub fn occluded_by(&self, ray: &Ray, casts: impl Fn(usize) -> bool) -> bool {
        let frame = RayFrame::new(ray);
        let mut waiting = Waiting::default();
        let clear = |waiting: Waiting<'_>| {
            waiting.all(|first, margins| !casts(self.points(first).0) || self.enter(first, margins, ray).is_none())
        };
        let mut found = false;
        self.bvh.traverse(
            ray,
            |leaf| memory::fetch(&self.blocks[leaf as usize]),
            |leaf, t_max| {
                let came = self.near(leaf, &frame, t_max);
                found = !clear(std::mem::replace(&mut waiting, came));
                if found { -1.0 } else { t_max }
            },
        );
        found || !clear(waiting)
    }

    /// The segments of a leaf near the ray. Their control points are being prefetched.
    #[inline(always)]
    fn near(&self, leaf: u32, frame: &RayFrame, t_max: f32) -> Waiting<'_> {
        let block = &self.blocks[leaf as usize];
        let mask = match self.closed.get(leaf as usize) {
            Some(closed) => block.near(frame, t_max, &between(&block.ends, closed, frame.time)),
            None => block.near(frame, t_max, &block.ends),
        };
        let waiting = Waiting { first: &block.first, margins: block.margins.as_array(), mask };
        waiting.all(|first, _| {
            let (_, points) = self.points(first);
            memory::fetch(&points[0]);
            memory::fetch(&points[points.len() - 1]);
            true
        });
        waiting
    }
}

/// The strand of a control point. `starts` is the first control point of each strand. The search starts at the strand
/// that is correct if all strands have the same number of points, as in most grooms. A binary search would wait for
/// memory at each step.
pub(super) fn strand_of(starts: &[u32], point: u32) -> usize {
    let strands = starts.len() - 1;
    let guess = (u64::from(point) * strands as u64 / u64::from(starts[strands]).max(1)) as usize;
    let (mut low, mut high) = (guess.min(strands), (guess + 1).min(strands));
    let mut reach = 1;
    while starts[low] > point {
        (high, low) = (low, low.saturating_sub(reach));
        reach *= 2;
    }
    while starts[high] <= point {
        (low, high) = (high, (high + reach).min(strands));
        reach *= 2;
    }
    low + starts[low..=high].partition_point(|&start| start <= point) - 1
}

/// Segments of a leaf that must be intersected. They wait until the next leaf has been tested, while their control
/// points are prefetched.
#[derive(Clone, Copy, Default)]
struct Waiting<'a> {
    first: &'a [u32],
    margins: &'a [u32],
    mask: u32,
}

impl Waiting<'_> {
    /// Visits the segments until `visit` returns false. Returns whether it visited all.
    #[inline(always)]
    fn all(self, mut visit: impl FnMut(u32, u32) -> bool) -> bool {
        let mut mask = self.mask;
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize;
            if !visit(self.first[lane], self.margins[lane]) {
                return false;
            }
            mask &= mask - 1;
        }
        true
    }
}

/// The ends of the chords at the given time.
fn between(open: &Ends, closed: &Ends, time: f32) -> Ends {
    let (early, late) = (f32x8::splat(1.0 - time), f32x8::splat(time));
    std::array::from_fn(|end| std::array::from_fn(|k| open[end][k].mul_add(early, closed[end][k] * late)))
}

/// A ray's origin and time, and a frame whose third axis is the ray.
struct RayFrame {
    time: f32,
    origin: [f32x8; 3],
    axes: [[f32x8; 3]; 3],
}

impl RayFrame {
    #[inline]
    fn new(ray: &Ray) -> Self {
        let (u, v) = orthonormal_basis(ray.direction);
        let lanes = |v: glam::Vec3| v.to_array().map(f32x8::splat);
        RayFrame { time: ray.time, origin: lanes(ray.origin), axes: [lanes(u), lanes(v), lanes(ray.direction)] }
    }
}

impl Block {
    /// A bit mask of the lanes whose chord is within reach of the ray between its origin and `t_max`.
    #[inline(always)]
    fn near(&self, frame: &RayFrame, t_max: f32, ends: &Ends) -> u32 {
        let place = |end: &[f32x8; 3]| -> [f32x8; 3] {
            let q: [f32x8; 3] = [end[0] - frame.origin[0], end[1] - frame.origin[1], end[2] - frame.origin[2]];
            frame.axes.map(|axis| q[0].mul_add(axis[0], q[1].mul_add(axis[1], q[2] * axis[2])))
        };
        let (a, b) = (place(&ends[0]), place(&ends[1]));
        let (x, y) = (b[0] - a[0], b[1] - a[1]);
        let reach: f32x8 = bytemuck::cast(self.margins & u32x8::splat(0xffff_0000));
        let back: f32x8 = bytemuck::cast(self.margins << 16u32);
        // In the plane perpendicular to the ray: the point of the chord closest to the ray, and the length of chord
        // within reach on both sides of it.
        let inverse = f32x8::ONE / x.mul_add(x, y * y).fast_max(f32x8::splat(f32::MIN_POSITIVE));
        let s = (-(a[0].mul_add(x, a[1] * y)) * inverse).fast_max(f32x8::ZERO).fast_min(f32x8::ONE);
        let (px, py) = (s.mul_add(x, a[0]), s.mul_add(y, a[1]));
        let room = reach.mul_sub(reach, px.mul_add(px, py * py));
        let close = room.simd_ge(f32x8::ZERO);
        if close.none() {
            return 0;
        }
        let around = (room.fast_max(f32x8::ZERO) * inverse).sqrt();
        let (from, to) = ((s - around).fast_max(f32x8::ZERO), (s + around).fast_min(f32x8::ONE));
        // The range of distances along the ray of this piece of the chord.
        let rise = b[2] - a[2];
        let (near, far) = (from.mul_add(rise, a[2]), to.mul_add(rise, a[2]));
        let ahead = (near.fast_max(far) + back).simd_ge(f32x8::ZERO);
        let before = (near.fast_min(far) - reach).simd_le(f32x8::splat(t_max));
        (close & ahead & before).to_bitmask()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec3, Vec4, Vec4Swizzles};

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
            normals: None,
            root_uv: None,
            look: 0,
            varying: vec![],
        }
    }

    /// Tests every point of strands with equal lengths, different lengths and no points.
    #[test]
    fn points_belong_to_their_strands() {
        let lengths: [fn(usize) -> u32; 4] =
            [|_| 7, |i| 1 + (i as u32 * 7919) % 40, |i| (i as u32 % 3) * 5, |i| 1 << (i / 8)];
        for length in lengths {
            let mut starts = vec![0];
            let mut owner = Vec::new();
            for i in 0..100 {
                owner.extend((0..length(i)).map(|_| i));
                starts.push(owner.len() as u32);
            }
            for (point, &strand) in owner.iter().enumerate() {
                assert_eq!(strand_of(&starts, point as u32), strand);
            }
        }
    }

    /// The first entry of a ray into any segment, by a loop over all segments.
    fn first_of_all(sets: &[Strands], ray: &Ray) -> Option<f32> {
        let mut ray = *ray;
        let mut first = None;
        for set in sets {
            let step = if set.basis == Basis::Bezier { 3 } else { 1 };
            let count = if set.basis == Basis::Linear { 2 } else { 4 };
            for p in (0..set.len()).map(|s| set.strand(s)) {
                let segments = set.basis.segments(p.len()).unwrap();
                for k in 0..segments {
                    let segment = Segment::new(set.basis, &p[step * k..step * k + count]);
                    let caps = [k == 0, k + 1 == segments].map(|is_end| is_end && !segment.linear);
                    if let Some(entry) = segment.intersect_capped(&ray, caps) {
                        (ray.t_max, first) = (entry.t, Some(entry.t));
                    }
                }
            }
        }
        first
    }

    /// The hierarchy finds the same entries as a loop over all segments. There are three sets, every basis, radii that
    /// change little and much, and rays from far away and from the strands themselves.
    #[test]
    fn hierarchy_finds_the_first_of_all() {
        for basis in [Basis::Linear, Basis::BSpline, Basis::CatmullRom, Basis::Bezier] {
            let mut rough = strands(basis, 60, 7);
            rough.points.iter_mut().enumerate().for_each(|(i, p)| p.w = 0.001 + 0.03 * noise(i, 31));
            let sets = vec![strands(basis, 150, 7), strands(Basis::Linear, 50, 4), rough];
            assert!(sets.iter().all(|s| s.validate().is_ok()));
            let curves = Curves::new(sets.clone());
            assert_eq!(curves.segments(), sets.iter().map(Strands::segments).sum::<usize>());
            let (mut hits, mut further) = (0, 0);
            for i in 0..2000 {
                let target = Vec3::new(noise(i, 20), noise(i, 21), noise(i, 22));
                let origin = Vec3::new(noise(i, 23), noise(i, 24), noise(i, 25)) * 4.0 - 1.5;
                let ray = Ray::new(origin, (target - origin).normalize());
                let expected = first_of_all(&sets, &ray);
                let found = curves.intersect(&ray);
                assert_eq!(found.map(|h| h.entry.t), expected, "{basis:?} {i}");
                assert_eq!(curves.occluded(&ray), expected.is_some());
                let Some(hit) = found else { continue };
                hits += 1;
                let set = &curves.strands()[hit.set];
                let range = set.starts[hit.strand] as usize..set.starts[hit.strand + 1] as usize;
                assert!(range.contains(&hit.point));
                let before = Ray { t_max: hit.entry.t * 0.999, ..ray };
                assert!(!curves.occluded(&before));
                let axis = hit.segment.at(hit.entry.u);
                if hit.set != 2 {
                    assert!(ray.at(hit.entry.t).distance(axis.xyz()) < 1.1 * axis.w + 1e-5);
                }
                for k in 0..10 {
                    let direction = Vec3::new(noise(i, 40 + k), noise(i, 60 + k), noise(i, 80 + k)) * 2.0 - 1.0;
                    let out = ray.at(hit.entry.t) + 1e-3 * axis.w * direction.normalize();
                    let onward = Ray::new(out, direction.normalize());
                    let expected = first_of_all(&sets, &onward);
                    assert_eq!(curves.intersect(&onward).map(|h| h.entry.t), expected, "{basis:?} {i} {k}");
                    further += usize::from(expected.is_some());
                }
            }
            assert!(hits > 50 && further > 500, "{basis:?}: {hits} {further}");
        }
    }

    /// At any time, moving strands are hit like static strands in the same place.
    #[test]
    fn moving_strands_are_hit_like_static_ones() {
        for basis in [Basis::Linear, Basis::BSpline, Basis::CatmullRom, Basis::Bezier] {
            let still = strands(basis, 80, 7);
            let way = |i: usize| 0.2 * Vec3::new(noise(i / 7, 11), noise(i, 12), noise(i / 3, 13));
            let moved: Vec<Vec3> = still.points.iter().enumerate().map(|(i, p)| p.xyz() + way(i)).collect();
            let moving = Curves::new(vec![still.clone(), Strands { moved: Some(moved.clone()), ..still.clone() }]);
            assert!(moving.moves());
            let mut hits = 0;
            for time in [0.0, 0.3, 1.0] {
                let mut now = still.clone();
                let points = now.points.iter_mut().zip(&moved);
                points.for_each(|(p, moved)| *p = p.xyz().lerp(*moved, time).extend(p.w));
                let now = Curves::new(vec![still.clone(), now]);
                for i in 0..400 {
                    let origin = Vec3::new(noise(i, 20), noise(i, 21), noise(i, 22)) * 3.0 - 1.0;
                    let target = Vec3::new(noise(i, 23), noise(i, 24), noise(i, 25));
                    let ray = Ray { time, ..Ray::new(origin, (target - origin).normalize()) };
                    let (found, expected) = (moving.intersect(&ray), now.intersect(&ray));
                    assert_eq!(found.map(|h| h.entry), expected.map(|h| h.entry), "{basis:?} {time} {i}");
                    assert_eq!(moving.occluded(&ray), expected.is_some());
                    hits += usize::from(found.is_some_and(|h| h.set == 1));
                }
            }
            assert!(hits > 50, "{basis:?}: {hits}");
        }
    }
}
