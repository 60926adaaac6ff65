//! What a fibre needs for other absorption at each hit.

use crate::bcsdf::Bcsdf;
use crate::coat::{CoatColors, NODES};
use crate::exit::Chain;
use crate::exit::states::STATES;
use crate::exit::table::{ABSORPTIONS, ExitTable, ROWS};
use crate::medulla::cone::Gain;
use crate::packed::{Record, count, pairs};
use wide::f32x8;

/// The parts of a colour record: the name, the number of rows, and what they are.
pub const COLOR_LAYOUT: [(&str, usize, &str); 5] = [
    ("COLOR_GAIN", 1, "of the backward half: constant, slope, how it shrinks, isotropic optical radius"),
    ("COLOR_STATES", STATES, "transmittance, path in the cortex, scattered share, excess"),
    ("COLOR_FIRST", 2 * STATES, "probability of each state at the nodes of the entry"),
    ("COLOR_PATHS", 2 * ABSORPTIONS, "effective paths in the medulla at the nodes of the entry"),
    (
        "COLOR_COATS",
        (COATS + 3).div_ceil(4),
        "colours of coats; the darkest absorption, medulla_pigment, and the factor of water",
    ),
];

/// The number of colours of coats. Three numbers more fill the last row.
pub const COATS: usize = NODES;

/// The number of rows of a colour record.
pub const COLOR_ROWS: usize = count(&COLOR_LAYOUT);

/// What a shader needs beside the record of a fibre to give it other absorption at each hit, in rows of four numbers:
/// see [`COLOR_LAYOUT`]. It does not depend on the absorption of the fibre.
pub fn color(bcsdf: &Bcsdf<'_>) -> [[f32; 4]; COLOR_ROWS] {
    let prepared = bcsdf.prepared();
    let fiber = &prepared.in_air;
    let mut record = Record::new(&COLOR_LAYOUT);
    let Gain { constant, slope, shrinks, isotropic } = Gain::new(fiber);
    record.put("COLOR_GAIN", &[[constant, slope, shrinks, isotropic]]);
    let (mut states, mut rows) = ([[0.0; 4]; STATES], [f32x8::ZERO; ROWS]);
    if prepared.reflection.is_some() {
        let chain = Chain::new(fiber, ExitTable::shipped());
        let parts = [chain.through, chain.cortex, chain.scattered, chain.excess];
        for (state, row) in states.iter_mut().enumerate() {
            *row = parts.map(|part| part[state / 8].to_array()[state % 8]);
        }
        rows = chain.rows;
    }
    record.put("COLOR_STATES", &states);
    let (first, paths) = rows.split_at(STATES);
    record.put("COLOR_FIRST", &pairs(first));
    record.put("COLOR_PATHS", &pairs(paths));
    let coats = CoatColors::of(&prepared.fiber);
    let more = [coats.most(), fiber.medulla_pigment, prepared.fiber.water_absorption()];
    let numbers: Vec<f32> = coats.colors.into_iter().chain(more).collect();
    record.put("COLOR_COATS", numbers.as_chunks::<4>().0);
    record.rows
}
