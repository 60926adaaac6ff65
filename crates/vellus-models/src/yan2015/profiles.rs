//! Scattered light in tables of the published size: those of the project page of Yan et al. 2015, which lists four of
//! 64 × 64 × 16 × 720 numbers, 189 MB each.
//!
//! | table | axes | contents |
//! |---|---|---|
//! | `scattered` | τ, offset, g, φ | C^N |
//! | `scatteredDist` | τ, offset, g, φ | ⟨L⟩ |
//! | `scatteredM` | τ, θ_o, g, θᵢ | C^M: the backward half in the first half of the bins, then the forward half |
//! | `integratedM` | τ, θ_o, g, θᵢ | ∫ C^M cos θ dθ from −90° to the bin, for μ of Eq. 8 |
//!
//! We had no access to the published contents. Here the contents are those of the compressed tables of `vellus`,
//! resampled, so values agree with those of the optimised model within the error of linear interpolation. Nodes are
//! equidistant on the axes of [`vellus::grid`], where that error is small.

use std::f32::consts::{FRAC_PI_2, PI, TAU};
use std::fmt;
use std::sync::OnceLock;
use vellus::parts::{Medulla, wrap};
use vellus::{Fiber, ScatterExit, Tables, grid};

/// Scattered light in four large tables. Equal sizes have equal contents.
pub struct Profiles {
    /// The numbers of nodes of τ, of |h″| or |θ_o|, and of g, and the number of bins of the outgoing angle.
    nodes: [usize; 4],
    azimuthal: Vec<f32>,
    mean_path: Vec<f32>,
    longitudinal: Vec<f32>,
    integrated: Vec<f32>,
}

impl fmt::Debug for Profiles {
    /// Prints the sizes only.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Profiles").field("nodes", &self.nodes).finish_non_exhaustive()
    }
}

impl PartialEq for Profiles {
    fn eq(&self, other: &Self) -> bool {
        self.nodes == other.nodes
    }
}

/// The position of a node in [0, 1].
fn position(node: usize, nodes: usize) -> f32 {
    node as f32 / (nodes - 1) as f32
}

/// The node below x in [0, nodes − 1], and the distance from it. Other x are clamped.
#[inline(always)]
fn between(x: f32, nodes: usize) -> (usize, f32) {
    let x = x.clamp(0.0, (nodes - 1) as f32);
    let below = (x as usize).min(nodes - 2);
    (below, x - below as f32)
}

impl Profiles {
    /// The size of the published tables: nodes of τ, of the offset or θ_o, and of g, and bins of the outgoing angle.
    pub const PUBLISHED: [usize; 4] = [64, 64, 16, 720];

    /// Tables of the published size: 755 MB, filled on first use in a few seconds.
    pub fn published() -> &'static Self {
        static PUBLISHED: OnceLock<Profiles> = OnceLock::new();
        PUBLISHED.get_or_init(|| Profiles::new(Self::PUBLISHED))
    }

    /// Tables of another size, in the order of [`Profiles::PUBLISHED`]. There are at least two nodes, and at least four
    /// bins. The number of bins is even: an odd one is reduced by 1.
    pub fn new([taus, places, gs, bins]: [usize; 4]) -> Self {
        let [taus, places, gs, half] = [taus, places, gs, bins / 2].map(|n| n.max(2));
        let bins = 2 * half;
        let table = || Vec::with_capacity(taus * places * gs * bins);
        let (mut azimuthal, mut mean_path) = (table(), table());
        let (mut longitudinal, mut integrated) = (table(), table());
        let step = PI / (half - 1) as f32;
        let theta = |bin: usize| bin as f32 * step - FRAC_PI_2;
        for node in 0..taus * places * gs {
            let [tau, place, g] = [node / (places * gs), node / gs % places, node % gs];
            let fiber = Fiber {
                kappa: 1.0,
                sigma_ms: grid::tau_at(position(tau, taus).into()) as f32,
                g: grid::g_at(position(g, gs).into()) as f32,
                exit: ScatterExit::Open,
                ..Fiber::hair()
            };
            let medulla = Medulla::new(&fiber, Tables::shipped());
            let angle = FRAC_PI_2 * position(place, places);
            let pass = medulla.pass(medulla.tau_position(1.0f32));
            let azimuth = medulla.azimuth(&pass, angle);
            let phi = |bin: usize| wrap(bin as f32 * (TAU / bins as f32));
            azimuthal.extend((0..bins).map(|bin| medulla.azimuthal(&azimuth, phi(bin))));
            mean_path.extend(std::iter::repeat_n(medulla.mean_path_of(&pass, angle), bins));
            let inclination = medulla.inclination(angle);
            let values: Vec<[f32; 2]> = (0..half).map(|bin| medulla.longitudinal(&inclination, theta(bin))).collect();
            for side in 0..2 {
                longitudinal.extend(values.iter().map(|value| value[side]));
                let weighted = |bin: usize| values[bin][side] * theta(bin).cos();
                let mut sum = 0.0;
                integrated.extend((0..half).map(|bin| {
                    sum += if bin > 0 { 0.5 * step * (weighted(bin - 1) + weighted(bin)) } else { 0.0 };
                    sum
                }));
            }
        }
        Profiles { nodes: [taus, places, gs, bins], azimuthal, mean_path, longitudinal, integrated }
    }

    /// The nodes around positions in [0, 1] on the first three axes.
    fn place(&self, positions: [f32; 3]) -> Place {
        [0, 1, 2].map(|axis| between(positions[axis] * (self.nodes[axis] - 1) as f32, self.nodes[axis]))
    }

    /// Linear interpolation on four axes, between sixteen numbers.
    #[inline]
    fn interpolate(&self, table: &[f32], place: &Place, [low, high]: [usize; 2], t: f32) -> f32 {
        let [(i, a), (j, b), (k, c)] = *place;
        let [_, places, gs, bins] = self.nodes;
        let mut sum = 0.0;
        for corner in 0..8 {
            let [di, dj, dk] = [corner & 1, (corner >> 1) & 1, corner >> 2];
            let row = (((i + di) * places + j + dj) * gs + k + dk) * bins;
            let share = |upper: usize, t: f32| if upper == 1 { t } else { 1.0 - t };
            let weight = share(di, a) * share(dj, b) * share(dk, c);
            sum += weight * (table[row + low] * (1.0 - t) + table[row + high] * t);
        }
        sum
    }
}

/// For each of the first three axes, the node below and the distance from it, in steps.
type Place = [(usize, f32); 3];

/// The tables, and where a hit reads them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reading {
    profiles: &'static Profiles,
    around: Place,
    along: Place,
    /// −1 if the offset or θ_o is negative: the profile is mirrored.
    mirrors: [f32; 2],
    /// μ of both halves of C^M.
    mu: [f32; 2],
}

impl Reading {
    /// `taus` are the positions of τ on the axes of C^N and C^M, and `g` is that of g, in [0, 1]. `angles` are asin h″
    /// and θ_o in the medulla, in radians.
    pub fn new(profiles: &'static Profiles, taus: [f32; 2], angles: [f32; 2], g: f32) -> Self {
        let [around, along] = [0, 1].map(|k| profiles.place([taus[k], angles[k].abs() / FRAC_PI_2, g]));
        let half = profiles.nodes[3] / 2;
        let mu = [half, 2 * half].map(|end| {
            let total = profiles.interpolate(&profiles.integrated, &along, [end - 1, end - 1], 0.0);
            1.0 / total.max(1e-3)
        });
        Reading { profiles, around, along, mirrors: angles.map(|angle| 1f32.copysign(angle)), mu }
    }

    /// C^N per radian, and ⟨L⟩ in radii of the medulla, at an azimuth `phi` from straight back, in [−π, π].
    pub fn around(&self, phi: f32) -> [f32; 2] {
        let Profiles { azimuthal, mean_path, nodes: [.., bins], .. } = self.profiles;
        let phi = phi * self.mirrors[0];
        let x = (if phi < 0.0 { phi + TAU } else { phi }) * (*bins as f32 / TAU);
        let bin = (x as usize).min(bins - 1);
        let pair = [bin, if bin + 1 < *bins { bin + 1 } else { 0 }];
        [azimuthal, mean_path].map(|table| self.profiles.interpolate(table, &self.around, pair, x - bin as f32))
    }

    /// C^M of the backward and the forward half at θᵢ in the medulla: densities in sin θᵢ.
    pub fn along(&self, theta_i: f32) -> [f32; 2] {
        let half = self.profiles.nodes[3] / 2;
        let x = (theta_i * self.mirrors[1] / PI + 0.5) * (half - 1) as f32;
        let (bin, t) = between(x, half);
        [0, 1].map(|side| {
            let pair = [side * half + bin, side * half + bin + 1];
            self.mu[side] * self.profiles.interpolate(&self.profiles.longitudinal, &self.along, pair, t)
        })
    }
}
