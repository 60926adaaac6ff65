//! The tables and prepared fibres as plain rows of four numbers, for shaders.
//!
//! A shader reads the tables from one buffer and the prepared fibres from another. [`tables()`] returns the first with
//! the position of each part, and [`fiber()`] the rows of one fibre. [`color()`] returns what a fibre needs for other
//! absorption at each hit, and [`far()`] its far field as a table. The order of the numbers is not stable.

use crate::error::{Error, shortest};
use crate::fiber::Fiber;
use wide::f32x8;

mod color;
mod far;
mod fiber;
mod tables;

pub use color::{COATS, COLOR_LAYOUT, COLOR_ROWS, color};
pub use far::{FarTable, far};
pub use fiber::{FIBER_LAYOUT, FIBER_ROWS, fiber};
pub use tables::{PackedTables, tables};

/// The parts of a record: the name, the number of rows, and what they are.
type Layout = &'static [(&'static str, usize, &'static str)];

/// The number of rows of a record.
const fn count(layout: Layout) -> usize {
    let (mut rows, mut part) = (0, 0);
    while part < layout.len() {
        rows += layout[part].1;
        part += 1;
    }
    rows
}

/// A record that is filled part by part.
struct Record<const ROWS: usize> {
    layout: Layout,
    rows: [[f32; 4]; ROWS],
    filled: usize,
}

impl<const ROWS: usize> Record<ROWS> {
    fn new(layout: Layout) -> Self {
        Record { layout, rows: [[0.0; 4]; ROWS], filled: 0 }
    }

    /// The next part.
    fn put(&mut self, name: &str, values: &[[f32; 4]]) {
        if let Some(((expected, rows, _), rest)) = self.layout.split_first() {
            assert_eq!((name, values.len()), (*expected, *rows), "as the layout says");
            self.layout = rest;
        }
        self.rows[self.filled..self.filled + values.len()].copy_from_slice(values);
        self.filled += values.len();
    }
}

/// Registers of eight numbers as rows of four.
fn pairs(weights: &[f32x8]) -> Vec<[f32; 4]> {
    let halves = |eight: &f32x8| {
        let [a, b, c, d, e, f, g, h] = eight.to_array();
        [[a, b, c, d], [e, f, g, h]]
    };
    weights.iter().flat_map(halves).collect()
}

/// Checks that shaders have the scattering of a fibre.
///
/// # Errors
/// [`Error::OutOfRange`] if its section is not a circle of one index.
pub fn supports(fiber: &Fiber) -> Result<(), Error> {
    let refuse = |name: &str, value: f32, range: &str| {
        Err(Error::OutOfRange { name: name.to_owned(), value: shortest(value), range: range.to_owned() })
    };
    if fiber.aspect_ratio < 1.0 {
        return refuse("aspect_ratio", fiber.aspect_ratio, "it must be 1, because shaders have round fibres only");
    }
    if fiber.medulla_air > 0.0 {
        return refuse("medulla_air", fiber.medulla_air, "it must be 0: shaders have medullas without air only");
    }
    Ok(())
}
