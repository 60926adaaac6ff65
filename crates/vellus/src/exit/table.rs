//! The table of first exits: where light that the medulla scattered leaves it, and the length of its path.
//!
//! For each τ and g, g fastest, there are [`ROWS`] rows of [`ENTRIES`] values: the probability of each state, then the
//! effective paths ([`absorption_at`]) in radii of the medulla.
//!
//! Layout, little endian: `VELLUSX3`; two u32 (nodes of τ and of g); the CRC-32 of the rest; then half floats. The
//! probabilities, and the logarithms of the effective paths, are matrices of the low ranks [`RANKS`], with a row for
//! each τ and g: first the coordinates of the rows, then the basis. Three numbers for each of [`REACHES`] follow: the
//! offset at which light leaves, see [`ExitData::turns`].

use crate::crc32;
use crate::error::Error;
use crate::exit::cone::Cone;
use crate::exit::low_rank;
use crate::exit::states::{Geometry, STATES};
use crate::half_float;
use crate::medulla::grid;
use crate::medulla::mixture::Between;
use std::sync::OnceLock;
use wide::f32x8;

const MAGIC: &[u8; 8] = b"VELLUSX3";

/// Nodes of the entry: (c, y) with c = √(1 − h″²) and y = sin²θ_t / [`MAX_SIN2`], on the corners and in the middle of
/// the sides of the unit square.
pub const ENTRIES: usize = 8;

/// c and y of the nodes.
#[cfg(any(test, feature = "unstable"))]
pub const NODES: [[f64; 2]; ENTRIES] =
    [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [0.0, 0.5], [1.0, 0.5], [0.0, 1.0], [0.5, 1.0], [1.0, 1.0]];

/// sin²θ_t of the last node.
pub const MAX_SIN2: f64 = 0.9;

/// Absorptions a for which the table has an effective path L(a), with e^(−a L(a)) the mean of e^(−a path).
pub const ABSORPTIONS: usize = 6;

/// Rows for each τ and g.
pub const ROWS: usize = STATES + ABSORPTIONS;

/// The ranks of the probabilities and of the logarithms of the effective paths over τ and g. What they omit is as small
/// as the noise of the simulation.
const RANKS: [usize; 2] = [24, 20];

/// The columns of both matrices.
const COLUMNS: [usize; 2] = [STATES * ENTRIES, ABSORPTIONS * ENTRIES];

/// The absorption, per radius of the medulla, of a node of the effective path.
#[cfg(any(test, feature = "unstable"))]
pub fn absorption_at(node: usize) -> f64 {
    (3f64.powi(node as i32) - 1.0) / 4.0
}

/// Between these ratios of the second effective path to the first, interpolation changes from that of the path, which
/// is right for an exponential distribution of paths, to that of its inverse.
pub const STEEP: [f32; 2] = [0.69, 0.25];

/// [`absorption_at`] in single precision.
const NODE_ABSORPTIONS: [f32; ABSORPTIONS] = [0.0, 0.5, 2.0, 6.5, 20.0, 60.5];

/// The position of an absorption among the nodes. For an exponential distribution of paths, linear interpolation of
/// L(a) at this position is exact to 1 %.
#[inline(always)]
fn absorption_position(a: f32) -> f32 {
    (1.0 + 4.0 * a).ln() * (1.0 / 1.098_612_3)
}

/// The distance between nodes of τ in [`grid::tau_position`]. The nodes continue beyond [`grid::TAU_MAX`].
pub const TAU_STEP: f64 = 1.0 / 12.0;

/// Limits of the offset at which light leaves.
pub const REACHES: [f64; 4] = [0.4, 0.6, 0.8, 1.0];

/// 1, c, y, c², cy, y², c²y, cy²: the polynomials that the nodes determine.
pub fn monomials(c: f64, y: f64) -> [f64; ENTRIES] {
    [1.0, c, y, c * c, c * y, y * y, c * c * y, c * y * y]
}

/// The contents of the file as plain numbers, for code that builds or inspects it.
#[derive(Clone, Debug, PartialEq)]
pub struct ExitData {
    /// Nodes of τ and of g.
    pub nodes: [usize; 2],
    /// [`ROWS`] × [`ENTRIES`] values for each τ and g, g fastest.
    pub values: Vec<f32>,
    /// Coefficients of h″, h″ cos ψ and (1 − h″²) sin ψ in the least-squares fit to h‴, for each τ and g, and for light
    /// with |h‴| up to each of [`REACHES`]. Light enters at h″, and leaves the medulla at h‴ and at the azimuth ψ from
    /// straight on.
    pub turns: Vec<f32>,
}

/// Numbers for the offset at which light leaves, for each τ and g.
const TURNS: usize = 3 * REACHES.len();

impl ExitData {
    /// The bytes of the file.
    #[cfg(any(test, feature = "unstable"))]
    pub fn to_bytes(&self) -> Vec<u8> {
        let rows = self.values.chunks_exact(ROWS * ENTRIES);
        let shares: Vec<f32> = rows.clone().flat_map(|row| row[..COLUMNS[0]].to_vec()).collect();
        let paths: Vec<f32> = rows.flat_map(|row| row[COLUMNS[0]..].iter().map(|x| x.max(1e-6).ln())).collect();
        let matrices = [(shares, 0), (paths, 1)].map(|(matrix, k)| low_rank::compress(&matrix, RANKS[k], COLUMNS[k]));
        let numbers = matrices.iter().flatten().flatten().chain(&self.turns);
        let rest: Vec<u8> = numbers.flat_map(|x| half_float::from_f32(*x)).collect();
        let numbers = [self.nodes[0] as u32, self.nodes[1] as u32, crc32::hash(&rest)];
        MAGIC.iter().copied().chain(numbers.into_iter().flat_map(u32::to_le_bytes)).chain(rest).collect()
    }

    /// Reads the bytes of a file.
    ///
    /// # Errors
    /// [`Error::Table`] if they are not a complete and undamaged file.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        let fail = |what: &str| Err(Error::Table(format!("first exits: {what}")));
        let Some((head, rest)) = bytes.split_first_chunk::<20>() else { return fail("the file is too short") };
        if head[..8] != *MAGIC {
            return fail("it does not begin with VELLUSX3");
        }
        let number = |i: usize| u32::from_le_bytes([head[i], head[i + 1], head[i + 2], head[i + 3]]);
        let nodes = [number(8) as usize, number(12) as usize];
        let count =
            |nodes: usize| nodes * (RANKS[0] + RANKS[1] + TURNS) + RANKS[0] * COLUMNS[0] + RANKS[1] * COLUMNS[1];
        if nodes.iter().any(|n| !(2..=1024).contains(n)) || rest.len() != count(nodes[0] * nodes[1]) * 2 {
            return fail("its size does not match its nodes");
        }
        if crc32::hash(rest) != number(16) {
            return fail("its checksum does not match");
        }
        let mut numbers: Vec<f32> = rest.chunks_exact(2).map(|x| half_float::to_f32([x[0], x[1]])).collect();
        if numbers.iter().any(|x| !x.is_finite()) {
            return fail("a value is not finite");
        }
        let turns = numbers.split_off(count(0) + nodes[0] * nodes[1] * (RANKS[0] + RANKS[1]));
        let paths = numbers.split_off(nodes[0] * nodes[1] * RANKS[0] + RANKS[0] * COLUMNS[0]);
        let [shares, paths] = [(numbers, 0), (paths, 1)].map(|(numbers, k)| {
            let (coordinates, basis) = numbers.split_at(nodes[0] * nodes[1] * RANKS[k]);
            low_rank::expand(coordinates, basis, COLUMNS[k])
        });
        let mut values = Vec::with_capacity(shares.len() + paths.len());
        for (shares, paths) in shares.chunks_exact(COLUMNS[0]).zip(paths.chunks_exact(COLUMNS[1])) {
            values.extend_from_slice(shares);
            // A damaged table that passes its checksum may overflow.
            values.extend(paths.iter().map(|x| x.min(20.0).exp()));
        }
        Ok(ExitData { nodes, values, turns })
    }
}

/// The bytes of the table that ships with this crate.
pub const SHIPPED: &[u8] = include_bytes!("../../data/exit.vellus");

/// 1/ln(1 − [`grid::G_MAX`]).
const LN_G_INVERSE: f32 = -0.333_808_2;

/// The table, decoded.
#[derive(Clone, Debug)]
pub(crate) struct ExitTable {
    nodes: [usize; 2],
    rows: Vec<[f32x8; ROWS]>,
    turns: Vec<[[f32; 3]; REACHES.len()]>,
    pub cone: Cone,
    pub geometry: Geometry,
}

impl ExitTable {
    /// The table that ships with this crate, decoded on first use.
    pub fn shipped() -> &'static ExitTable {
        static TABLE: OnceLock<ExitTable> = OnceLock::new();
        TABLE.get_or_init(|| match ExitData::from_bytes(SHIPPED) {
            Ok(data) => ExitTable::new(&data),
            Err(e) => unreachable!("the embedded table is tested: {e}"),
        })
    }

    /// The data must be valid.
    pub fn new(data: &ExitData) -> Self {
        let rows = data.values.chunks_exact(ROWS * ENTRIES).map(|values| {
            let mut rows = [f32x8::ZERO; ROWS];
            for (row, values) in rows.iter_mut().zip(values.chunks_exact(ENTRIES)) {
                *row = f32x8::new(std::array::from_fn(|i| values[i]));
            }
            // Half floats round. All light must leave.
            let sum = rows[..STATES].iter().fold(f32x8::ZERO, |sum, row| sum + *row);
            rows[..STATES].iter_mut().for_each(|row| *row /= sum);
            rows
        });
        let turns =
            data.turns.chunks_exact(TURNS).map(|x| std::array::from_fn(|k| [x[3 * k], x[3 * k + 1], x[3 * k + 2]]));
        ExitTable {
            nodes: data.nodes,
            rows: rows.collect(),
            turns: turns.collect(),
            cone: Cone::new(),
            geometry: Geometry::new(),
        }
    }

    /// The four nodes around an optical radius τ and an anisotropy g, and their weights.
    #[inline(always)]
    fn around(&self, tau: f32, g: f32) -> [(usize, f32); 4] {
        let [taus, gs] = self.nodes;
        // The positions of `grid` in single precision.
        let position = (1.0 + grid::TAU_SCALE as f32 * tau).ln() * (1.0 / (grid::TAU_GROWTH * TAU_STEP) as f32);
        let tau = Between::new(position, taus);
        let g = Between::new((1.0 - g).ln() * LN_G_INVERSE * (gs - 1) as f32, gs);
        let node = tau.index * gs + g.index;
        [
            (node, (1.0 - tau.t) * (1.0 - g.t)),
            (node + 1, (1.0 - tau.t) * g.t),
            (node + gs, tau.t * (1.0 - g.t)),
            (node + gs + 1, tau.t * g.t),
        ]
    }

    /// The rows at an optical radius τ and an anisotropy g.
    #[inline(always)]
    pub fn rows(&self, tau: f32, g: f32) -> [f32x8; ROWS] {
        let around = self.around(tau, g);
        let [a, b, c, d] = around.map(|(node, _)| &self.rows[node]);
        let [wa, wb, wc, wd] = around.map(|(_, weight)| f32x8::splat(weight));
        let mut rows = [f32x8::ZERO; ROWS];
        for r in 0..ROWS {
            rows[r] = a[r].mul_add(wa, b[r].mul_add(wb, c[r].mul_add(wc, d[r] * wd)));
        }
        rows
    }

    /// The coefficients of [`ExitData::turns`] for light that leaves up to the offset `reach`.
    #[inline(always)]
    pub fn turns(&self, tau: f32, g: f32, reach: f32) -> [f32; 3] {
        let at = Between::new((reach - REACHES[0] as f32) * 5.0, REACHES.len());
        let mut sum = [0.0; 3];
        for (node, weight) in self.around(tau, g) {
            let [low, high] = [&self.turns[node][at.index], &self.turns[node][at.index + 1]];
            (0..3).for_each(|k| sum[k] += weight * (low[k] + at.t * (high[k] - low[k])));
        }
        sum
    }
}

/// The logarithm of what absorption in the medulla leaves of the light of each entry. `a` is σ_ma κ.
#[inline(always)]
pub(crate) fn ln_kept(rows: &[f32x8; ROWS], a: f32) -> f32x8 {
    let at = Between::new(absorption_position(a), ABSORPTIONS);
    let [low, high] = [rows[STATES + at.index], rows[STATES + at.index + 1]];
    let t = f32x8::splat(at.t);
    let mut path = (high - low).mul_add(t, low);
    if at.index == 0 {
        // In a dense medulla the effective path falls fast from its mean, as 1/√a, and its inverse is linear.
        let share = (f32x8::splat(STEEP[0]) - high / low) * f32x8::splat(1.0 / (STEEP[0] - STEEP[1]));
        let inverse = (f32x8::ONE / high - f32x8::ONE / low).mul_add(t, f32x8::ONE / low);
        let share = share.fast_max(f32x8::ZERO).fast_min(f32x8::ONE);
        path = f32x8::ONE / (inverse - f32x8::ONE / path).mul_add(share, f32x8::ONE / path);
    }
    // The product does not exceed that of the next node.
    -(path * f32x8::splat(a)).fast_min(high * f32x8::splat(NODE_ABSORPTIONS[at.index + 1]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a file omits is small, so that the same table, written again, hardly changes.
    #[test]
    fn a_table_survives_being_written_again() {
        let data = ExitData::from_bytes(SHIPPED).unwrap();
        let again = ExitData::from_bytes(&data.to_bytes()).unwrap();
        assert_eq!((again.nodes, &again.turns), (data.nodes, &data.turns));
        for (i, (a, b)) in again.values.iter().zip(&data.values).enumerate() {
            // Coordinates are at most 16 and the basis at most 1: half floats round the products at 2⁻¹².
            let is_path = i % (ROWS * ENTRIES) >= COLUMNS[0];
            assert!((a - b).abs() < if is_path { 0.01 * b } else { 0.002 }, "{i}: {a} {b}");
        }
    }

    #[test]
    fn damaged_files_are_refused() {
        let bytes = SHIPPED;
        assert!(bytes.len() <= 27_000);
        for at in [0, 9, 13, 17, 20, bytes.len() - 1] {
            let mut damaged = bytes.to_vec();
            damaged[at] ^= 1;
            assert!(ExitData::from_bytes(&damaged).is_err(), "{at}");
        }
        assert!(ExitData::from_bytes(&bytes[..bytes.len() - 1]).is_err());
        assert!(ExitData::from_bytes(&bytes[..19]).is_err());
    }
}
