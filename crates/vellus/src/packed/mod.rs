//! The tables and prepared fibres as plain rows of four numbers, for shaders.
//!
//! A shader reads the tables from one buffer and the prepared fibres from another. [`tables()`] returns the first with
//! the position of each part, and [`fiber()`] the rows of one fibre. [`far()`] returns the far field of one fibre as a
//! table. The order of the numbers is not stable.

mod far;
mod fiber;
mod tables;

pub use far::{FarTable, far};
pub use fiber::{FIBER_LAYOUT, FIBER_ROWS, fiber};
pub use tables::{PackedTables, tables};
