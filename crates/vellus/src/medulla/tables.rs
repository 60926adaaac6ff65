//! The table file: the medulla's scattering profiles as non-negative rank-one sums, in half floats.
//!
//! Layout, little endian:
//! 1. `VELLUSM1`.
//! 2. For each of azimuthal, backward and forward, five u32: the rank, and the numbers of nodes of τ, g, h or θ, and
//!    outgoing angle.
//! 3. Three u32: the numbers of nodes of the mean path in τ, g and h.
//! 4. The CRC-32 of the rest.
//! 5. Half floats: the four factor matrices of each mixture row by row, then the mean path, with h fastest.

use crate::crc32;
use crate::error::Error;
use crate::half_float;
use crate::medulla::cone::Cones;
use crate::medulla::grid::OutgoingAxis;
use crate::medulla::mixture::{Densities, Rows};
use std::sync::OnceLock;

const MAGIC: &[u8; 8] = b"VELLUSM1";

/// Registers of eight components that a mixture can hold.
pub(crate) const AZIMUTHAL: usize = 5;
pub(crate) const BACKWARD: usize = 2;
pub(crate) const FORWARD: usize = 4;

/// The largest number of nodes of h″, a multiple of eight.
pub(crate) const OFFSETS: usize = 16;

/// One compressed profile table: `rank` products of four factors.
#[derive(Clone, Debug, PartialEq)]
pub struct FactorTable {
    /// Number of components.
    pub rank: usize,
    /// Factors over τ, over g, over h″ or θ, and over the outgoing angle; each `nodes × rank`.
    pub factors: [Vec<f32>; 4],
}

impl FactorTable {
    fn nodes(&self, mode: usize) -> usize {
        self.factors[mode].len() / self.rank
    }
}

/// The contents of a table file as plain numbers, for code that builds or inspects tables.
#[derive(Clone, Debug, PartialEq)]
pub struct TableData {
    /// C^N over (τ, g, h″, φ).
    pub azimuthal: FactorTable,
    /// C^M of the backward half over (τ, g, θ_o, θᵢ).
    pub backward: FactorTable,
    /// C^M of the forward half over (τ, g, θ_o, δ).
    pub forward: FactorTable,
    /// ⟨L⟩ over (τ, g, h″), h fastest, in radii of the medulla.
    pub mean_path: Vec<f32>,
    /// Nodes of the mean path. Those over τ and h″ are the nodes of `azimuthal`.
    pub mean_path_nodes: [usize; 3],
}

impl TableData {
    fn mixtures(&self) -> [(&'static str, &FactorTable, usize); 3] {
        [
            ("azimuthal", &self.azimuthal, 8 * AZIMUTHAL),
            ("backward", &self.backward, 8 * BACKWARD),
            ("forward", &self.forward, 8 * FORWARD),
        ]
    }

    /// Encodes the tables in the format of a file.
    ///
    /// # Errors
    /// [`Error::Table`] if the data are not valid. The rank may be too large, or sizes do not match, or a value is
    /// negative, not finite, or above the range of a half float.
    #[cfg(feature = "unstable")]
    pub fn to_bytes(&self) -> Result<Vec<u8>, Error> {
        self.validate()?;
        let mut header = MAGIC.to_vec();
        let mut payload = Vec::new();
        let mut push = |values: &[f32]| payload.extend(values.iter().flat_map(|&x| half_float::from_f32(x)));
        for (_, table, _) in self.mixtures() {
            header.extend((table.rank as u32).to_le_bytes());
            for mode in 0..4 {
                header.extend((table.nodes(mode) as u32).to_le_bytes());
                push(&table.factors[mode]);
            }
        }
        header.extend(self.mean_path_nodes.into_iter().flat_map(|n| (n as u32).to_le_bytes()));
        push(&self.mean_path);
        header.extend(crc32::hash(&payload).to_le_bytes());
        header.extend(payload);
        Ok(header)
    }

    /// Reads the bytes of a file.
    ///
    /// # Errors
    /// [`Error::Table`] states the problem.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        let broken = |what: &str| Error::Table(what.to_owned());
        let header = 8 + 4 * (15 + 3 + 1);
        if bytes.get(..8) != Some(MAGIC) {
            return Err(broken("the first eight bytes are not VELLUSM1"));
        }
        let Some((header, payload)) = bytes.split_at_checked(header) else {
            return Err(broken("it ends inside the header"));
        };
        let words: Vec<usize> =
            header[8..].chunks_exact(4).map(|w| u32::from_le_bytes([w[0], w[1], w[2], w[3]]) as usize).collect();
        let (mixtures, rest) = words.split_at(15);
        // Every size is limited before anything is multiplied or allocated.
        if mixtures.iter().chain(&rest[..3]).any(|&n| !(1..=4096).contains(&n)) {
            return Err(broken("a size in the header is outside [1, 4096]"));
        }
        let mixture_len = |m: &[usize]| m[0] * m[1..].iter().sum::<usize>();
        let path_len = rest[0] * rest[1] * rest[2];
        let expected = 2 * (mixtures.chunks_exact(5).map(mixture_len).sum::<usize>() + path_len);
        if payload.len() != expected {
            return Err(Error::Table(format!("{} bytes follow the header, which announces {expected}", payload.len())));
        }
        if crc32::hash(payload) as usize != rest[3] {
            return Err(broken("the checksum does not match: the file is damaged"));
        }
        let mut values = payload.chunks_exact(2).map(|b| half_float::to_f32([b[0], b[1]]));
        let mut take = |n: usize| values.by_ref().take(n).collect::<Vec<f32>>();
        let mut mixture = |m: &[usize]| FactorTable { rank: m[0], factors: [1, 2, 3, 4].map(|k| take(m[0] * m[k])) };
        let data = TableData {
            azimuthal: mixture(&mixtures[..5]),
            backward: mixture(&mixtures[5..10]),
            forward: mixture(&mixtures[10..]),
            mean_path: take(path_len),
            mean_path_nodes: [rest[0], rest[1], rest[2]],
        };
        data.validate()?;
        Ok(data)
    }

    /// Checks ranks, sizes, shared nodes and values.
    ///
    /// # Errors
    /// [`Error::Table`] states the problem.
    pub fn validate(&self) -> Result<(), Error> {
        for (name, table, limit) in self.mixtures() {
            if table.rank == 0 || table.rank > limit {
                return Err(Error::Table(format!("rank {} of the {name} mixture is outside [1, {limit}]", table.rank)));
            }
            for mode in 0..4 {
                let len = table.factors[mode].len();
                if len % table.rank != 0 || table.nodes(mode) < 2 {
                    return Err(Error::Table(format!("factor {mode} of the {name} mixture has {len} values")));
                }
            }
        }
        let product = self.mean_path_nodes.iter().try_fold(1usize, |product, &n| product.checked_mul(n));
        if Some(self.mean_path.len()) != product || self.mean_path_nodes.iter().any(|&n| n < 2) {
            return Err(Error::Table("the mean path's size does not match its nodes".to_owned()));
        }
        if self.mean_path_nodes[2] > OFFSETS {
            let nodes = self.mean_path_nodes[2];
            return Err(Error::Table(format!(
                "{nodes} nodes of the offset are more than the {OFFSETS} there is room for"
            )));
        }
        // A query computes each position once for all tables.
        let [azimuthal, backward, forward] =
            self.mixtures().map(|(_, table, _)| [0, 1, 2].map(|mode| table.nodes(mode)));
        let [path_tau, _, path_h] = self.mean_path_nodes;
        if backward != forward || azimuthal[..2] != forward[..2] || [path_tau, path_h] != [azimuthal[0], azimuthal[2]] {
            return Err(Error::Table("the tables do not share their nodes".to_owned()));
        }
        let all = self.mixtures().into_iter().flat_map(|(_, t, _)| t.factors.iter().flatten());
        // Half floats are finite up to 65504.
        match all.chain(&self.mean_path).find(|x| !(0.0..=65504.0).contains(*x)) {
            Some(x) => Err(Error::Table(format!("value {x} is outside [0, 65504]"))),
            None => Ok(()),
        }
    }
}

/// A mixture prepared for queries.
#[derive(Clone, Debug)]
pub(crate) struct Mixture<const C: usize> {
    /// Factors over τ, g and h″ or θ.
    pub factors: [Rows<C>; 3],
    pub densities: Densities<C>,
}

impl<const C: usize> Mixture<C> {
    fn new(table: &FactorTable, axis: OutgoingAxis, weighted: bool) -> Self {
        let rows = |mode: usize| Rows::new(&table.factors[mode], table.rank);
        let step = axis.step(table.nodes(3));
        Mixture {
            factors: [rows(0), rows(1), rows(2)],
            densities: Densities::new(&table.factors[3], table.rank, axis.first, step, weighted),
        }
    }
}

/// The medulla tables, decoded for queries.
#[derive(Clone, Debug)]
pub struct Tables {
    pub(crate) azimuthal: Mixture<AZIMUTHAL>,
    pub(crate) backward: Mixture<BACKWARD>,
    pub(crate) forward: Mixture<FORWARD>,
    pub(crate) mean_path: Vec<f32>,
    /// The same, with a row of all h″ for each τ and g.
    pub(crate) mean_path_rows: Rows<{ OFFSETS / 8 }>,
    pub(crate) mean_path_nodes: [usize; 3],
    /// For fibres with [`ScatterExit::Reflecting`](crate::ScatterExit::Reflecting), made on first use.
    cones: OnceLock<Cones>,
}

impl Tables {
    /// The bytes of the tables that ship with this crate.
    pub const SHIPPED: &[u8] = include_bytes!("../../data/medulla.vellus");

    /// The tables that ship with this crate, decoded on first use.
    pub fn shipped() -> &'static Tables {
        static SHIPPED: OnceLock<Tables> = OnceLock::new();
        SHIPPED.get_or_init(|| match Tables::from_bytes(Self::SHIPPED) {
            Ok(tables) => tables,
            Err(e) => unreachable!("the embedded tables are tested: {e}"),
        })
    }

    /// Decodes the bytes of a table file.
    ///
    /// # Errors
    /// [`Error::Table`] if the bytes are not a complete and undamaged table file.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        TableData::from_bytes(bytes).map(|data| Tables::decode(&data))
    }

    /// Prepares tables from their numbers.
    ///
    /// # Errors
    /// As [`TableData::validate`].
    #[cfg(feature = "unstable")]
    pub fn new(data: &TableData) -> Result<Self, Error> {
        data.validate()?;
        Ok(Tables::decode(data))
    }

    /// The data must be valid.
    fn decode(data: &TableData) -> Self {
        Tables {
            azimuthal: Mixture::new(&data.azimuthal, OutgoingAxis::AZIMUTH, false),
            backward: Mixture::new(&data.backward, OutgoingAxis::BACKWARD, true),
            forward: Mixture::new(&data.forward, OutgoingAxis::FORWARD, true),
            mean_path: data.mean_path.clone(),
            mean_path_rows: Rows::new(&data.mean_path, data.mean_path_nodes[2]),
            mean_path_nodes: data.mean_path_nodes,
            cones: OnceLock::new(),
        }
    }

    /// The integrals of C^M over escape cones.
    pub(crate) fn cones(&self) -> &Cones {
        self.cones.get_or_init(|| Cones::new(&self.backward, &self.forward))
    }
}
