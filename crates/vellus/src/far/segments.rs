//! R, TT, TRT of one half of the fibre's width (offsets ≥ 0), integrated by segments (Yan17 Sec. 5.1).
//!
//! The light of a segment leaves over a range of azimuths, and the lobe's Gaussian spreads it further. This module
//! approximates the density over that range as linear, with the energy and the mean azimuth of the segment (two-point
//! Gauss–Legendre in the angle). The linear density also represents the curvature of Φ along the segment. The paper's
//! linear Φ and linear factors of A(h) do not. The mean is that of the largest channel. All channels of a segment have
//! the same distribution, so the weight of a sample depends only on its segment.

use crate::choose::choose;
use crate::cylinder::azimuthal::wrap;
use crate::cylinder::frame::Polar;
use crate::cylinder::path::Route;
use crate::exit::Entry;
use crate::far::gaussian_spans::{Bells, Chain};
use crate::far::nodes::Nodes;
use crate::lobe::{Component, DIFFUSE};
use crate::medulla::{MeanPaths, Pass};
use crate::prepared::Prepared;
use crate::simd::lanes::{Lanes, Quad};
use crate::simd::special;
use std::f32::consts::{PI, TAU};
use wide::{f32x4, f32x8};

/// RGB and the largest channel, which sampling uses, eight of each.
pub(crate) type Channels = [f32x8; 4];

/// The table for the τ of the hit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Through {
    pub pass: Pass,
    pub mean_paths: MeanPaths,
    /// The exit of scattered light, if the cuticle reflects it.
    pub entry: Option<Entry<f32x8>>,
    /// [`crate::medulla::Inclination::leaving`].
    pub leaving: [f32; 2],
}

/// Energy over σ, and the distance of its mean from the middle in standard deviations, of eight spans of azimuth.
#[derive(Clone, Copy, Debug)]
struct Spans {
    energy: Channels,
    mean: f32x8,
}

impl Spans {
    const NONE: Spans = Spans { energy: [f32x8::ZERO; 4], mean: f32x8::ZERO };

    /// The light of the spans, energy · max(J₀ + mean · J₁, 0) in each channel.
    #[inline(always)]
    fn light(&self, [j0, j1]: [f32x8; 2]) -> Channels {
        // Far from a span both terms are rounding errors of either sign. A negative density would reduce the pdf of
        // other spans, but not their light in a channel. The weight of a sample would then have no bound.
        let density = self.mean.mul_add(j1, j0).max(f32x8::ZERO);
        self.energy.map(|energy| energy * density)
    }
}

/// How the Gaussian of a lobe spreads its spans.
#[derive(Clone, Copy, Debug)]
enum Spread {
    /// Exact integrals over seven segments.
    Chain(Chain),
    /// Gaussians instead of spans, for a wide lobe.
    Bells(Bells),
    /// TRT shares the bells of TT. Pairs of segments of TT are in the lower four lanes, those of TRT in the upper four.
    WithTt,
}

impl Spread {
    /// Middle and half length of a span, in standard deviations.
    fn span(&self, lane: usize) -> [f32; 2] {
        match self {
            Spread::Chain(chain) => chain.span(lane),
            Spread::Bells(bells) => bells.span(lane),
            Spread::WithTt => [0.0; 2],
        }
    }

    /// The largest distance from the lobe's centre with a result other than 0, in standard deviations.
    fn reach(&self) -> f32 {
        match self {
            Spread::Chain(chain) => chain.reach(),
            Spread::Bells(bells) => bells.reach(),
            Spread::WithTt => 0.0,
        }
    }
}

/// The spans of one lobe.
#[derive(Clone, Copy, Debug)]
struct Lobe {
    spread: Spread,
    spans: Spans,
    /// The number of turns of the circle, in either direction, from which its tails contribute.
    turns: i32,
}

impl Lobe {
    const NONE: Lobe = Lobe { spread: Spread::Chain(Chain::NONE), spans: Spans::NONE, turns: 0 };

    /// Combines pairs of segments of TT and TRT into bells, if both lobes are wide enough. `shares` and `points` are
    /// the energies and positions of the Gauss points. The mean and variance of a span are those of the channel that
    /// sampling uses.
    #[inline(always)]
    fn pack(&mut self, shares: &impl Fn(usize, usize) -> [f32x8; 2], points: &[[f32x8; 2]; 3]) -> bool {
        let (tt, trt) = (&points[1], &points[2]);
        let energies = |c: usize| {
            let (a, b) = (shares(1, c), shares(2, c));
            pairs(a[0] + a[1], b[0] + b[1])
        };
        let (a, b) = (shares(1, 3), shares(2, 3));
        let inverse = f32x8::ONE / energies(3).fast_max(f32x8::splat(f32::MIN_POSITIVE));
        let middle = pairs(a[0] * tt[0] + a[1] * tt[1], b[0] * trt[0] + b[1] * trt[1]) * inverse;
        let second =
            pairs(a[0] * tt[0] * tt[0] + a[1] * tt[1] * tt[1], b[0] * trt[0] * trt[0] + b[1] * trt[1] * trt[1]);
        let variance = (second * inverse - middle * middle).fast_max(f32x8::ZERO);
        if !Bells::suit(variance) {
            return false;
        }
        self.spans = Spans { energy: [0, 1, 2, 3].map(energies), mean: f32x8::ZERO };
        self.spread = Spread::Bells(Bells::new(middle, variance));
        true
    }
}

/// R, TT, TRT of one half of a window.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Half {
    /// The azimuths from which R, TT, TRT are measured, in the first three lanes.
    centres: f32x8,
    lobes: [Lobe; 3],
    /// φ is multiplied by the first `count` of these signs: + for the offsets ≥ 0, − for those ≤ 0, which are
    /// mirrored, (h, φ) → (−h, −φ).
    signs: [f32; 2],
    count: usize,
}

/// Sums over the lanes.
#[inline(always)]
pub(crate) fn sum(channels: Channels) -> f32x4 {
    let mut folded = [f32x4::ZERO; 4];
    for c in 0..4 {
        let x = channels[c].to_array();
        folded[c] = f32x4::new([x[0], x[1], x[2], x[3]]) + f32x4::new([x[4], x[5], x[6], x[7]]);
    }
    across(folded)
}

/// Sums over the lower and the upper four lanes.
#[inline(always)]
fn halves(channels: Channels) -> [f32x4; 2] {
    let (mut low, mut high) = ([f32x4::ZERO; 4], [f32x4::ZERO; 4]);
    for c in 0..4 {
        let x = channels[c].to_array();
        low[c] = f32x4::new([x[0], x[1], x[2], x[3]]);
        high[c] = f32x4::new([x[4], x[5], x[6], x[7]]);
    }
    [across(low), across(high)]
}

/// Sums over the lanes of each channel.
#[inline(always)]
fn across(channels: [f32x4; 4]) -> f32x4 {
    let [a, b, c, d] = f32x4::transpose(channels);
    (a + b) + (c + d)
}

/// A(h) of a register of paths. The spare channel gets the maximum of RGB. Sampling of lobes and offsets uses it.
#[inline(always)]
pub(crate) fn attenuation(
    prepared: &Prepared,
    route: &impl Route<f32x8>,
    through: Option<&Through>,
) -> [Channels; Component::COUNT] {
    let entry = through.and_then(|through| through.entry.as_ref());
    let mean_paths = match through {
        Some(through) if entry.is_none() => prepared.medulla.mean_paths_at(&through.mean_paths, route.path().gamma_m),
        _ => f32x8::ZERO,
    };
    let a = route.attenuation(&prepared.in_air, mean_paths, entry);
    let mut out = [[f32x8::ZERO; 4]; Component::COUNT];
    for p in 0..Component::COUNT {
        let [r, g, b, _] = a[p].array();
        out[p] = [r, g, b, r.fast_max(g).fast_max(b)];
    }
    out
}

/// Sums of neighbouring lanes: of `a` in the lower lanes, of `b` in the upper.
#[inline(always)]
fn pairs(a: f32x8, b: f32x8) -> f32x8 {
    let (a, b) = (a.to_array(), b.to_array());
    f32x8::new([a[0], a[2], a[4], a[6], b[0], b[2], b[4], b[6]])
        + f32x8::new([a[1], a[3], a[5], a[7], b[1], b[3], b[5], b[7]])
}

/// Shortens the first and the last segment of a chain, so that a linear density over them can have the mean of their
/// light. Near η = 1 the azimuth changes very fast in the last segment, and most of its range has hardly any light.
fn shorten(ends: f32x8, shares: [f32x8; 2], points: &[f32x8; 2]) -> f32x8 {
    let energy = (shares[0] + shares[1]).fast_max(f32x8::splat(f32::MIN_POSITIVE));
    let means = ((shares[0] * points[0] + shares[1] * points[1]) / energy).to_array();
    let mut ends = ends.to_array();
    // Distances from the node next to the end: to the mean, and to the end. A linear density that falls to 0 at the end
    // has its mean at a third.
    for (node, end, mean) in [(6, 7, means[6]), (1, 0, means[0])] {
        let (to_mean, to_end) = (mean - ends[node], ends[end] - ends[node]);
        if to_mean * to_end > 0.0 && 3.0 * to_mean.abs() < to_end.abs() {
            ends[end] = ends[node] + 3.0 * to_mean;
        }
    }
    f32x8::new(ends)
}

impl Half {
    /// An empty half.
    pub const NONE: Half = Half { centres: f32x8::ZERO, lobes: [Lobe::NONE; 3], signs: [0.0; 2], count: 0 };

    /// Prepares it in place, because it is large. Returns the energies of the components, RGB and the largest channel,
    /// and the sums of cos φ and sin φ over the offsets ≥ 0 of light that leaves late: D20, where it stays on the side
    /// on which it entered. `toward`: the cosine and the sine of the azimuth of ω_o, mirrored if the offsets are.
    /// `scale` is 1 over the width of the whole window.
    #[inline(always)]
    pub fn prepare<R: Route<f32x8>>(
        &mut self,
        prepared: &Prepared,
        (polar, toward): (Polar<f32>, [f32; 2]),
        through: Option<&Through>,
        nodes: &Nodes,
        signs: &[f32],
        scale: f32,
    ) -> ([f32x4; Component::COUNT], [f32; 2]) {
        self.count = signs.len();
        self.signs[..signs.len()].copy_from_slice(signs);
        let splat = f32x8::splat;
        let [sin, cos] = [polar.sin, polar.cos].map(splat);
        let toward = toward.map(splat);
        let paths = nodes.gauss.map(|h| R::trace(prepared, [sin, cos], toward, h));
        let a = [attenuation(prepared, &paths[0], through), attenuation(prepared, &paths[1], through)];
        let weights = nodes.weights.map(|w| w * splat(scale));
        let mut energy = [f32x4::ZERO; Component::COUNT];
        for p in 0..Component::COUNT {
            let mut shares = [f32x8::ZERO; 4];
            for c in 0..4 {
                shares[c] = weights[0] * a[0][p][c] + weights[1] * a[1][p][c];
            }
            energy[p] = sum(shares);
        }
        let mut late = [0.0; 2];
        if let Some(turning) = &prepared.turning {
            for k in 0..2 {
                let light = weights[k] * a[k][DIFFUSE][3];
                let entry = turning.all(cos, nodes.gauss[k], &paths[k]).0.later.a;
                (0..2).for_each(|i| late[i] -= (light * entry[i]).reduce_add());
            }
        }
        let at_ends = paths[0].exits_at(prepared, [sin, cos], toward, nodes.ends);
        // For each lobe, the ends and the Gauss points of its segments, in standard deviations from its centre.
        let (mut ends, mut points) = ([f32x8::ZERO; 3], [[f32x8::ZERO; 2]; 3]);
        let mut centres = [0.0; 8];
        for p in 0..3 {
            let inverse_sigma = splat(prepared.azimuthal.inverse_sigma[p]);
            let exit = at_ends[p];
            centres[p] = 0.5 * (exit.lane(0) + exit.lane(7));
            let origin = splat(centres[p]);
            ends[p] = (exit - origin) * inverse_sigma;
            points[p] = [0, 1].map(|k| (paths[k].exit_azimuth(p as u8) - origin) * inverse_sigma);
        }
        // Energy per radian at the Gauss points of lobe p in channel c.
        let shares = |p: usize, c: usize| {
            let scale = splat(prepared.azimuthal.inverse_sigma[p]);
            [0, 1].map(|k| weights[k] * a[k][p][c] * scale)
        };
        self.centres = f32x8::new(centres);
        let packed = self.lobes[1].pack(&shares, &points);
        for p in 0..if packed { 1 } else { 3 } {
            if prepared.fine {
                ends[p] = shorten(ends[p], shares(p, 3), &points[p]);
            }
            let chain = Chain::new(ends[p]);
            let lobe = &mut self.lobes[p];
            for c in 0..4 {
                let [first, last] = shares(p, c);
                lobe.spans.energy[c] = first + last;
            }
            let [first, last] = shares(p, 3);
            let moment = first * (points[p][0] - chain.middle()) + last * (points[p][1] - chain.middle());
            let limit = chain.mean_limit();
            let mean = moment / lobe.spans.energy[3].fast_max(splat(f32::MIN_POSITIVE));
            lobe.spans.mean = mean.fast_max(-limit).fast_min(limit);
            let variance = chain.variance();
            lobe.spread = if p == 0 && Bells::suit(variance) {
                Spread::Bells(Bells::new(chain.middle(), variance))
            } else {
                Spread::Chain(chain)
            };
        }
        if packed {
            self.lobes[2].spread = Spread::WithTt;
        }
        for (p, lobe) in self.lobes.iter_mut().enumerate() {
            // If TRT is combined with TT, TRT has the longer tails.
            let sigma = prepared.azimuthal.sigma[if p == 1 && packed { 2 } else { p }];
            lobe.turns = ((lobe.spread.reach() * sigma + PI) * (1.0 / TAU)) as i32;
        }
        (energy, late)
    }

    /// N(φ) of R, TT, TRT, densities per radian.
    #[inline(always)]
    pub fn eval(&self, phi: f32, inverse_sigma: &[f32; 3]) -> [f32x4; 3] {
        let mut n = [f32x4::ZERO; 3];
        let distances = self.signs.map(|sign| wrap(f32x8::splat(sign * phi) - self.centres).to_array());
        for (p, lobe) in self.lobes.iter().enumerate() {
            let mut integrals = [f32x8::ZERO; 2];
            for distance in &distances[..self.count] {
                for turn in -lobe.turns..=lobe.turns {
                    let at = |p: usize| (distance[p] + turn as f32 * TAU) * inverse_sigma[p];
                    let [j0, j1] = match &lobe.spread {
                        Spread::Chain(chain) if at(p).abs() < chain.reach() => chain.integrals(at(p)),
                        Spread::Bells(bells) if p == 0 && at(0).abs() < bells.reach() => {
                            bells.integrals(f32x8::splat(at(0)))
                        }
                        Spread::Bells(bells) if p == 1 && at(1).abs().min(at(2).abs()) < bells.reach() => {
                            let d = [at(1), at(2)];
                            bells.integrals(f32x8::new([d[0], d[0], d[0], d[0], d[1], d[1], d[1], d[1]]))
                        }
                        _ => continue,
                    };
                    integrals = [integrals[0] + j0, integrals[1] + j1];
                }
            }
            let light = lobe.spans.light(integrals);
            match lobe.spread {
                Spread::Bells(_) if p == 1 => [n[1], n[2]] = halves(light),
                Spread::WithTt => {}
                _ => n[p] = sum(light),
            }
        }
        // Negative rounding errors become 0.
        n.map(|n| n.max(f32x4::ZERO))
    }
}

/// Maps a uniform number to [−1, 1] with the density (1 + s x)/2, |s| ≤ 1.
fn sloping(s: f32, u: f32) -> f32 {
    let x = 4.0 * u - 2.0 + s;
    x / (1.0 + (1.0 + s * x).max(0.0).sqrt())
}

impl Half {
    /// The spans of R, TT or TRT, and the sampling energy of each.
    #[inline(always)]
    fn spans(&self, p: usize) -> (&Lobe, [f32; 8]) {
        let (lobe, lanes) = match (&self.lobes[1].spread, p) {
            (Spread::Bells(_), 1) => (&self.lobes[1], 0..4),
            (Spread::Bells(_), 2) => (&self.lobes[1], 4..8),
            _ => (&self.lobes[p], 0..8),
        };
        let all = lobe.spans.energy[3].to_array();
        let mut energy = [0.0; 8];
        energy[lanes.clone()].copy_from_slice(&all[lanes]);
        (lobe, energy)
    }
}

/// Draws φ of R, TT or TRT with the density of [`Half::eval`]. `u`: one number for the span and the place in it, one
/// for the Gaussian.
#[inline(always)]
pub(crate) fn draw(halves: &[Option<Half>], p: usize, sigma: f32, u: [f32; 2]) -> f32 {
    let halves = halves.iter().map_while(Option::as_ref);
    let total: f32 = halves.clone().map(|half| half.count as f32 * half.spans(p).1.iter().sum::<f32>()).sum();
    let spans = halves.flat_map(|half| {
        let (lobe, energy) = half.spans(p);
        let signs = half.signs[..half.count].iter();
        signs.flat_map(move |sign| {
            energy.into_iter().enumerate().map(move |(lane, energy)| ((half, lobe, *sign, lane), energy))
        })
    });
    let Some(choice) = choose(spans, u[0] * total) else { return 0.0 };
    let ((half, lobe, sign, lane), t) = (choice.item, choice.fraction().min(1.0));
    let [middle, length] = lobe.spread.span(lane);
    // If a linear density cannot have this mean, the remaining difference shifts the span.
    let mean = lobe.spans.mean.to_array()[lane];
    let slope = (3.0 * mean / length.max(1e-6)).clamp(-1.0, 1.0);
    let aside = mean - slope * length * (1.0 / 3.0);
    let x = middle + aside + length * sloping(slope, t) + special::normal_quantile(u[1]);
    sign * (half.centres.to_array()[p] + sigma * x)
}
