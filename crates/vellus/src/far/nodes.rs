//! Divides the width of a fibre into segments, and chooses sample points, for the integrals over a window.
//!
//! D9: the paper divides the offset h (h_i = √(i/n)). This module divides the angle γ_o. Φ_R is then exactly linear,
//! and the rise of F at the silhouette is spread out. Inside the medulla it divides asin h″ instead. The reason is that
//! A(h) has a kink at the edge of the medulla, from s_m = κ √(1 − h″²), but is smooth in asin h″. In both cases h = r
//! sin ψ, with r = 1 or the medulla's edge κη′.

use crate::simd::special;
use std::f32::consts::FRAC_PI_2;
use wide::f32x8;

/// The number of segments of a half window. Their eight ends fill a register.
pub(crate) const SEGMENTS: usize = 7;

/// The largest number of pieces of a window. Each is a chain of [`SEGMENTS`] on one side of the axis.
pub(crate) const PIECES: usize = 3;

/// A part of a window on one side of the axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    /// 0 if the offsets are ≥ 0, 1 if they are mirrored.
    pub side: usize,
    /// Offsets ≥ 0.
    pub range: [f32; 2],
    pub nodes: Nodes,
}

/// Divides the pieces of a window, which come first, until there are [`PIECES`] of them. A piece that contains the
/// medulla's edge is divided there. Otherwise the longest piece is divided in its middle. Lengths and middles are those
/// of γ.
#[inline(never)]
pub(crate) fn divide(pieces: &mut [Option<Piece>; PIECES], edges: [Option<f32>; 2]) {
    while let Some(free) = pieces.iter().position(Option::is_none) {
        let (mut longest, mut cut) = (-1.0, None);
        for (i, Piece { side, range: [low, high], .. }) in pieces.iter().flatten().enumerate() {
            let (middle, length) = match edges[*side] {
                // This length is larger than that of any piece.
                Some(edge) if *low < edge && edge < *high => (edge, FRAC_PI_2 + 1.0),
                _ => (high.asin().midpoint(low.asin()).sin(), high.asin() - low.asin()),
            };
            // A piece with very close ends cannot be divided.
            if length > longest && *low < middle && middle < *high {
                (longest, cut) = (length, Some((i, *side, [*low, middle, *high])));
            }
        }
        let Some((i, side, [low, middle, high])) = cut else { return };
        let piece =
            |low: f32, high: f32| Some(Piece { side, range: [low, high], nodes: Nodes::new(low, high, edges[side]) });
        pieces[i] = piece(low, middle);
        pieces[free] = piece(middle, high);
    }
}

/// ψ = π/2 · t(3 − t)/2 for t from 0 to 1. Nodes that are equidistant in t become denser toward the silhouette and
/// toward the medulla's edge: their distance falls to one half.
#[inline(always)]
fn angle(t: f32x8) -> f32x8 {
    t * (f32x8::splat(3.0) - t) * f32x8::splat(0.5 * FRAC_PI_2)
}

/// dψ/dt.
#[inline(always)]
fn slope(t: f32x8) -> f32x8 {
    (f32x8::splat(1.5) - t) * f32x8::splat(FRAC_PI_2)
}

/// The t in [0, 1] at which sin ψ(t) has the given value. Most ends are 0 or 1. They have a fast path, because later
/// work depends on the result.
#[inline(always)]
fn position(sin: f32) -> f32 {
    match sin {
        0.0 => 0.0,
        1.0.. => 1.0,
        _ => {
            let x = 2.0 / FRAC_PI_2 * sin.asin();
            x / (1.5 + (2.25 - x).max(0.0).sqrt())
        }
    }
}

/// A range of t on one side of the medulla's edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side {
    first: f32,
    last: f32,
    radius: f32,
}

impl Side {
    /// Whether it is at most 2° long, measured in asin h″ or γ.
    pub fn is_narrow(&self) -> bool {
        // ψ is at most ¾ π t.
        self.last - self.first < 0.015
    }

    /// The common part of two ranges that begin at the axis, and the part that only the longer one has.
    pub fn overlap(&self, other: &Side) -> (Side, Option<Side>) {
        let (short, long) = if self.last < other.last { (self, other) } else { (other, self) };
        (*short, (short.last < long.last).then_some(Side { first: short.last, ..*long }))
    }

    /// Whether this range is longer. Both ranges must begin at the axis.
    pub fn longer_than(&self, other: &Side) -> bool {
        self.last > other.last
    }

    /// Offsets h, and the width dh of each. `position` is relative to the range of ψ, in [0, 1], and `share` is the
    /// share of the range that a position represents.
    #[inline(always)]
    pub fn points(&self, position: f32x8, share: f32x8) -> (f32x8, f32x8) {
        let [first, last] = [self.first, self.last].map(|t| 0.5 * FRAC_PI_2 * t * (3.0 - t));
        let length = f32x8::splat(last - first);
        let (sin, cos) = special::sin_cos_quarter(length.mul_add(position, f32x8::splat(first)));
        let radius = f32x8::splat(self.radius);
        ((radius * sin).fast_min(f32x8::ONE), radius * cos.fast_max(f32x8::ZERO) * length * share)
    }
}

/// The division of a half window with offsets ≥ 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nodes {
    /// Offsets of the ends of the segments.
    pub ends: f32x8,
    /// Offsets of the two Gauss points of each segment. The eighth lane is unused.
    pub gauss: [f32x8; 2],
    /// dh of the Gauss points. Their sum is the width of the window. 0 in the eighth lane.
    pub weights: [f32x8; 2],
    /// The part of the window inside the medulla.
    pub medulla: Option<Side>,
}

/// h and dh/dt.
#[inline(always)]
fn offset(t: f32x8, radius: f32x8) -> (f32x8, f32x8) {
    let (sin, cos) = special::sin_cos_quarter(angle(t));
    ((radius * sin).fast_min(f32x8::ONE), radius * cos.fast_max(f32x8::ZERO) * slope(t))
}

impl Nodes {
    /// Divides [`low`, `high`] ⊂ [0, 1]. `medulla` is the offset h = κη′ of the medulla's edge, if there is a
    /// medulla. It may be beyond the silhouette.
    #[inline(always)]
    pub fn new(low: f32, high: f32, medulla: Option<f32>) -> Self {
        let edge = medulla.filter(|&edge| edge < 1.0);
        let radius = edge.unwrap_or(1.0);
        let (below, beyond) = (low < radius, edge.is_some() && high > radius);
        let outer =
            Side { first: position(if beyond { low.max(radius) } else { low }), last: position(high), radius: 1.0 };
        // The first node always belongs to this side.
        let inner =
            if below { Side { first: position(low / radius), last: position(high / radius), radius } } else { outer };
        // The number of segments on each side is proportional to its share of t. There are at least two inside, where ψ
        // may cover the whole quarter circle, and at least one outside.
        let count = match (below, beyond) {
            (true, true) => {
                let start = position(low);
                let share = (outer.first - start) / (outer.last - start).max(f32::MIN_POSITIVE);
                ((share * SEGMENTS as f32).round() as usize).clamp(2, SEGMENTS - 1)
            }
            (true, false) => SEGMENTS,
            (false, _) => 0,
        };
        let splat = f32x8::splat;
        let split = splat(count as f32);
        let index = f32x8::new([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let step_in = (inner.last - inner.first) / (count as f32).max(1.0);
        let step_out = (outer.last - outer.first) / ((SEGMENTS - count) as f32).max(1.0);
        let at = |x: f32x8, within: f32x8| {
            let t = within
                .select(splat(inner.first) + x * splat(step_in), splat(outer.first) + (x - split) * splat(step_out));
            let (h, rate) = offset(t, within.select(splat(inner.radius), splat(outer.radius)));
            (h, rate * within.select(splat(step_in), splat(step_out)))
        };
        let within = index.simd_lt(split);
        let (ends, _) = at(index, index.simd_le(split));
        // Two-point Gauss–Legendre: at ½ ± 1/(2√3) of the segment, with half the weight each.
        let live = index.simd_lt(splat(SEGMENTS as f32)).select(splat(0.5), f32x8::ZERO);
        let [(first, rate_first), (last, rate_last)] =
            [0.211_324_87f32, 0.788_675_1].map(|x| at(index + splat(x), within));
        Nodes {
            ends,
            gauss: [first, last],
            weights: [rate_first * live, rate_last * live],
            medulla: (medulla.is_some() && below).then_some(inner),
        }
    }

    /// The width of the window, as the sum of the weights. Averages divide by this sum.
    pub fn width(&self) -> f32 {
        (self.weights[0] + self.weights[1]).reduce_add()
    }
}
