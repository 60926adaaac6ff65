//! The tables of the medulla.

use crate::coat::{LEAST, STEP};
use crate::exit::entries;
use crate::half_float;
use crate::medulla::cone::{Cones, Half};
use crate::medulla::grid;
use crate::medulla::grid::SHIFTS;
use crate::medulla::mixture::{Densities, Rows, Weights};
use crate::medulla::tables::{Mixture, Tables};

/// The tables, and where each part begins.
#[derive(Clone, Debug)]
pub struct PackedTables {
    /// All numbers, in rows of four.
    pub rows: Vec<[f32; 4]>,
    /// Positions of parts (in rows) and numbers of nodes, by name.
    pub counts: Vec<(String, u32)>,
    /// Constants of the axes, by name.
    pub constants: Vec<(String, f32)>,
}

/// Packs all tables that a query in the near field reads.
pub fn tables(tables: &Tables) -> PackedTables {
    let mut packed = PackedTables { rows: Vec::new(), counts: Vec::new(), constants: Vec::new() };
    let Cones { backward, forward } = tables.cones();
    // A prepared fibre has the factors of τ and g, except for the τ of C^N, which depends on the inclination.
    packed.rows("AZIMUTH_TAU", &tables.azimuthal.factors[0]);
    packed.mixture("AZIMUTH", &tables.azimuthal);
    packed.mixture("BACKWARD", &tables.backward);
    packed.mixture("FORWARD", &tables.forward);
    let [whole, ahead] = &tables.azimuthal.densities.columns;
    packed.numbers("AZIMUTH_COLUMNS", whole.iter().zip(ahead).flat_map(|(whole, ahead)| [*whole, *ahead]));
    packed.weights("AZIMUTH_AHEAD", &[*tables.azimuthal.densities.forward()]);
    packed.weights("BACKWARD_TOTAL", &[*tables.backward.densities.integrals.row(1)]);
    packed.rows("FORWARD_INTEGRALS", &tables.forward.densities.integrals);
    packed.half("BACKWARD", backward);
    packed.half("FORWARD", forward);
    let pairs: Vec<Weights<8>> = forward
        .integrals
        .iter()
        .map(|[whole, lost]| std::array::from_fn(|c| if c < 4 { whole[c] } else { lost[c - 4] }))
        .collect();
    packed.weights("CONE_INTEGRALS", &pairs);
    let [_, n_g, n_h] = tables.mean_path_nodes;
    packed.numbers("MEAN_PATH", tables.mean_path.iter().copied());
    packed.count("MEAN_PATH_G_NODES", n_g);
    packed.count("MEAN_PATH_H_NODES", n_h);
    packed.count("CONE_SHIFTS", SHIFTS);
    let (states, nodes) = entries();
    packed.numbers("EXIT_STATES", states.into_iter().flatten());
    packed.weights("EXIT_NODES", &[nodes]);
    packed.constant("COAT_LEAST", f64::from(LEAST));
    packed.constant("COAT_STEP", f64::from(STEP));
    packed.constant("TAU_SCALE", grid::TAU_SCALE);
    packed.constant("TAU_GROWTH_INVERSE", 1.0 / grid::TAU_GROWTH);
    packed.constant("THETA_MAX_INVERSE", 1.0 / grid::THETA_MAX);
    packed.constant("MIRROR_REACH_INVERSE", f64::from(grid::MIRROR_REACH_INVERSE));
    packed
}

impl PackedTables {
    /// The rows in half precision.
    pub fn half_precision(&self) -> Vec<[u16; 4]> {
        self.rows.iter().map(|row| row.map(|x| u16::from_le_bytes(half_float::from_f32(x)))).collect()
    }

    fn count(&mut self, name: &str, count: usize) {
        // Tables have at most 4096 nodes of 40 numbers.
        self.counts.push((name.to_owned(), u32::try_from(count).unwrap_or(u32::MAX)));
    }

    fn constant(&mut self, name: &str, value: f64) {
        self.constants.push((name.to_owned(), value as f32));
    }

    /// Notes where a part begins.
    fn begin(&mut self, name: &str) {
        self.count(name, self.rows.len());
    }

    /// Numbers one after another. The last row is filled with 0.
    fn numbers(&mut self, name: &str, numbers: impl IntoIterator<Item = f32>) {
        self.begin(name);
        let numbers: Vec<f32> = numbers.into_iter().collect();
        self.rows.extend(numbers.chunks(4).map(|chunk| std::array::from_fn(|i| chunk.get(i).copied().unwrap_or(0.0))));
    }

    /// Each register takes two rows.
    fn weights<const C: usize>(&mut self, name: &str, weights: &[Weights<C>]) {
        self.numbers(name, weights.iter().flatten().flat_map(|eight| eight.to_array()));
    }

    fn rows<const C: usize>(&mut self, name: &str, rows: &Rows<C>) {
        let all: Vec<Weights<C>> = (0..rows.nodes()).map(|node| *rows.row(node)).collect();
        self.weights(name, &all);
        self.count(&format!("{name}_NODES"), rows.nodes());
    }

    fn mixture<const C: usize>(&mut self, name: &str, mixture: &Mixture<C>) {
        let [_, _, offset] = &mixture.factors;
        self.rows(&format!("{name}_OFFSET"), offset);
        self.densities(name, &mixture.densities);
    }

    /// The nodes of the densities. Only C^N is inverted by its own columns: C^M uses those of its cones.
    fn densities<const C: usize>(&mut self, name: &str, densities: &Densities<C>) {
        self.rows(&format!("{name}_VALUES"), &densities.values);
        self.constant(&format!("{name}_FIRST"), f64::from(densities.first));
        self.constant(&format!("{name}_STEP"), f64::from(densities.step));
        self.constant(&format!("{name}_STEP_INVERSE"), f64::from(densities.inv_step));
    }

    /// Six columns of each node and component, and the sines and cosines of the nodes.
    fn half<const C: usize>(&mut self, name: &str, half: &Half<C>) {
        self.numbers(&format!("{name}_CONE_COLUMNS"), half.columns.iter().flatten().copied());
        self.numbers(&format!("{name}_TURNS"), half.turns.iter().flatten().copied());
    }
}
