//! A fibre: its parameters with names, units and ranges (Yan17 Table 1), its colour, and presets (Table 4).

pub(crate) mod builder;
pub(crate) mod color;
pub(crate) mod exit;
pub(crate) mod parameter;
#[cfg(feature = "serde")]
mod serde;
pub(crate) mod species;
mod wet;

use crate::error::Error;
use crate::fiber::color::Color;
use crate::fiber::exit::ScatterExit;
use crate::fiber::parameter::Parameter;
use crate::fiber::species::Species;

/// The parameters of one fibre (Yan17 Table 1).
///
/// All fields are public. Fill them from a preset, from [`Fiber::hair`] or by hand, or by name with a
/// [`FiberBuilder`](crate::FiberBuilder). [`Parameter`] has the name, unit and range of each field.
/// [`Bcsdf::new`](crate::Bcsdf::new) validates a fibre, so that queries cannot fail.
///
/// With the feature `serde`, a fibre is a map of parameters by name, angles in degrees. Reading validates it.
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
    /// η, refractive index of the cortex, and of a medulla without air, in [1, 3]. Keratin is near 1.55.
    pub eta: f32,
    /// κ, medullary index: the radius of the medulla over that of the fibre, in [0, 0.99]. Hair without medulla has
    /// 0.
    pub kappa: f32,
    /// α, shift of the R highlight in radians, in [−45°, 45°]. If it is positive, the scales of the cuticle open toward
    /// the tip, and the highlight moves toward the root (D11).
    ///
    /// It is not the tilt of the scales. Scales that are tilted by δ shift R by 2δ at h = 0, and by about 1.33δ in the
    /// far field (η = 1.55; less for a smaller η).
    pub alpha: f32,
    /// β_m, longitudinal roughness: a standard deviation in radians, in [0.1°, 90°].
    pub beta_m: f32,
    /// β_n, azimuthal roughness: a standard deviation in radians, in [0.1°, 90°].
    pub beta_n: f32,
    /// σ_c,a, absorption in the cortex, RGB, per fibre radius (D1), in [0, 1000].
    pub sigma_ca: [f32; 3],
    /// σ_m,s, scattering in the medulla, per fibre radius, in [0, 1000]. Beyond an optical radius σ_m,s κ/cos θ_t of
    /// 20 the scattered lobes keep the shape of 20, and lose as much to absorption as at 20.
    pub sigma_ms: f32,
    /// σ_m,a, absorption in the medulla, RGB, per fibre radius, in [0, 1000].
    pub sigma_ma: [f32; 3],
    /// g, Henyey–Greenstein anisotropy of the medulla, in [0, 0.95].
    pub g: f32,
    /// l, layers of the cuticle, in [0, 20]. 0.5 is nearly one ordinary dielectric interface, 1 is one slab, and 0
    /// does not reflect.
    pub layers: f32,
    /// The share of water in what surrounds the fibre, in [0, 1]: [`Fiber::in_air`]. Colours are those of dry fur.
    pub wet: f32,
    /// The shorter axis of the section over the longer one, in [0.4, 1]. 1 is a circle. The longer axis of an ellipse
    /// is y of the fibre's frame, and absorption is per radius of the circle of the same area. Colours are those of
    /// round fibres.
    pub aspect_ratio: f32,
    /// The share of air in the medulla, in [0, 1], by its refractive index: [`Fiber::medulla_eta`].
    pub medulla_air: f32,
    /// How light that the medulla scattered leaves the fibre.
    pub exit: ScatterExit,
    /// Absorption in the medulla over that in the cortex, in [0, 10], for a colour that is given as a reflectance or
    /// as melanin. The scattering of light does not depend on it.
    pub medulla_pigment: f32,
    /// The reflectance that the absorption comes from, as it was asked for, RGB in [0.001, 0.999]. `None` if the
    /// absorption was given in another way.
    ///
    /// The scattering of light does not depend on it. The absorption is that of a dense coat ([`Color::Reflectance`]).
    /// A renderer that knows the groom may replace it. Who sets [`Fiber::sigma_ca`] by hand should set this to `None`.
    pub reflectance: Option<[f32; 3]>,
}

/// The default of [`Fiber::medulla_pigment`]: the median of σ_m,a / σ_c,a of the ten presets is 0.30.
const MEDULLA_PIGMENT: f32 = 0.3;

impl Fiber {
    /// The fibre of a species, with [`ScatterExit::Reflecting`]. Its absorption is grey, as in Table 4.
    ///
    /// It is no fit to a measurement: we had no access to the measurements. κ, g, and absorption and scattering are
    /// fitted to the far field of [`Fiber::published`] at three inclinations, and to the brightness of coats with other
    /// absorption of the cortex. The other parameters are those of [`Fiber::published`].
    pub fn preset(species: Species) -> Self {
        species.fitted()
    }

    /// The fit of Yan17 Table 4 for a species: for the paper's model, [`ScatterExit::Open`], and for earlier models.
    #[doc(alias = "Table 4")]
    pub fn published(species: Species) -> Self {
        species.published()
    }

    /// A preset by its name in files and options: `red-fox` is [`Fiber::preset`], and `red-fox-published` is
    /// [`Fiber::published`].
    ///
    /// # Errors
    /// [`Error::UnknownName`].
    pub fn named(name: &str) -> Result<Self, Error> {
        Species::named(name)
    }

    /// A hair without medulla and without absorption: η 1.55, α 2°, β_m and β_n 7°, one ordinary interface (l = 0.5).
    /// Give it a colour with [`Fiber::with_color`].
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
            wet: 0.0,
            aspect_ratio: 1.0,
            medulla_air: 0.0,
            exit: ScatterExit::default(),
            medulla_pigment: MEDULLA_PIGMENT,
            reflectance: None,
        }
    }

    /// The same fibre with the given absorption of the cortex, RGB, per fibre radius, in [0, 1000]. The value is not
    /// checked here.
    pub fn with_absorption(self, sigma_ca: [f32; 3]) -> Self {
        Fiber { sigma_ca, reflectance: None, ..self }
    }

    /// The same fibre with a colour.
    ///
    /// An absorption and [`Color::HairReflectance`] set σ_c,a only. Melanin and a reflectance set σ_m,a, too
    /// ([`Fiber::medulla_pigment`]). A reflectance out of reach gives the nearest colour: see [`CoatColors::nearest`].
    ///
    /// A reflectance makes a table of the fibre, which takes about a hundred times as long as
    /// [`Bcsdf::new`](crate::Bcsdf::new). If only the colour varies from hit to hit, make [`CoatColors`] once, and use
    /// [`CoatColors::absorption`] and [`Fiber::with_pigment`] at each hit.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for an absorption, concentration or reflectance out of range. A reflectance depends on the
    /// other parameters of the fibre, so this error also occurs for one of these.
    ///
    /// [`CoatColors`]: crate::CoatColors
    /// [`CoatColors::absorption`]: crate::CoatColors::absorption
    /// [`CoatColors::nearest`]: crate::CoatColors::nearest
    pub fn with_color(self, color: Color) -> Result<Self, Error> {
        color.apply(self)
    }

    /// The same fibre with another way for scattered light to leave it.
    pub fn with_exit(self, exit: ScatterExit) -> Self {
        Fiber { exit, ..self }
    }

    /// η_m, the refractive index of the medulla: from η without [`Fiber::medulla_air`] to 1 in a medulla of air. The
    /// air for an index is (η − η_m)/(η − 1).
    #[must_use]
    pub fn medulla_eta(&self) -> f32 {
        if self.medulla_air == 0.0 { self.eta } else { 1.0 + (1.0 - self.medulla_air) * (self.eta - 1.0) }
    }

    /// The same fibre without absorption in cortex and medulla: for white fur and furnace tests.
    pub fn without_absorption(self) -> Self {
        Fiber { sigma_ca: [0.0; 3], sigma_ma: [0.0; 3], reflectance: None, ..self }
    }

    /// Checks every parameter.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] names the first parameter that is NaN or outside [`Parameter::range`]. It gives angles in
    /// degrees.
    pub fn validate(&self) -> Result<(), Error> {
        Parameter::ALL.into_iter().try_for_each(|parameter| parameter.get(self).map_or(Ok(()), |x| parameter.check(x)))
    }

    /// Whether a window of this fibre needs more segments than one chain per side.
    ///
    /// There are three reasons. If the lobes are narrower than the azimuths of a segment, the shape of the segment's
    /// density is visible. Near η = 1, light only changes its direction close to the silhouette, within √(η² − 1) of
    /// it. If the fibre or its medulla absorbs much in one channel, light of that channel only leaves close to the
    /// silhouette or to the medulla's edge. No preset, and no hair with a eumelanin concentration of up to 8, exceeds
    /// the limits.
    pub(crate) fn needs_fine_windows(&self) -> bool {
        let absorbs = |sigma: [f32; 3], most: f32| sigma.into_iter().any(|sigma| sigma > most);
        self.beta_n < 0.02
            || self.eta < 1.15
            || absorbs(self.sigma_ca, 12.0)
            || absorbs(self.sigma_ma.map(|sigma| sigma * self.kappa), 1.0)
    }
}
