//! What lengths and directions of a scene mean.

use crate::error::{Error, invalid};

/// The unit of length, and which way is up, as a file says it. Nothing is computed with it: it is handed on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// Metres in a unit of length; positive.
    pub meters_per_unit: f64,
    /// Does +z point up, rather than +y?
    pub z_up: bool,
}

impl Units {
    /// Centimetres, y up: what USD takes where a file says nothing.
    pub const CENTIMETERS: Units = Units { meters_per_unit: 0.01, z_up: false };

    /// Checks that the unit is finite and positive.
    ///
    /// # Errors
    /// [`Error::Invalid`] says what it is.
    pub fn validate(&self) -> Result<(), Error> {
        let meters = self.meters_per_unit;
        if meters.is_finite() && meters > 0.0 {
            return Ok(());
        }
        Err(invalid("scene", format!("a unit is {meters} metres: it must be finite and positive")))
    }
}
