//! The table of multiple scattering: how often light collides, and where it then leaves.
//!
//! Light moves in the section of the bunch, a disc of the optical diameter τ. Each collision turns it by an angle with
//! the mean cosine g. Nothing is absorbed. Among light that collides twice or more, the table holds for each τ and g:
//! - the probability of each number of collisions k, up to [`LAST`], and of more;
//! - for each group of numbers of collisions, the density of the azimuth at which the light leaves.
//!
//! Absorption needs no further dimension: it multiplies the share of each k by the albedos on its way.

use crate::error::Error;
use half::f16;
use std::sync::OnceLock;

/// The largest number of collisions with a probability of its own.
pub(crate) const LAST: usize = 128;

/// Probabilities of 2, 3, …, [`LAST`] collisions, and of more.
pub(crate) const COUNTS: usize = LAST;

/// Groups of numbers of collisions: 2, 3, 4 to 6, and 7 or more.
pub(crate) const GROUPS: usize = 4;

/// Azimuths from 0 (back) to π of a density.
pub(crate) const AZIMUTHS: usize = 49;

/// Optical diameters of the table's nodes.
pub(crate) const TAUS: [f64; 15] = [0.001, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 14.0, 16.0];

/// Mean cosines of the table's nodes.
pub(crate) const COSINES: [f64; 18] =
    [-0.7, -0.5, -0.3, -0.15, 0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.68, 0.75, 0.8, 0.85, 0.89, 0.92, 0.95];

/// Numbers in one node.
const NODE: usize = COUNTS + GROUPS * AZIMUTHS;

/// The first bytes of the file.
const MAGIC: &[u8; 8] = b"VELLUSA1";

/// The group of a number of collisions, which is at least 2.
pub(crate) fn group(collisions: usize) -> usize {
    match collisions {
        0..=2 => 0,
        3 => 1,
        4..=6 => 2,
        _ => 3,
    }
}

/// Multiple scattering for one τ and g.
#[derive(Clone, Debug)]
pub struct Multiple {
    /// Probabilities of 2, 3, … collisions. The last is that of more than can be listed. Their sum is 1.
    pub counts: Vec<f64>,
    /// Densities per radian of the azimuth at which light leaves, for each group of numbers of collisions, at
    /// equidistant azimuths from 0 (back) to π, linear between them. The integral from −π to π is 1.
    pub azimuths: [Vec<f64>; GROUPS],
}

impl Multiple {
    /// From sums of any scale. The shares of an empty group are those of an even distribution.
    pub(crate) fn normalized(mut counts: Vec<f64>, mut azimuths: [Vec<f64>; GROUPS]) -> Self {
        let total: f64 = counts.iter().sum();
        counts.iter_mut().for_each(|x| *x /= total);
        for density in &mut azimuths {
            let step = std::f64::consts::PI / (density.len() - 1) as f64;
            let ends = 0.5 * (density[0] + density[density.len() - 1]);
            let integral = 2.0 * step * (density.iter().sum::<f64>() - ends);
            for x in density.iter_mut() {
                *x = if integral > 0.0 { *x / integral } else { 0.5 * std::f64::consts::FRAC_1_PI };
            }
        }
        Multiple { counts, azimuths }
    }
}

/// The table.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Orders(Vec<f32>);

impl Orders {
    /// The table that this crate contains.
    pub fn shipped() -> Result<&'static Orders, Error> {
        static SHIPPED: OnceLock<Result<Orders, Error>> = OnceLock::new();
        SHIPPED
            .get_or_init(|| Orders::from_bytes(include_bytes!("../data/orders.vellus")))
            .as_ref()
            .map_err(Clone::clone)
    }

    /// Multiple scattering at τ and g, by bilinear interpolation. Both are clamped to the table.
    pub fn at(&self, tau: f64, g: f64) -> Multiple {
        let (row, t) = position(&TAUS, tau);
        let (column, s) = position(&COSINES, g);
        let mut sums = vec![0.0; NODE];
        for (i, j, weight) in
            [(0, 0, (1.0 - t) * (1.0 - s)), (0, 1, (1.0 - t) * s), (1, 0, t * (1.0 - s)), (1, 1, t * s)]
        {
            let start = ((row + i) * COSINES.len() + column + j) * NODE;
            for (sum, x) in sums.iter_mut().zip(&self.0[start..start + NODE]) {
                *sum += weight * f64::from(*x);
            }
        }
        let density = |k: usize| sums[COUNTS + k * AZIMUTHS..COUNTS + (k + 1) * AZIMUTHS].to_vec();
        Multiple::normalized(sums[..COUNTS].to_vec(), std::array::from_fn(density))
    }

    /// Reads the format of [`Orders::to_bytes`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        let broken = |what: String| Err(Error::Table(what));
        let Some(rest) = bytes.strip_prefix(MAGIC) else { return broken("it does not begin with VELLUSA1".to_owned()) };
        let Some((sum, numbers)) = rest.split_first_chunk::<4>() else {
            return broken("it ends in its header".to_owned());
        };
        let expected = TAUS.len() * COSINES.len() * NODE * 2;
        if numbers.len() != expected {
            return broken(format!("it has {} bytes of numbers, not {expected}", numbers.len()));
        }
        if crc32fast::hash(numbers) != u32::from_le_bytes(*sum) {
            return broken("its checksum is wrong".to_owned());
        }
        let values: Vec<f32> = numbers.as_chunks().0.iter().map(|pair| f16::from_le_bytes(*pair).to_f32()).collect();
        if values.iter().any(|x| !x.is_finite() || *x < 0.0) {
            return broken("a number is negative or not finite".to_owned());
        }
        Ok(Orders(values))
    }

    /// The bytes of a table from all nodes: those of the first τ first, with ascending g. The numbers are half floats.
    #[cfg(feature = "simulation")]
    pub fn to_bytes(nodes: &[Multiple]) -> Vec<u8> {
        let numbers: Vec<u8> = nodes
            .iter()
            .flat_map(|node| node.counts.iter().chain(node.azimuths.iter().flatten()))
            .flat_map(|x| f16::from_f64(*x).to_le_bytes())
            .collect();
        [&MAGIC[..], &crc32fast::hash(&numbers).to_le_bytes(), &numbers].concat()
    }
}

/// The node before `x` and the share of the next one.
fn position(nodes: &[f64], x: f64) -> (usize, f64) {
    let k = nodes.partition_point(|node| *node <= x).clamp(1, nodes.len() - 1) - 1;
    (k, ((x - nodes[k]) / (nodes[k + 1] - nodes[k])).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damaged_tables_are_refused() {
        let bytes = include_bytes!("../data/orders.vellus");
        assert!(bytes.len() < 300_000 && Orders::from_bytes(bytes).is_ok());
        for length in [0, 5, 8, 11, 12, bytes.len() - 1] {
            assert!(Orders::from_bytes(&bytes[..length]).is_err(), "{length}");
        }
        let mut changed = bytes.to_vec();
        changed[1000] ^= 1;
        assert!(Orders::from_bytes(&changed).unwrap_err().to_string().contains("checksum"));
    }

    #[test]
    fn densities_are_normalized_everywhere() {
        let table = Orders::shipped().unwrap();
        for (tau, g) in [(0.0, -1.0), (0.1, 0.0), (5.0, 0.93), (16.0, 1.0)] {
            let multiple = table.at(tau, g);
            assert!((multiple.counts.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            for density in &multiple.azimuths {
                let ends = 0.5 * (density[0] + density[AZIMUTHS - 1]);
                let step = std::f64::consts::PI / (AZIMUTHS - 1) as f64;
                assert!((2.0 * step * (density.iter().sum::<f64>() - ends) - 1.0).abs() < 1e-12);
            }
        }
    }
}
