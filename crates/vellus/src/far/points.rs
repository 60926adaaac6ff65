//! TTˢ and TRTˢ averaged over a window, from Gauss points in asin h″ (Yan17 Eq. 25).
//!
//! The paper represents A(h) C^N between nodes as a cubic times an exponential. With four nodes on each side, its
//! average error over the presets is 5.6 %, and that of Gauss points is 0.3 %. With eight nodes the errors are 1.7 %
//! and 0.1 %.
//!
//! The offset moves the forward peak of C^N around the fibre, by up to 90°. The number of points depends on this motion
//! relative to the width of the peak. If the peak is wide, three points of TTˢ and one of TRTˢ are enough. Otherwise
//! there are five and three. If the peak is narrower than their distance, the light of each point is spread over the
//! azimuths of its offsets: C^N is looked up once, and evaluated at up to eight of these azimuths. This is enough for a
//! thin medulla, because the shape of its C^N hardly depends on the offset.

use crate::choose::choose;
use crate::cylinder::azimuthal::wrap;
use crate::cylinder::frame::Polar;
use crate::cylinder::path::Route;
use crate::exit::turn::Turn;
use crate::far::nodes::Side;
use crate::far::segments::{Channels, Through, attenuation, sum};
use crate::medulla::mixture::Weights;
use crate::medulla::tables::AZIMUTHAL;
use crate::medulla::{Inclination, Medulla};
use crate::prepared::Prepared;
use std::f32::consts::PI;
use wide::{f32x4, f32x8};

/// Gauss–Legendre positions on [0, 1] and their weights, of TTˢ and then of TRTˢ.
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
/// Five points of TTˢ and three of TRTˢ.
const SOME: Rule = Rule {
    position: f32x8::new([0.046910077, 0.23076534, 0.5, 0.76923466, 0.95308995, 0.11270166, 0.5, 0.88729835]),
    share: f32x8::new([0.11846344, 0.23931433, 0.28444445, 0.23931433, 0.11846344, 0.2777778, 0.44444445, 0.2777778]),
};
/// Where the cells of these points start: the cumulative weights.
const CELLS: f32x8 = f32x8::new([0.0, 0.11846344, 0.35777777, 0.6422222, 0.88153654, 0.0, 0.2777778, 0.7222222]);

/// The largest number of groups of eight points.
const GROUPS: usize = 2;

/// The largest number of azimuths over which the light of a point is spread.
const MOST: usize = 8;

/// The upper limits for [`FEW`]. The first is for the distance between the first and the last exit azimuth, in widths
/// of the peak. The second is for the ratio of the energies of TRTˢ and TTˢ.
const FEW_SPAN: f32 = 2.6;
const FEW_SECOND: f32 = 0.1;

/// The lanes of TTˢ. The others are lanes of TRTˢ.
const FIRST_OF_FEW: f32x8 = f32x8::new([1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.0]);
const FIRST: f32x8 = f32x8::new([1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);

/// Φˢ of one azimuth over which the light of a path is spread, how the cuticle turns it, and its share of the light.
#[derive(Clone, Copy, Debug)]
struct Exit {
    azimuth: f32x8,
    turn: Turn<f32x8>,
    share: f32x8,
}

impl Exit {
    fn none() -> Exit {
        Exit { azimuth: f32x8::ZERO, turn: Turn::none(), share: f32x8::ZERO }
    }
}

/// Eight paths.
#[derive(Clone, Copy, Debug)]
struct Group {
    /// C^N.
    weights: [Weights<AZIMUTHAL>; 8],
    /// The share of C^N that is mirrored, see [`crate::medulla::Azimuth`].
    turned: f32x8,
    /// Φˢ and a share of 1, if the light is not spread.
    exit: Exit,
    /// The number of azimuths in [`Points::exits`] over which it is spread. 0 if it is not spread.
    count: usize,
    /// 1, or −1 if φ is mirrored.
    mirror: f32x8,
    /// True if the same paths also represent the mirrored half.
    twice: bool,
    /// Whether any of `turned` is above 0.
    turns: bool,
    /// The share of each path in the energy of TTˢ and of TRTˢ.
    energy: [Channels; 2],
}

/// The paths of a window.
#[derive(Clone, Debug)]
pub(crate) struct Points {
    groups: [Option<Group>; GROUPS],
    /// The azimuths over which the light of each group is spread.
    exits: [Option<[Exit; MOST]>; GROUPS],
    /// Whether no group has spread light or a partly mirrored C^N.
    plain: bool,
    /// Whether the cuticle turns the light.
    turning: bool,
}

/// Data that all groups of a hit share.
#[derive(Clone, Copy)]
struct Query<'a, 'b> {
    prepared: &'a Prepared<'b>,
    polar: Polar<f32>,
    /// The cosine and the sine of the azimuth of ω_o, for offsets ≥ 0 and for those that are mirrored.
    toward: [[f32; 2]; 2],
    through: &'a Through,
}

impl Query<'_, '_> {
    /// Traces paths at offsets h. `mirror`: 1, or −1 for offsets that are mirrored.
    #[inline(always)]
    fn paths<R: Route<f32x8>>(&self, h: f32x8, mirror: f32x8) -> R {
        let is_first = mirror.simd_gt(f32x8::ZERO);
        let [first, second] = self.toward.map(|toward| toward.map(f32x8::splat));
        let toward = [0, 1].map(|i| is_first.select(first[i], second[i]));
        R::trace(self.prepared, [self.polar.sin, self.polar.cos].map(f32x8::splat), toward, h)
    }

    /// The energies of TTˢ and TRTˢ of paths of width `dh`, each in its own lanes.
    #[inline(always)]
    fn energy(&self, path: &impl Route<f32x8>, dh: f32x8, first: f32x8) -> [Channels; 2] {
        let a = attenuation(self.prepared, path, Some(self.through));
        let widths = [dh * first, dh * (f32x8::ONE - first)];
        let mut energy = [[f32x8::ZERO; 4]; 2];
        for q in 0..2 {
            (0..4).for_each(|c| energy[q][c] = a[3 + q][c] * widths[q]);
        }
        energy
    }
}

impl Query<'_, '_> {
    /// The exit of TTˢ in its lanes, and of TRTˢ in the others, and the azimuth of light that goes straight on, up to
    /// half a turn.
    #[inline(always)]
    fn exits(&self, path: &impl Route<f32x8>, h: f32x8, first: f32x8) -> (Exit, f32x8) {
        let first = first.simd_gt(f32x8::ZERO);
        let azimuth = first.select(path.scattered_azimuth(1), path.scattered_azimuth(2));
        let Some(turning) = &self.prepared.turning else {
            return (Exit { azimuth, turn: Turn::none(), share: f32x8::ONE }, azimuth);
        };
        let (turns, [shift, ahead]) = turning.all(f32x8::splat(self.polar.cos), h, path);
        let [one, two] = turns.first.map(|turn| turn.a);
        let turn = Turn { a: [first.select(one[0], two[0]), first.select(one[1], two[1])] };
        (Exit { azimuth: azimuth + shift, turn, share: f32x8::ONE }, azimuth + ahead)
    }
}

impl Group {
    fn none() -> Group {
        Group {
            weights: [[f32x8::ZERO; AZIMUTHAL]; 8],
            turned: f32x8::ZERO,
            exit: Exit::none(),
            count: 0,
            mirror: f32x8::ZERO,
            twice: false,
            turns: false,
            energy: [[f32x8::ZERO; 4]; 2],
        }
    }

    /// Prepares [`FEW`] points in place, because a group is large. `sides` states which half the lower and the upper
    /// four lanes belong to. Returns the azimuth of light that goes straight on.
    #[inline(always)]
    fn prepare_few<R: Route<f32x8>>(&mut self, query: &Query, sides: [Option<Side>; 2]) -> [f32; 8] {
        let lower = f32x8::new([1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]).simd_gt(f32x8::ZERO);
        let none = (f32x8::ZERO, f32x8::ZERO);
        let [a, b] = sides.map(|side| side.map_or(none, |side| side.points(FEW.position, FEW.share)));
        let (h, dh) = (lower.select(a.0, b.0), lower.select(a.1, b.1));
        self.mirror = lower.select(f32x8::ONE, -f32x8::ONE);
        let path: R = query.paths(h, self.mirror);
        let narrow = sides.iter().flatten().all(Side::is_narrow);
        self.look_up(query, &path, narrow);
        self.energy = query.energy(&path, dh, FIRST_OF_FEW);
        let (exit, ahead) = query.exits(&path, h, FIRST_OF_FEW);
        self.exit = exit;
        ahead.to_array()
    }

    /// Prepares [`SOME`] points of one side in place. `width` is that of the peak of C^N. `spread` gets the azimuths
    /// over which their light is spread.
    fn prepare_some<R: Route<f32x8>>(
        &mut self,
        query: &Query,
        side: Side,
        mirror: f32,
        width: f32,
        spread: &mut Option<[Exit; MOST]>,
    ) {
        let (h, dh) = side.points(SOME.position, SOME.share);
        self.mirror = f32x8::splat(mirror);
        let path: R = query.paths(h, self.mirror);
        self.look_up(query, &path, side.is_narrow());
        let (exit, ahead) = query.exits(&path, h, FIRST);
        self.exit = exit;
        // The widest gap between neighbouring points estimates the azimuths that a cell spans. A cell covers at most
        // 0.28 of the side, or 0.44 for TRTˢ. The widest gaps cover at least 0.24 and 0.39.
        let e = ahead.to_array();
        let gaps = [e[1] - e[0], e[2] - e[1], e[3] - e[2], e[4] - e[3], e[6] - e[5], e[7] - e[6]];
        let widest = gaps.into_iter().fold(0.0, |most: f32, gap| most.max(gap.abs()));
        let count = ((widest / width).ceil() as usize).clamp(1, MOST);
        if count == 1 {
            self.energy = query.energy(&path, dh, FIRST);
            return;
        }
        let spread = &mut spread.insert([Exit::none(); MOST])[..count];
        let within = SOME.share * f32x8::splat(1.0 / count as f32);
        for (k, exit) in spread.iter_mut().enumerate() {
            let (h, dh) = side.points(within.mul_add(f32x8::splat(k as f32 + 0.5), CELLS), within);
            let path: R = query.paths(h, self.mirror);
            let energy = query.energy(&path, dh, FIRST);
            for q in 0..2 {
                (0..4).for_each(|c| self.energy[q][c] += energy[q][c]);
            }
            *exit = Exit { share: energy[0][3] + energy[1][3], ..query.exits(&path, h, FIRST).0 };
        }
        let inverse = f32x8::ONE / (self.energy[0][3] + self.energy[1][3]).fast_max(f32x8::splat(f32::MIN_POSITIVE));
        spread.iter_mut().for_each(|exit| exit.share *= inverse);
        self.count = count;
    }

    /// Looks up C^N of the paths. In a `narrow` window the lookup is that of the near field. In a wider window nothing
    /// is mirrored, because offsets so close to the axis hardly contribute.
    #[inline(always)]
    fn look_up(&mut self, query: &Query, path: &impl Route<f32x8>, narrow: bool) {
        let angles = path.path().gamma_m.to_array();
        let mut turned = [0.0; 8];
        for i in 0..8 {
            // The two halves of the far field have the same paths.
            if i >= 4 && angles[i] == angles[i - 4] {
                self.weights[i] = self.weights[i - 4];
                turned[i] = turned[i - 4];
                continue;
            }
            let Through { pass, leaving, .. } = query.through;
            let azimuth = query.prepared.medulla.azimuth_leaving(pass, angles[i], *leaving);
            for c in 0..AZIMUTHAL {
                self.weights[i][c] = azimuth.weights[c] * f32x8::splat(azimuth.scale);
            }
            if narrow {
                turned[i] = azimuth.turned;
                self.turns |= azimuth.turned > 0.0;
            }
        }
        self.turned = f32x8::new(turned);
    }
}

/// The azimuth, its cosine and its sine.
#[derive(Clone, Copy)]
struct Around([f32x8; 3]);

impl Around {
    /// The azimuth from straight back inside the fibre of light with this exit, and how much it changes with φ.
    #[inline(always)]
    fn inside(&self, exit: &Exit, turning: bool) -> [f32x8; 2] {
        let Around([phi, cos, sin]) = *self;
        let relative = phi - exit.azimuth;
        if !turning {
            return [wrap(relative), f32x8::ONE];
        }
        let inverse = exit.turn.inverse([cos, sin]);
        let half = inverse[1].atan2(inverse[0]);
        [wrap(relative + half + half), exit.turn.slope(inverse)]
    }
}

impl Group {
    /// C^M times C^N without the mirrored share. `relative` is the azimuth from straight back, in [−π, π].
    #[inline(always)]
    fn density(&self, medulla: &Medulla, relative: f32x8, m: [f32; 2]) -> f32x8 {
        let m = (relative.abs() * f32x8::splat(1.0 / PI)).mul_add(f32x8::splat(m[1] - m[0]), f32x8::splat(m[0]));
        m * medulla.azimuthal8([0, 1, 2, 3, 4, 5, 6, 7].map(|i| &self.weights[i]), relative)
    }

    /// The same at the azimuth φ. This includes the mirrored share, and light that is spread over azimuths.
    #[inline(always)]
    fn spread_density(&self, medulla: &Medulla, exits: &[Exit], turning: bool, around: &Around, m: [f32; 2]) -> f32x8 {
        let exits = if exits.is_empty() { std::slice::from_ref(&self.exit) } else { exits };
        let mut sum = f32x8::ZERO;
        for exit in exits {
            let [relative, slope] = around.inside(exit, turning);
            let mut density = self.density(medulla, relative, m);
            if self.turns {
                density += self.turned * (self.density(medulla, -relative, m) - density);
            }
            sum = (exit.share * slope).mul_add(density, sum);
        }
        sum
    }

    /// The number of halves that the group represents.
    fn times(&self) -> f32 {
        if self.twice { 2.0 } else { 1.0 }
    }
}

impl Points {
    /// No points.
    pub fn none() -> Self {
        Points { groups: [None; GROUPS], exits: [None; GROUPS], plain: true, turning: false }
    }

    /// The groups, with the azimuths over which the light of each is spread, if it is spread.
    #[inline(always)]
    fn groups(&self) -> impl Iterator<Item = (&Group, &[Exit])> {
        self.groups.iter().zip(&self.exits).map_while(|(group, exits)| {
            let group = group.as_ref()?;
            let exits = exits.as_ref().and_then(|exits| exits.get(..group.count));
            Some((group, exits.unwrap_or_default()))
        })
    }

    /// Prepares the points so that they sum to the given `energy` of TTˢ and TRTˢ. Returns this energy. Its last
    /// channel is the sum over the paths of the largest channel of each.
    #[inline(always)]
    pub fn prepare<R: Route<f32x8>>(
        &mut self,
        prepared: &Prepared,
        (polar, toward): (Polar<f32>, [[f32; 2]; 2]),
        through: &Through,
        sides: [Option<Side>; 2],
        mut energy: [f32x4; 2],
    ) -> [f32x4; 2] {
        let query = Query { prepared, polar, toward, through };
        self.turning = prepared.turning.is_some();
        if sides.iter().all(Option::is_none) {
            return energy;
        }
        let width = prepared.medulla.peak_width();
        let [first, second] = energy.map(|e| e.to_array()[3]);
        let mut enough = prepared.medulla.is_smooth() && second < FEW_SECOND * first;
        if enough {
            let group = self.groups[0].insert(Group::none());
            // The first and the last point are at 0.11 and 0.89 of a side.
            let e = group.prepare_few::<R>(&query, sides);
            let span = (e[2] - e[0]).abs().max((e[6] - e[4]).abs());
            enough = span < FEW_SPAN * width;
        }
        if !enough {
            self.prepare_some::<R>(&query, sides, width);
        }
        let plain = self.groups().all(|(group, exits)| exits.is_empty() && !group.turns);
        self.plain = plain;
        for q in 0..2 {
            let scale = (energy[q] / self.total(q).max(f32x4::splat(f32::MIN_POSITIVE))).to_array();
            for group in self.groups.iter_mut().flatten() {
                let [r, g, b, most] = &mut group.energy[q];
                for (channel, scale) in [&mut *r, g, b].into_iter().zip(scale) {
                    *channel *= f32x8::splat(scale);
                }
                // The scales of the channels differ by the error of the points, up to a factor of 3 in dark fibres. The
                // density must be at least that of each channel, or weights grow with this error.
                *most = r.fast_max(*g).fast_max(*b);
            }
            let [r, g, b, _] = energy[q].to_array();
            energy[q] = f32x4::new([r, g, b, self.total(q).to_array()[3]]);
        }
        energy
    }

    /// The energies of TTˢ (`q` = 0) or TRTˢ (`q` = 1) of all paths.
    #[inline(always)]
    fn total(&self, q: usize) -> f32x4 {
        let energy = |group: &Group| f32x4::splat(group.times()) * sum(group.energy[q]);
        self.groups().fold(f32x4::ZERO, |total, (group, _)| total + energy(group))
    }

    /// [`SOME`] points on each side.
    #[inline(never)]
    fn prepare_some<R: Route<f32x8>>(&mut self, query: &Query, sides: [Option<Side>; 2], width: f32) {
        // If both sides begin at the axis, one group represents their common part, and another the part that only one
        // of them has.
        let pieces = match sides {
            [Some(a), Some(b)] if !query.prepared.is_flat() => {
                let (shared, rest) = a.overlap(&b);
                [(Some(shared), 1.0, true), (rest, if a.longer_than(&b) { 1.0 } else { -1.0 }, false)]
            }
            [a, b] => [(a, 1.0, false), (b, -1.0, false)],
        };
        let pieces = pieces.into_iter().filter_map(|(side, mirror, twice)| Some((side?, mirror, twice)));
        self.groups = [None; GROUPS];
        for ((group, exits), (side, mirror, twice)) in self.groups.iter_mut().zip(&mut self.exits).zip(pieces) {
            let group = group.insert(Group::none());
            group.prepare_some::<R>(query, side, mirror, width, exits);
            group.twice = twice;
        }
    }

    /// Draws sin θᵢ, cos θᵢ and φ of TTˢ (`q` = 0) or TRTˢ (`q` = 1) with the density of [`Points::eval`]. The first
    /// number of `u` selects the path, the next two θᵢ, and the last the azimuth.
    pub fn draw(&self, medulla: &Medulla, inclination: &Inclination, q: usize, u: [f32; 4]) -> ((f32, f32), f32) {
        let energy = |group: &Group| group.energy[q][3].to_array();
        let total: f32 = self.groups().map(|(group, _)| group.times() * energy(group).iter().sum::<f32>()).sum();
        let paths = self.groups().flat_map(|(group, exits)| {
            let lanes = energy(group).into_iter().enumerate();
            lanes.map(move |(lane, energy)| ((group, exits, lane), energy * group.times()))
        });
        let Some(choice) = choose(paths, u[0] * total) else { return ((0.0, 1.0), 0.0) };
        let ((group, exits, lane), t) = (choice.item, choice.fraction());
        let (flip, t) = match (group.twice, t < 0.5) {
            (true, true) => (1.0, 2.0 * t),
            (true, false) => (-1.0, 2.0 * t - 1.0),
            (false, _) => (1.0, t),
        };
        // Select one of the azimuths over which the path's light is spread.
        let exits = exits.iter().map(|exit| (exit, exit.share.to_array()[lane]));
        let exit = choose(exits, t).map_or(&group.exit, |choice| choice.item);
        let turned = group.turned.to_array()[lane];
        let (theta, relative) = medulla.sample_leaving(&group.weights[lane], turned, inclination, [u[1], u[2], u[3]]);
        let psi = relative + exit.azimuth.to_array()[lane];
        let phi = if self.turning { exit.turn.leaving(lane, psi) } else { psi };
        (theta, flip * group.mirror.to_array()[lane] * phi)
    }

    /// TTˢ and TRTˢ at φ, as densities over solid angle. `m` is C^M of the backward and the forward half.
    #[inline(always)]
    pub fn eval(&self, medulla: &Medulla, around: [f32; 3], m: [f32; 2]) -> [f32x4; 2] {
        if self.plain {
            self.sum(around, |group, _, around| {
                let [relative, slope] = around.inside(&group.exit, self.turning);
                slope * group.density(medulla, relative, m)
            })
        } else {
            self.eval_spread(medulla, around, m)
        }
    }

    #[inline(never)]
    fn eval_spread(&self, medulla: &Medulla, around: [f32; 3], m: [f32; 2]) -> [f32x4; 2] {
        self.sum(around, |group, exits, around| group.spread_density(medulla, exits, self.turning, around, m))
    }

    /// The sum over all groups of energy times density at φ, given with its cosine and sine.
    #[inline(always)]
    fn sum(&self, [phi, cos, sin]: [f32; 3], density: impl Fn(&Group, &[Exit], &Around) -> f32x8) -> [f32x4; 2] {
        let mut lobes = [[f32x8::ZERO; 4]; 2];
        for (group, exits) in self.groups() {
            for sign in &[1.0, -1.0][..1 + usize::from(group.twice)] {
                let mirror = group.mirror * f32x8::splat(*sign);
                let splat = f32x8::splat;
                let around = Around([splat(phi) * mirror, splat(cos), splat(sin) * mirror]);
                let density = density(group, exits, &around);
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
