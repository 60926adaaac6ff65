//! The parameters of a fibre: Yan17 Table 1, with units, ranges and validation.

pub(crate) mod color;
pub(crate) mod species;

use crate::error::{Error, check};
use crate::fiber::color::Color;
use crate::fiber::species::Species;

/// One fibre, described by the parameters of Yan17 Table 1.
///
/// A plain struct: fill it as you like, from a preset or from scratch. [`Fiber::validate`] names
/// what is out of range, and [`crate::Bcsdf::new`] calls it, so that no query ever fails.
///
/// ```
/// use vellus::{Fiber, Species};
/// let fiber = Fiber { kappa: 0.5, ..Fiber::preset(Species::RedFox) };
/// assert!(fiber.validate().is_ok());
/// ```
///
/// The struct is exhaustive on purpose: `Fiber { kappa, ..preset }` must work in other crates, and code that sets all
/// fields should not compile if a parameter is added. A new parameter is a new major version.
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias = "Table 1")]
pub struct Fiber {
    /// η, refractive index of cortex and medulla. Range [1, 3]; keratin is near 1.55.
    pub eta: f32,
    /// κ, medullary index: radius of the medulla over that of the fibre. Range [0, 0.99];
    /// 0 is a hair without medulla.
    pub kappa: f32,
    /// α, tilt of the cuticle scales in radians. Range [−45°, 45°]. Positive scales open toward
    /// the tip: the R highlight moves toward the root (D11).
    pub alpha: f32,
    /// β_m, longitudinal roughness: standard deviation in radians. Range [0.1°, 90°].
    pub beta_m: f32,
    /// β_n, azimuthal roughness: standard deviation in radians. Range [0.1°, 90°].
    pub beta_n: f32,
    /// σ_c,a, absorption in the cortex, RGB, per fibre radius (D1). Range [0, 1000].
    pub sigma_ca: [f32; 3],
    /// σ_m,s, scattering in the medulla, per fibre radius. Range [0, 1000]. Beyond an optical
    /// radius σ_m,s κ/cos θ_t of 20 the shape of the scattered lobes stays that at 20.
    pub sigma_ms: f32,
    /// σ_m,a, absorption in the medulla, RGB, per fibre radius. Range [0, 1000].
    pub sigma_ma: [f32; 3],
    /// g, Henyey–Greenstein anisotropy of the medulla. Range [0, 0.95].
    pub g: f32,
    /// l, layers of the cuticle. Range [0, 20]. 0.5 is nearly an ordinary dielectric interface,
    /// 1 is one slab, 0 does not reflect.
    pub layers: f32,
}

impl Fiber {
    /// The fit of Yan17 Table 4 for `species`. Absorption is grey, as the measurements are.
    pub fn preset(species: Species) -> Self {
        species.fiber()
    }

    /// A hair without medulla: η 1.55, α 2°, β_m and β_n 7°, one ordinary interface (l = 0.5),
    /// no absorption. A start for [`Fiber::with_color`].
    pub fn hair() -> Self {
        Fiber {
            eta: 1.55,
            kappa: 0.0,
            alpha: 2f32.to_radians(),
            beta_m: 7f32.to_radians(),
            beta_n: 7f32.to_radians(),
            sigma_ca: [0.0; 3],
            sigma_ms: 0.0,
            sigma_ma: [0.0; 3],
            g: 0.0,
            layers: 0.5,
        }
    }

    /// The same fibre with the cortex' absorption set, RGB, per fibre radius.
    pub fn with_absorption(self, sigma_ca: [f32; 3]) -> Self {
        Fiber { sigma_ca, ..self }
    }

    /// The same fibre with the cortex' absorption set from a colour.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a concentration or reflectance outside its range, or a
    /// roughness β_n outside its own (a reflectance depends on it).
    pub fn with_color(self, color: Color) -> Result<Self, Error> {
        Ok(Fiber { sigma_ca: color.absorption(self.beta_n)?, ..self })
    }

    /// The same fibre that neither cortex nor medulla absorbs light in: white fur, furnace tests.
    pub fn without_absorption(self) -> Self {
        Fiber { sigma_ca: [0.0; 3], sigma_ma: [0.0; 3], ..self }
    }

    /// Checks every parameter.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] names the first parameter outside its range, or NaN. Angles are
    /// reported in degrees.
    pub fn validate(&self) -> Result<(), Error> {
        check("eta", self.eta, 1.0, 3.0, "eta must be in [1, 3]")?;
        check("kappa", self.kappa, 0.0, 0.99, "kappa must be in [0, 0.99]")?;
        // Half a millidegree of slack: radians of 0.1° and 90° as f32 may lie just outside.
        let slack = 5e-4;
        check("alpha", self.alpha.to_degrees(), -45.0 - slack, 45.0 + slack, "alpha must be in [-45, 45] degrees")?;
        for (name, beta) in [("beta_m", self.beta_m), ("beta_n", self.beta_n)] {
            check(name, beta.to_degrees(), 0.1 - slack, 90.0 + slack, "a roughness must be in [0.1, 90] degrees")?;
        }
        let sigma = |name: &str, value| check(name, value, 0.0, 1000.0, "must be in [0, 1000] per fibre radius");
        for (c, channel) in ["r", "g", "b"].into_iter().enumerate() {
            sigma(&format!("sigma_ca.{channel}"), self.sigma_ca[c])?;
            sigma(&format!("sigma_ma.{channel}"), self.sigma_ma[c])?;
        }
        sigma("sigma_ms", self.sigma_ms)?;
        check("g", self.g, 0.0, 0.95, "g must be in [0, 0.95]")?;
        check("layers", self.layers, 0.0, 20.0, "layers must be in [0, 20]")
    }
}
