//! The course of a strand between guides.

use super::{Bound, Interpolation};
use glam::{Vec3, Vec4};
use rayon::prelude::*;
use vellus_scene::Strands;

/// A strand that is about to vanish between guides that diverge gets at most this much longer.
const LONGER: f32 = 1.5;

/// Exponent of the pull to a guide, over the length.
const POWER: f32 = 1.5;

/// Guides, divided into a smooth course and the rest, which has waves and curls.
pub(super) struct Shapes<'a> {
    guides: &'a Strands,
    roots: Vec<Vec3>,
    /// The smooth course of each guide relative to its root: t and t² times these, t in [0, 1].
    smooth: Vec<[Vec3; 2]>,
}

/// The position of control point `k` of `count` on a strand.
fn position(k: usize, count: usize) -> f32 {
    k as f32 / (count.max(2) - 1) as f32
}

/// Two of `count` values along a strand and how far the position `t` is from the first to the second.
fn between(t: f32, count: usize) -> (usize, usize, f32) {
    let x = t * (count - 1) as f32;
    let k = (x as usize).min(count - 1);
    (k, (k + 1).min(count - 1), x - k as f32)
}

/// The values of a new strand at its control points.
pub(super) fn along(guides: &Strands, values: &[[f32; 3]], bound: &Bound) -> Vec<[f32; 3]> {
    let count = guides.strand(bound.guides[0] as usize).len();
    let mixed = |k: usize| {
        [0, 1, 2].map(|c| {
            bound.weighted(|i| {
                let range = guides.starts[i as usize] as usize..guides.starts[i as usize + 1] as usize;
                let own = &values[range];
                let (a, b, s) = between(position(k, count), own.len());
                own[a][c] + s * (own[b][c] - own[a][c])
            })
        })
    };
    (0..count).map(mixed).collect()
}

impl<'a> Shapes<'a> {
    pub fn new(guides: &'a Strands, roots: Vec<Vec3>) -> Self {
        let smooth = (0..guides.len()).into_par_iter().map(|i| smooth(guides.strand(i), roots[i])).collect();
        Shapes { guides, roots, smooth }
    }

    /// The control points of a new strand. It has as many as its nearest guide.
    pub fn strand(&self, bound: &Bound, settings: Interpolation) -> Vec<Vec4> {
        let nearest = bound.guides[0] as usize;
        let own = self.guides.strand(nearest);
        let root = bound.at(&self.roots);
        let mixed =
            |k: usize| bound.guides.iter().zip(bound.weights).map(|(&i, w)| w * self.smooth[i as usize][k]).sum();
        let [a, b]: [Vec3; 2] = [mixed(0), mixed(1)];
        let chord = bound.weighted(|i| (self.smooth[i as usize][0] + self.smooth[i as usize][1]).length());
        let longer = (chord / (a + b).length().max(f32::MIN_POSITIVE)).clamp(1.0, LONGER);
        let length = 1.0 + settings.length_variation * (2.0 * bound.random - 1.0);
        // Strengths vary, because all tips would meet in one point otherwise.
        let clump = settings.clump.powf(0.5 + bound.random);
        let point = |(k, p): (usize, &Vec4)| {
            let t = position(k, own.len());
            let rest = p.truncate() - self.roots[nearest] - at(self.smooth[nearest], t);
            let free = root + length * (longer * at([a, b], t) + rest);
            let pulled = free.lerp(self.roots[nearest].lerp(p.truncate(), length), clump * t.powf(POWER));
            let radius = bound.weighted(|i| {
                let other = self.guides.strand(i as usize);
                let (a, b, s) = between(t, other.len());
                other[a].w + s * (other[b].w - other[a].w)
            });
            pulled.extend(radius)
        };
        own.iter().enumerate().map(point).collect()
    }
}

/// A smooth course at `t`.
fn at([a, b]: [Vec3; 2], t: f32) -> Vec3 {
    t * a + t * t * b
}

/// The parabola from the root that fits the control points best.
fn smooth(points: &[Vec4], root: Vec3) -> [Vec3; 2] {
    let mut sums = [0.0f32; 3];
    let mut sides = [Vec3::ZERO; 2];
    for (k, p) in points.iter().enumerate() {
        let t = position(k, points.len());
        let d = p.truncate() - root;
        sums = [sums[0] + t * t, sums[1] + t * t * t, sums[2] + t * t * t * t];
        sides = [sides[0] + t * d, sides[1] + t * t * d];
    }
    let [tt, ttt, tttt] = sums;
    let whole = tt * tttt - ttt * ttt;
    if whole < 1e-6 {
        // Two points: a straight line.
        return [sides[0] / tt.max(f32::MIN_POSITIVE), Vec3::ZERO];
    }
    [(tttt * sides[0] - ttt * sides[1]) / whole, (tt * sides[1] - ttt * sides[0]) / whole]
}
