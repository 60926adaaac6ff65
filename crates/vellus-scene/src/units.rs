//! The unit of length and the up axis of a scene.

use crate::error::{Error, invalid};

/// The unit of length and the up axis of a file. Writers store them. Rendering does not depend on them, except that
/// [`crate::Scene::framing`] and [`crate::Scene::front`] use the up axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// Length of a unit in metres; positive.
    pub meters_per_unit: f64,
    /// Whether +z is up. Otherwise +y is up.
    pub z_up: bool,
}

impl Units {
    /// Centimetres with y up: the defaults of USD.
    pub const CENTIMETERS: Units = Units { meters_per_unit: 0.01, z_up: false };

    /// Checks that the unit is finite and positive.
    ///
    /// # Errors
    /// [`Error::Invalid`] if it is not.
    pub fn validate(&self) -> Result<(), Error> {
        let meters = self.meters_per_unit;
        if meters.is_finite() && meters > 0.0 {
            return Ok(());
        }
        Err(invalid("scene", format!("a unit is {meters} metres: it must be finite and positive")))
    }
}
