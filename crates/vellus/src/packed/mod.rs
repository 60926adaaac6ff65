//! The tables and prepared fibres as plain rows of four numbers, for shaders.
//!
//! A shader reads the tables from one buffer and the prepared fibres from another. [`tables()`] returns the first with
//! the position of each part, and [`fiber()`] the rows of one fibre. [`far()`] returns the far field of one fibre as a
//! table. The order of the numbers is not stable.

use crate::error::{Error, shortest};
use crate::fiber::Fiber;

mod far;
mod fiber;
mod tables;

pub use far::{FarTable, far};
pub use fiber::{FIBER_LAYOUT, FIBER_ROWS, fiber};
pub use tables::{PackedTables, tables};

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
