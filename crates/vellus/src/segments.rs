//! R, TT, TRT of one half of the fibre's width, offsets ≥ 0, by segments (Yan17 Sec. 5.1).
//!
//! A segment's light leaves over a range of azimuths, spread by the lobe's Gaussian. Its density over that
//! range is taken as linear, with the segment's energy and mean azimuth both exact (two-point
//! Gauss–Legendre in the angle): the linear density also takes up how Φ curves along the segment, which the
//! paper's linear Φ and linear factors of A(h) do not.

use crate::azimuthal::wrap;
use crate::bcsdf::Bcsdf;
use crate::frame::Polar;
use crate::integrals::{Bells, Chain};
use crate::lanes::{Lanes, Quad};
use crate::medulla::Pass;
use crate::nodes::Nodes;
use crate::path::{Path, angles, exit_azimuth, lobe_probabilities};
use crate::tables::OFFSETS;
use std::f32::consts::{PI, TAU};
use wide::{f32x4, f32x8};

/// RGB and the sampling density, eight of each.
pub(crate) type Channels = [f32x8; 4];

/// τ of the hit put into the tables.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Through {
    pub pass: Pass,
    /// ⟨L⟩ at the nodes of h″.
    pub mean_paths: [f32; OFFSETS],
}

/// Energy over σ, and its first moment about the middle in standard deviations, of eight spans of azimuth.
#[derive(Clone, Copy, Debug)]
struct Spans {
    energy: Channels,
    moment: Channels,
}

impl Spans {
    const NONE: Spans = Spans { energy: [f32x8::ZERO; 4], moment: [f32x8::ZERO; 4] };

    #[inline(always)]
    fn add(&self, [j0, j1]: [f32x8; 2], n: &mut Channels) {
        for c in 0..4 {
            n[c] = self.energy[c].mul_add(j0, self.moment[c].mul_add(j1, n[c]));
        }
    }
}

/// R, TT, TRT of one half of a window.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Half {
    /// The azimuths R, TT, TRT are measured from, in the first three lanes.
    centres: f32x8,
    /// Turns of the circle, either way, from which each lobe's tails come round.
    turns: [i32; 3],
    /// Is R, and are TT and TRT, so wide that bells do? Those of TT, four in the lower lanes, and TRT, in the upper,
    /// share a register, and their spans take the place of TT's.
    wide: [bool; 2],
    spans: [Spans; 3],
    chains: [Chain; 3],
    bells: [Bells; 2],
}

/// N(φ) of R, TT, TRT by span; the last has spans of TT in the lower lanes and of TRT in the upper.
pub(crate) type Unscattered = [Channels; 4];

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

/// A(h) of a register of paths, with the probability of sampling each lobe in place of the spare channel.
#[inline(always)]
pub(crate) fn attenuation(bcsdf: &Bcsdf, path: &Path<f32x8>, through: Option<&Through>) -> [Channels; 6] {
    let mean_paths = match through {
        Some(through) => bcsdf.medulla.mean_paths_at(&through.mean_paths, path.gamma_m),
        None => f32x8::ZERO,
    };
    let a = path.attenuation(&bcsdf.fiber, mean_paths);
    let probability = lobe_probabilities::<f32x8>(&a);
    let mut out = [[f32x8::ZERO; 4]; 6];
    for p in 0..6 {
        let [r, g, b, _] = a[p].array();
        out[p] = [r, g, b, probability[p]];
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

impl Half {
    /// Nothing.
    pub const NONE: Half = Half {
        centres: f32x8::ZERO,
        turns: [0; 3],
        wide: [false; 2],
        spans: [Spans::NONE; 3],
        chains: [Chain::NONE; 3],
        bells: [Bells::NONE; 2],
    };

    /// Prepares it in place, it being large; the energies of the six lobes, RGB and probability. `scale` is 1
    /// over the width of the whole window.
    #[inline(always)]
    pub fn prepare(
        &mut self,
        bcsdf: &Bcsdf,
        polar: Polar<f32>,
        through: Option<&Through>,
        nodes: &Nodes,
        scale: f32,
    ) -> [f32x4; 6] {
        let splat = f32x8::splat;
        let [sin, cos] = [polar.sin, polar.cos].map(splat);
        let paths = nodes.gauss.map(|h| Path::new(&bcsdf.fiber, sin, cos, h));
        let a = [attenuation(bcsdf, &paths[0], through), attenuation(bcsdf, &paths[1], through)];
        let weights = nodes.weights.map(|w| w * splat(scale));
        let mut energy = [f32x4::ZERO; 6];
        for p in 0..6 {
            let mut shares = [f32x8::ZERO; 4];
            for c in 0..4 {
                shares[c] = weights[0] * a[0][p][c] + weights[1] * a[1][p][c];
            }
            energy[p] = sum(shares);
        }
        let [gamma_o, gamma_t] = angles(nodes.ends, paths[0].inverse_eta);
        // Of each lobe: its segments' ends and Gauss points in standard deviations from its centre.
        let (mut ends, mut points) = ([f32x8::ZERO; 3], [[f32x8::ZERO; 2]; 3]);
        let mut centres = [0.0; 8];
        for p in 0..3 {
            let inverse_sigma = splat(bcsdf.azimuthal.inverse_sigma[p]);
            let exit = exit_azimuth(p as u8, gamma_o, gamma_t);
            centres[p] = 0.5 * (exit.lane(0) + exit.lane(7));
            let origin = splat(centres[p]);
            ends[p] = (exit - origin) * inverse_sigma;
            points[p] = [0, 1].map(|k| (paths[k].exit_azimuth(p as u8) - origin) * inverse_sigma);
        }
        self.centres = f32x8::new(centres);
        // Energy per radian at the Gauss points of lobe p in channel c.
        let shares = |p: usize, c: usize| {
            let scale = splat(bcsdf.azimuthal.inverse_sigma[p]);
            [0, 1].map(|k| weights[k] * a[k][p][c] * scale)
        };
        let mut reach = [0.0; 3];
        for p in 0..3 {
            if p == 1 && self.pack(&shares, &points) {
                reach = [reach[0], self.bells[1].reach(), self.bells[1].reach()];
                break;
            }
            let chain = Chain::new(ends[p]);
            let limit = chain.moment_limit();
            for c in 0..4 {
                let [first, last] = shares(p, c);
                let energy = first + last;
                let moment = first * (points[p][0] - chain.middle()) + last * (points[p][1] - chain.middle());
                let limit = energy * limit;
                self.spans[p].energy[c] = energy;
                self.spans[p].moment[c] = moment.fast_max(-limit).fast_min(limit);
            }
            reach[p] = chain.reach();
            self.chains[p] = chain;
            let variance = chain.variance();
            if p == 0 && Bells::suit(variance) {
                self.wide[0] = true;
                self.bells[0] = Bells::new(chain.middle(), variance);
                reach[0] = self.bells[0].reach();
            }
        }
        for p in 0..3 {
            self.turns[p] = ((reach[p] * bcsdf.azimuthal.sigma[p] + PI) * (1.0 / TAU)) as i32;
        }
        energy
    }

    /// Takes the segments of TT and TRT two by two, where both lobes are wide enough for bells. Mean and
    /// variance of a span are those of its light as it is sampled.
    #[inline(always)]
    fn pack(&mut self, shares: &impl Fn(usize, usize) -> [f32x8; 2], points: &[[f32x8; 2]; 3]) -> bool {
        let (tt, trt) = (&points[1], &points[2]);
        let moments = |c: usize| {
            let (a, b) = (shares(1, c), shares(2, c));
            let energy = pairs(a[0] + a[1], b[0] + b[1]);
            (energy, pairs(a[0] * tt[0] + a[1] * tt[1], b[0] * trt[0] + b[1] * trt[1]))
        };
        let (energy, first) = moments(3);
        let inverse = f32x8::ONE / energy.fast_max(f32x8::splat(f32::MIN_POSITIVE));
        let middle = first * inverse;
        let (a, b) = (shares(1, 3), shares(2, 3));
        let second =
            pairs(a[0] * tt[0] * tt[0] + a[1] * tt[1] * tt[1], b[0] * trt[0] * trt[0] + b[1] * trt[1] * trt[1]);
        let variance = (second * inverse - middle * middle).fast_max(f32x8::ZERO);
        if !Bells::suit(variance) {
            return false;
        }
        self.wide[1] = true;
        self.bells[1] = Bells::new(middle, variance);
        for c in 0..4 {
            let (energy, first) = moments(c);
            let limit = energy * f32x8::splat(Bells::LONGEST / 3.0);
            self.spans[1].energy[c] = energy;
            self.spans[1].moment[c] = (first - middle * energy).fast_max(-limit).fast_min(limit);
        }
        true
    }

    /// Adds N(φ) of R, TT, TRT, densities per radian.
    #[inline(always)]
    pub fn add(&self, phi: f32, inverse_sigma: &[f32; 3], n: &mut Unscattered) {
        let distance = wrap(f32x8::splat(phi) - self.centres).to_array();
        if self.wide[1] {
            let turns = self.turns[1].max(self.turns[2]);
            for turn in -turns..=turns {
                let d = [1, 2].map(|p| (distance[p] + turn as f32 * TAU) * inverse_sigma[p]);
                if d[0].abs().min(d[1].abs()) < self.bells[1].reach() {
                    let d = f32x8::new([d[0], d[0], d[0], d[0], d[1], d[1], d[1], d[1]]);
                    self.spans[1].add(self.bells[1].integrals(d), &mut n[3]);
                }
            }
        }
        for p in 0..if self.wide[1] { 1 } else { 3 } {
            for turn in -self.turns[p]..=self.turns[p] {
                let d = (distance[p] + turn as f32 * TAU) * inverse_sigma[p];
                if p == 0 && self.wide[0] {
                    if d.abs() < self.bells[0].reach() {
                        self.spans[0].add(self.bells[0].integrals(f32x8::splat(d)), &mut n[0]);
                    }
                } else if d.abs() < self.chains[p].reach() {
                    self.spans[p].add(self.chains[p].integrals(d), &mut n[p]);
                }
            }
        }
    }
}

/// The three lobes from their spans. What rounding leaves below 0 is 0.
#[inline(always)]
pub(crate) fn gather(n: &Unscattered) -> [f32x4; 3] {
    let [tt, trt] = halves(n[3]);
    [sum(n[0]), tt + sum(n[1]), trt + sum(n[2])].map(|x| x.max(f32x4::ZERO))
}
