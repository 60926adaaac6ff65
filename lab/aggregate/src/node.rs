//! All that an aggregate scatters at one inclination of ω_o.

use crate::chain::{Chain, Collision};
use crate::grid::Grid;
use crate::longitudinal::Longitudinal;
use crate::member::{LOBES, Member, NARROW, OUTGOING, Roughness, SPECULAR, TILT, circle, width};
use crate::orders::{AZIMUTHS, COUNTS, GROUPS, Multiple, Orders, group};
use crate::piecewise::Piecewise;
use vellus::{Fiber, Lobe, Lobes};

/// Red, green, blue, and the largest of them, which samples are drawn from.
pub(crate) const CHANNELS: usize = 4;

/// Parts that a sample is drawn from: seven lobes of single scattering, and for each group of multiple scattering the
/// light in narrow lobes and the other light.
pub(crate) const PARTS: usize = LOBES + 2 * GROUPS;

/// The tables of one inclination. A row has the values of all channels of all lobes or groups at one node.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    /// Single scattering over azimuth.
    pub single: Vec<[f32; LOBES * CHANNELS]>,
    /// Multiple scattering over azimuth: densities times the energy of light in narrow lobes.
    pub narrow: Vec<[f32; GROUPS * CHANNELS]>,
    /// The densities alone.
    pub around: Vec<[f32; GROUPS * CHANNELS]>,
    /// Multiple scattering of the other light, in sin θᵢ.
    pub broad: Vec<[f32; GROUPS * CHANNELS]>,
    /// Light that a medulla scattered once, in sin θᵢ: back and forward.
    pub scattered: Vec<[f32; 2]>,
    /// Shift and variance of each group, in radians.
    pub widths: [[f32; 2]; GROUPS],
    /// The energy of each lobe, RGB.
    pub energy: Lobes,
    /// The integral of the fourth channel of each part.
    pub weights: [f32; PARTS],
    /// What samples are drawn from.
    pub sampling: Sampling,
}

/// Densities of the fourth channel.
#[derive(Clone, Debug)]
pub(crate) struct Sampling {
    /// Over azimuth: [`Node::single`], [`Node::narrow`] and [`Node::around`].
    pub azimuths: [Piecewise; PARTS],
    /// Over sin θᵢ: [`Node::broad`].
    pub broad: [Piecewise; GROUPS],
    /// Over sin θᵢ: [`Node::scattered`].
    pub scattered: [Piecewise; 2],
}

/// Sums of one group of numbers of collisions.
#[derive(Clone)]
struct Group {
    narrow: [f64; 3],
    broad: [Vec<f64>; 3],
    /// Weighted sums of 1, k and k².
    moments: [f64; 3],
}

/// What all nodes share.
pub(crate) struct Source<'a> {
    pub fiber: &'a Fiber,
    pub members: &'a [Member],
    pub collision: &'a Collision,
    /// E₁ at the azimuths of single scattering.
    pub once: &'a [f64],
    pub orders: &'a Orders,
    /// The optical diameter for light inside.
    pub tau: f64,
    pub roughness: Roughness,
    pub grid: &'a Grid,
}

impl Node {
    /// The tables for ω_o at the inclination `k`.
    pub fn new(source: &Source<'_>, k: usize) -> Self {
        let member = &source.members[k];
        let single = member.azimuths.iter().zip(source.once).map(|(lobes, leaves)| {
            let mut row = [0.0; LOBES * CHANNELS];
            for (lobe, rgb) in lobes.iter().enumerate() {
                channels(&mut row[lobe * CHANNELS..], rgb.map(|x| x * leaves));
            }
            row
        });
        let multiple = [0, 1, 2].map(|c| source.orders.at(source.tau, source.mean_cosine(k, c)));
        let groups = source.groups(k, &multiple);
        let row = |f: &dyn Fn(usize, usize) -> f64| {
            let mut row = [0.0; GROUPS * CHANNELS];
            (0..GROUPS).for_each(|g| channels(&mut row[g * CHANNELS..], [0, 1, 2].map(|c| f(g, c))));
            row
        };
        let density = |i: usize| row(&|g, c| multiple[c].azimuths[g][i]);
        let narrow = |i: usize| row(&|g, c| multiple[c].azimuths[g][i] * groups[g].narrow[c]);
        let broad = |i: usize| row(&|g, c| groups[g].broad[c][i] / width(i));
        let scattered = |i: usize| [0, 1].map(|half| member.scattered[half][i] as f32);
        let (single, narrow, around): (Vec<_>, Vec<_>, Vec<_>) =
            (single.collect(), (0..AZIMUTHS).map(narrow).collect(), (0..AZIMUTHS).map(density).collect());
        let (broad, scattered): (Vec<_>, Vec<_>) =
            ((0..OUTGOING).map(broad).collect(), (0..OUTGOING).map(scattered).collect());
        let sampling = Sampling::new(source.grid, &single, &narrow, &around, &broad, &scattered);
        Node {
            energy: energy(&single, &narrow, &around, &broad),
            weights: sampling.weights(),
            widths: std::array::from_fn(|g| moments(source, member, &groups[g])),
            single,
            narrow,
            around,
            broad,
            scattered,
            sampling,
        }
    }
}

impl Source<'_> {
    /// The mean cosine of a collision's angle, for one channel: the mean of this inclination and of the next one's.
    fn mean_cosine(&self, k: usize, channel: usize) -> f64 {
        let cosine = |member: &Member| {
            let last = (member.azimuths.len() - 1) as f64;
            let sum = member.around(channel, |i| -(i as f64 / last * std::f64::consts::PI).cos());
            sum / member.albedo(channel).max(f64::MIN_POSITIVE)
        };
        let next = self.collision.next(self.members, k, channel);
        let total: f64 = next.iter().sum();
        let mean: f64 = next.iter().zip(self.members).map(|(share, member)| share * cosine(member)).sum();
        0.5 * (cosine(&self.members[k]) + mean / total.max(f64::MIN_POSITIVE))
    }

    fn groups(&self, k: usize, multiple: &[Multiple; 3]) -> Vec<Group> {
        let empty = Group { narrow: [0.0; 3], broad: std::array::from_fn(|_| vec![0.0; OUTGOING]), moments: [0.0; 3] };
        let mut groups = vec![empty; GROUPS];
        let member = &self.members[k];
        for c in 0..3 {
            let leaves = member.around(c, |i| self.once[i]) / member.albedo(c).max(f64::MIN_POSITIVE);
            let chain = Chain::new(self.collision, self.members, k, c);
            let counts = &multiple[c].counts;
            for (i, share) in counts.iter().enumerate() {
                // The last entry is all further collisions, whose shares fall like a geometric series.
                let falling = (i == COUNTS - 1).then(|| share / (counts[i - 1] + share).max(f64::MIN_POSITIVE));
                let after = chain.after(i + 2, falling);
                let group = &mut groups[group(i + 2)];
                let weight = (1.0 - leaves).max(0.0) * share;
                group.narrow[c] += weight * after.narrow;
                group.broad[c].iter_mut().zip(&after.broad).for_each(|(sum, x)| *sum += weight * x);
                let number = (i + 2) as f64;
                let moment = weight * after.narrow;
                group.moments.iter_mut().zip([1.0, number, number * number]).for_each(|(sum, x)| *sum += moment * x);
            }
        }
        groups
    }
}

/// Three channels and their maximum.
fn channels(row: &mut [f32], rgb: [f64; 3]) {
    (0..3).for_each(|c| row[c] = rgb[c] as f32);
    row[3] = row[0].max(row[1]).max(row[2]);
}

/// Shift and variance of light in narrow lobes after the collisions of a group: k times those of one collision, and the
/// variance of the shift k ᾱ.
fn moments(source: &Source<'_>, member: &Member, group: &Group) -> [f32; 2] {
    let energies: [f64; NARROW] = std::array::from_fn(|p| (0..3).map(|c| member.narrow(c)[p]).sum());
    let total: f64 = energies.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let alpha = |p: usize| SPECULAR[p].1 * f64::from(source.fiber.alpha);
    let mean = |f: &dyn Fn(usize) -> f64| (0..NARROW).map(|p| energies[p] / total * f(p)).sum::<f64>();
    let shift = mean(&alpha);
    let variance = mean(&|p| member.variance(p, source.roughness) + (alpha(p) - shift).powi(2));
    let [weight, first, second] = group.moments;
    let (first, second) = if weight > 0.0 { (first / weight, second / weight) } else { (2.0, 4.0) };
    let variance = first * variance + (second - first * first).max(0.0) * shift * shift;
    // Without light in narrow lobes, the width does not matter.
    [(first * shift) as f32, variance.max((0.5 * source.roughness.beta_m).powi(2)) as f32]
}

/// The energy of each lobe. All multiple scattering is reported as the rest lobe.
fn energy(
    single: &[[f32; LOBES * CHANNELS]],
    narrow: &[[f32; GROUPS * CHANNELS]],
    around: &[[f32; GROUPS * CHANNELS]],
    broad: &[[f32; GROUPS * CHANNELS]],
) -> Lobes {
    let mut energy = [[0.0; 3]; 6];
    for (lobe, c) in (0..3 * LOBES).map(|i| (i / 3, i % 3)) {
        energy[lobe.min(Lobe::Rest as usize)][c] +=
            circle(single.iter().map(|row| f64::from(row[lobe * CHANNELS + c])));
    }
    for (group, c) in (0..3 * GROUPS).map(|i| (i / 3, i % 3)) {
        let i = group * CHANNELS + c;
        let along: f64 = broad.iter().enumerate().map(|(k, row)| width(k) * f64::from(row[i])).sum();
        energy[Lobe::Rest as usize][c] += circle(narrow.iter().map(|row| f64::from(row[i])))
            + circle(around.iter().map(|row| f64::from(row[i]))) * along;
    }
    Lobes(energy.map(|rgb| rgb.map(|x| x as f32)))
}

impl Sampling {
    fn new(
        grid: &Grid,
        single: &[[f32; LOBES * CHANNELS]],
        narrow: &[[f32; GROUPS * CHANNELS]],
        around: &[[f32; GROUPS * CHANNELS]],
        broad: &[[f32; GROUPS * CHANNELS]],
        scattered: &[[f32; 2]],
    ) -> Self {
        let largest = |k: usize| k * CHANNELS + CHANNELS - 1;
        Sampling {
            azimuths: std::array::from_fn(|part| match part {
                0..LOBES => Piecewise::new(&grid.fine, single.iter().map(|row| row[largest(part)]).collect()),
                _ if part < LOBES + GROUPS => {
                    Piecewise::new(&grid.coarse, narrow.iter().map(|row| row[largest(part - LOBES)]).collect())
                }
                _ => {
                    Piecewise::new(&grid.coarse, around.iter().map(|row| row[largest(part - LOBES - GROUPS)]).collect())
                }
            }),
            broad: std::array::from_fn(|g| {
                Piecewise::new(&grid.along, broad.iter().map(|row| row[largest(g)]).collect())
            }),
            scattered: std::array::from_fn(|half| {
                Piecewise::new(&grid.along, scattered.iter().map(|row| row[half]).collect())
            }),
        }
    }

    /// Integrals over the sphere.
    fn weights(&self) -> [f32; PARTS] {
        std::array::from_fn(|part| {
            let along = part.checked_sub(LOBES + GROUPS).map_or(1.0, |group| self.broad[group].total());
            2.0 * self.azimuths[part].total() * along
        })
    }
}

/// The lobes along the fibre for ω_o, with shift and width of the groups blended from two nodes.
pub(crate) fn longitudinal(
    fiber: &Fiber,
    spread: f32,
    [sin_o, cos_o]: [f32; 2],
    nodes: [(&Node, f32); 2],
) -> Longitudinal {
    let blend = |group: usize, i: usize| nodes.iter().map(|(node, weight)| weight * node.widths[group][i]).sum::<f32>();
    let mut lobes = [[0.0; 8]; 3];
    for (i, (_, shift, beta)) in SPECULAR.into_iter().enumerate() {
        lobes[0][i] = shift as f32 * fiber.alpha;
        lobes[1][i] = (beta as f32 * fiber.beta_m).powi(2);
        lobes[2][i] = TILT as f32 * spread * spread;
    }
    for group in 0..GROUPS {
        (0..2).for_each(|k| lobes[k][SPECULAR.len() + group] = blend(group, k));
    }
    Longitudinal::new(sin_o, cos_o, lobes[0], lobes[1], lobes[2])
}
