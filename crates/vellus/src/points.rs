//! TTˢ and TRTˢ averaged over a window, from Gauss points in asin h″ (Yan17 Eq. 25).
//!
//! The paper takes A(h) C^N as a cubic times an exponential between nodes. At four nodes a side that is 5.6 % off on
//! average over the presets, Gauss points 0.3 %; at eight 1.7 % and 0.1 %. How many it takes depends on how sharp the
//! forward peak is, which the offset moves around the fibre: three of TTˢ and one of TRTˢ, which in the presets has at
//! most a few hundredths of its light, where light is scattered widely or often; up to ten and six for a thin,
//! strongly forward medulla.

use crate::azimuthal::wrap;
use crate::bcsdf::Bcsdf;
use crate::frame::Polar;
use crate::medulla::Medulla;
use crate::mixture::Weights;
use crate::nodes::{Nodes, Side};
use crate::path::Path;
use crate::segments::{Channels, Through, attenuation, sum};
use crate::tables::AZIMUTHAL;
use arrayvec::ArrayVec;
use std::f32::consts::PI;
use wide::{f32x4, f32x8};

/// Positions on [0, 1] and their shares, Gauss–Legendre, of TTˢ and then of TRTˢ.
#[derive(Clone, Copy)]
struct Rule {
    position: f32x8,
    share: f32x8,
}

/// Three points of TTˢ and one of TRTˢ, twice.
const FEW: Rule = Rule {
    position: f32x8::new([0.11270166, 0.5, 0.88729835, 0.5, 0.11270166, 0.5, 0.88729835, 0.5]),
    share: f32x8::new([0.2777778, 0.44444445, 0.2777778, 1.0, 0.2777778, 0.44444445, 0.2777778, 1.0]),
};
/// Five and three.
const SOME: [Rule; 1] = [Rule {
    position: f32x8::new([0.046910077, 0.23076534, 0.5, 0.76923466, 0.95308995, 0.11270166, 0.5, 0.88729835]),
    share: f32x8::new([0.11846344, 0.23931433, 0.28444445, 0.23931433, 0.11846344, 0.2777778, 0.44444445, 0.2777778]),
}];
/// Ten and six, every other in each register.
const MANY: [Rule; 2] = [
    Rule {
        position: f32x8::new([
            0.013046736,
            0.16029522,
            0.42556283,
            0.7166977,
            0.93253165,
            0.03376524,
            0.3806904,
            0.8306047,
        ]),
        share: f32x8::new([
            0.03333567,
            0.10954318,
            0.14776212,
            0.13463336,
            0.07472567,
            0.085662246,
            0.23395696,
            0.18038079,
        ]),
    },
    Rule {
        position: f32x8::new([
            0.067468315,
            0.2833023,
            0.57443714,
            0.8397048,
            0.98695326,
            0.16939531,
            0.6193096,
            0.96623474,
        ]),
        share: f32x8::new([
            0.07472567,
            0.13463336,
            0.14776212,
            0.10954318,
            0.03333567,
            0.18038079,
            0.23395696,
            0.085662246,
        ]),
    },
];

/// The lanes of TTˢ; the others are of TRTˢ.
const FIRST_OF_FEW: f32x8 = f32x8::new([1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.0]);
const FIRST: f32x8 = f32x8::new([1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);

/// Eight paths.
#[derive(Clone, Copy, Debug)]
struct Group {
    /// C^N.
    weights: [Weights<AZIMUTHAL>; 8],
    /// Φˢ.
    exit: f32x8,
    /// 1, and −1 where φ is mirrored.
    mirror: f32x8,
    /// The same paths stand for the mirrored half as well.
    twice: bool,
    /// What each path stands for of the energy of TTˢ and of TRTˢ.
    energy: [Channels; 2],
}

/// The paths of a window.
#[derive(Clone, Debug)]
pub(crate) struct Points(ArrayVec<Group, 3>);

impl Group {
    const NONE: Group = Group {
        weights: [[f32x8::ZERO; AZIMUTHAL]; 8],
        exit: f32x8::ZERO,
        mirror: f32x8::ZERO,
        twice: false,
        energy: [[f32x8::ZERO; 4]; 2],
    };

    /// Prepares it where it lies, it being large; `sides` is what the lower and the upper four lanes are of.
    #[inline(always)]
    fn prepare(
        &mut self,
        bcsdf: &Bcsdf,
        polar: Polar<f32>,
        through: &Through,
        sides: [Option<Side>; 2],
        mirror: [f32; 2],
        rule: &Rule,
        first: f32x8,
    ) {
        let lower = f32x8::new([1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]).simd_gt(f32x8::ZERO);
        let none = (f32x8::ZERO, f32x8::ZERO);
        let [a, b] = sides.map(|side| side.map_or(none, |side| side.points(rule.position, rule.share)));
        let (h, width) = (lower.select(a.0, b.0), lower.select(a.1, b.1));
        let path = Path::new(&bcsdf.fiber, f32x8::splat(polar.sin), f32x8::splat(polar.cos), h);
        let angles = path.gamma_m.to_array();
        for i in 0..8 {
            // The far field's two halves are the same.
            if i >= 4 && angles[i] == angles[i - 4] {
                self.weights[i] = self.weights[i - 4];
                continue;
            }
            let azimuth = bcsdf.medulla.azimuth(&through.pass, angles[i]);
            for c in 0..AZIMUTHAL {
                self.weights[i][c] = azimuth.weights[c] * f32x8::splat(azimuth.scale);
            }
        }
        let a = attenuation(bcsdf, &path, Some(through));
        let shares = [width * first, width * (f32x8::ONE - first)];
        for q in 0..2 {
            (0..4).for_each(|c| self.energy[q][c] = a[3 + q][c] * shares[q]);
        }
        let is_first = first.simd_gt(f32x8::ZERO);
        self.exit = is_first.select(path.scattered_azimuth(1), path.scattered_azimuth(2));
        self.mirror = lower.select(f32x8::splat(mirror[0]), f32x8::splat(mirror[1]));
    }
}

impl Group {
    /// How many halves it stands for.
    fn times(&self) -> f32 {
        if self.twice { 2.0 } else { 1.0 }
    }
}

impl Points {
    /// None.
    pub fn none() -> Self {
        Points(ArrayVec::new())
    }

    /// Prepares them so that they sum to the `energy` of TTˢ and TRTˢ found already.
    #[inline(always)]
    pub fn prepare(
        &mut self,
        bcsdf: &Bcsdf,
        polar: Polar<f32>,
        through: &Through,
        sides: [Option<&Nodes>; 2],
        energy: [f32x4; 2],
    ) {
        let sides = sides.map(|nodes| nodes.and_then(|nodes| nodes.medulla));
        let sharpness = bcsdf.medulla.sharpness();
        if sharpness == 0 {
            self.add(bcsdf, polar, through, sides, [1.0, -1.0], &FEW, FIRST_OF_FEW, false);
        } else {
            // Sides that both begin at the axis: what they share, once for both, and what one of them has more.
            let pieces = match sides {
                [Some(a), Some(b)] => {
                    let (shared, rest) = a.overlap(&b);
                    [(Some(shared), 1.0, true), (rest, if a.longer_than(&b) { 1.0 } else { -1.0 }, false)]
                }
                [a, b] => [(a, 1.0, false), (b, -1.0, false)],
            };
            for (side, mirror, twice) in pieces {
                // Half as many on half the way: one piece at most is longer than that.
                let long = side.is_some_and(|side| side.length() > 0.5);
                let rules: &[Rule] = if sharpness == 2 && long { &MANY } else { &SOME };
                for rule in rules {
                    self.add(bcsdf, polar, through, [side; 2], [mirror; 2], rule, FIRST, twice);
                }
            }
        }
        for q in 0..2 {
            let add = |total, group: &Group| total + f32x4::splat(group.times()) * sum(group.energy[q]);
            let total = self.0.iter().fold(f32x4::ZERO, add);
            let scale = (energy[q] / total.max(f32x4::splat(f32::MIN_POSITIVE))).to_array();
            for group in &mut self.0 {
                (0..4).for_each(|c| group.energy[q][c] *= f32x8::splat(scale[c]));
            }
        }
    }

    /// Adds a group, as [`Group::prepare`] wants it, unless it would have no paths.
    fn add(
        &mut self,
        bcsdf: &Bcsdf,
        polar: Polar<f32>,
        through: &Through,
        sides: [Option<Side>; 2],
        mirror: [f32; 2],
        rule: &Rule,
        first: f32x8,
        twice: bool,
    ) {
        if sides.iter().all(Option::is_none) {
            return;
        }
        self.0.push(Group::NONE);
        if let Some(group) = self.0.last_mut() {
            group.prepare(bcsdf, polar, through, sides, mirror, rule, first);
            group.twice = twice;
        }
    }

    /// Draws φ of TTˢ (0) or TRTˢ (1) from what [`Points::eval`] gives the density of, and the azimuth from straight back.
    /// `u`: the path, and the azimuth.
    pub fn draw(&self, medulla: &Medulla, q: usize, u: [f32; 2]) -> [f32; 2] {
        let energy = |group: &Group| group.energy[q][3].to_array();
        let total: f32 = self.0.iter().map(|group| group.times() * energy(group).iter().sum::<f32>()).sum();
        let mut rest = u[0] * total;
        let mut chosen = None;
        'found: for group in &self.0 {
            for (lane, e) in energy(group).into_iter().enumerate() {
                let e = e * group.times();
                if e > 0.0 {
                    chosen = Some((group, lane, rest / e));
                    if rest < e {
                        break 'found;
                    }
                }
                rest -= e;
            }
        }
        let Some((group, lane, t)) = chosen else { return [0.0; 2] };
        let relative = medulla.sample_profile(&group.weights[lane], u[1]);
        let flip = if group.twice && t >= 0.5 { -1.0 } else { 1.0 };
        [flip * group.mirror.to_array()[lane] * (relative + group.exit.to_array()[lane]), wrap(relative)]
    }

    /// TTˢ and TRTˢ at φ, densities over solid angle; `m`: C^M of the backward and the forward half.
    #[inline(always)]
    pub fn eval(&self, medulla: &Medulla, phi: f32, m: [f32; 2]) -> [f32x4; 2] {
        let mut lobes = [[f32x8::ZERO; 4]; 2];
        for group in &self.0 {
            for phi in &[phi, -phi][..1 + usize::from(group.twice)] {
                let relative = wrap(f32x8::splat(*phi) * group.mirror - group.exit);
                let m =
                    (relative.abs() * f32x8::splat(1.0 / PI)).mul_add(f32x8::splat(m[1] - m[0]), f32x8::splat(m[0]));
                let density = m * medulla.azimuthal8([0, 1, 2, 3, 4, 5, 6, 7].map(|i| &group.weights[i]), relative);
                for q in 0..2 {
                    for c in 0..4 {
                        lobes[q][c] = group.energy[q][c].mul_add(density, lobes[q][c]);
                    }
                }
            }
        }
        [sum(lobes[0]), sum(lobes[1])]
    }
}
