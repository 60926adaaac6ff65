//! The model in f64: slow and simple, and written independently of the fast code that it checks.
//!
//! The formulas are those of the paper with the departures listed in PAPER.md. No rearrangement of the fast path is
//! used: this code has angles instead of sines, and it interpolates and normalises the tables for each query. Use
//! this module in tests, and where accuracy matters more than speed.
//!
//! Directions have the conventions of `vellus`: inclinations θ in radians from the normal plane, azimuths
//! φ = φ_i − φ_o in radians, offsets h in [−1, 1]. Arrays of lobes are in the order R, TT, TRT, TTˢ, TRTˢ, rest.
//!
//! ```
//! use vellus::{Fiber, Species, TableData, Tables};
//! use vellus_reference::exact::Exact;
//! # fn main() -> Result<(), vellus::Error> {
//! let tables = TableData::from_bytes(Tables::SHIPPED)?;
//! let fiber = Fiber::published(Species::RedFox);
//! let exact = Exact::new(&fiber, &tables)?;
//! let f = exact.at(0.2, 0.3).eval(-0.1, 2.5); // f·cos θᵢ of the six lobes, RGB
//! assert!(f.iter().flatten().all(|x| *x >= 0.0));
//! # Ok(()) }
//! ```

mod exit;
mod flat;
mod formulas;
mod grid_of_azimuths;
pub(crate) mod hit;
mod inclination;
mod path;
mod profile;
mod segments;
mod window;

pub use exit::ExactExit;
pub use formulas::{bessel_i0e, fresnel, interface, longitudinal, wrapped_gaussian};
pub use hit::ExactHit;
pub use path::ExactPath;
pub use profile::{Profile, mean_path};
pub use segments::ExactSegments;
pub use window::ExactWindow;

use vellus::{Error, Fiber, TableData};

/// The model of one fibre.
#[derive(Clone, Debug)]
pub struct Exact<'t> {
    pub(crate) tables: &'t TableData,
    pub(crate) eta: f64,
    /// The index of the medulla (D24).
    pub(crate) eta_m: f64,
    pub(crate) kappa: f64,
    pub(crate) alpha: f64,
    pub(crate) beta_m: f64,
    pub(crate) beta_n: f64,
    pub(crate) sigma_ca: [f64; 3],
    pub(crate) sigma_ms: f64,
    pub(crate) sigma_ma: [f64; 3],
    pub(crate) g: f64,
    pub(crate) layers: f64,
    /// The shorter axis of the section over the longer one. Only [`Exact::at_flat`] uses it.
    pub(crate) aspect_ratio: f64,
    /// D17. `None` if all scattered light leaves.
    pub(crate) exit: Option<ExactExit>,
}

impl<'t> Exact<'t> {
    /// Prepares a fibre.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if a parameter is outside its range (see [`Fiber::validate`]); [`Error::Table`] if the
    /// tables contradict themselves, or the table of first exits is damaged.
    pub fn new(fiber: &Fiber, tables: &'t TableData) -> Result<Self, Error> {
        fiber.validate()?;
        let fiber = &fiber.in_air();
        tables.validate()?;
        let rgb = |c: [f32; 3]| c.map(f64::from);
        Ok(Exact {
            tables,
            eta: fiber.eta.into(),
            eta_m: fiber.medulla_eta().into(),
            kappa: fiber.kappa.into(),
            alpha: fiber.alpha.into(),
            beta_m: fiber.beta_m.into(),
            beta_n: fiber.beta_n.into(),
            sigma_ca: rgb(fiber.sigma_ca),
            sigma_ms: fiber.sigma_ms.into(),
            sigma_ma: rgb(fiber.sigma_ma),
            g: fiber.g.into(),
            layers: fiber.layers.into(),
            aspect_ratio: fiber.aspect_ratio.into(),
            exit: ExactExit::new(fiber)?,
        })
    }

    /// η′(θ_o).
    pub(crate) fn eta_prime(&self, theta_o: f64) -> f64 {
        (self.eta * self.eta - theta_o.sin().powi(2)).sqrt() / theta_o.cos()
    }

    /// 1 over the cosine of the inclination in the medulla.
    fn medulla_elongation(&self, theta_o: f64) -> f64 {
        1.0 / (1.0 - (theta_o.sin() / self.eta_m).powi(2)).sqrt()
    }

    /// 1/cos θ_t: how much longer an inclined path is than its projection onto the normal plane.
    pub(crate) fn elongation(&self, theta_o: f64) -> f64 {
        1.0 / (1.0 - (theta_o.sin() / self.eta).powi(2)).sqrt()
    }

    /// h″, the offset inside the medulla in units of its radius; 0 without a medulla.
    fn medulla_offset(&self, theta_o: f64, h: f64) -> f64 {
        if self.kappa > 0.0 { (h / self.eta_prime(theta_o) / self.kappa).clamp(-1.0, 1.0) } else { 0.0 }
    }

    /// Prepares the hit of a ray at the inclination `theta_o` (radians, |θ_o| < π/2) and the offset `h` in [−1, 1].
    #[doc(alias = "Eq. 12")]
    pub fn at(&self, theta_o: f64, h: f64) -> ExactHit<'_, 't> {
        let longitudinal = self.inclination(theta_o);
        let azimuthal = self.azimuthal_profile(theta_o, h).over_leaving(longitudinal.leaving());
        ExactHit { path: self.path(theta_o, h), azimuthal, longitudinal }
    }

    /// C^N of the path at `h`.
    pub(crate) fn azimuthal_profile(&self, theta_o: f64, h: f64) -> Profile {
        let path = self.eta_m < self.eta;
        let offset = if path { self.path(theta_o, h).medulla_offset() } else { self.medulla_offset(theta_o, h) };
        self.profile_of_offset(theta_o, offset.abs())
    }

    /// C^N of a path of offset |h″|.
    fn profile_of_offset(&self, theta_o: f64, offset: f64) -> Profile {
        let tau = self.sigma_ms * self.kappa * self.medulla_elongation(theta_o);
        Profile::azimuthal(self.tables, tau, self.g, offset)
    }

    /// Standard deviation of the azimuth of R, TT, TRT.
    pub(crate) fn sigma(&self, p: usize) -> f64 {
        (p as f64 + 1.0).sqrt() * self.beta_n
    }

    /// The share of scattered light that leaves, and the fraction of it that leaves when it first meets the cuticle,
    /// RGB. `entry` is the light that enters the medulla. `None` if the exit is open.
    pub(crate) fn escape(&self, theta_o: f64, h: f64, entry: [f64; 3]) -> Option<[[f64; 3]; 2]> {
        self.escape_of_offset(theta_o, self.medulla_offset(theta_o, h), entry)
    }

    fn escape_of_offset(&self, theta_o: f64, offset: f64, entry: [f64; 3]) -> Option<[[f64; 3]; 2]> {
        let exit = self.exit.as_ref()?;
        let theta_t = (theta_o.sin() / self.eta_m).asin();
        let [escape, first] = exit.escape(offset, theta_t);
        // In each part, no channel has more light than the same share of the channel with the most light in all.
        let light = [0, 1, 2].map(|c| escape[c] * entry[c]);
        let most = light.into_iter().fold(0.0, f64::max);
        // A mean, weighted by the squares of the light.
        let sum = |weights: [f64; 3]| (0..3).map(|c| weights[c] * light[c] * light[c]).sum::<f64>();
        let share = sum(first) / sum([1.0; 3]).max(1e-300);
        let first = [0, 1, 2].map(|c| {
            let first = (light[c] * first[c]).max(light[c] - (1.0 - share) * most).min(share * most);
            if light[c] > 0.0 { first / light[c] } else { 1.0 }
        });
        Some([escape, first])
    }

    /// M̂ₚ(θᵢ) of R, TT, TRT and the rest.
    pub(crate) fn longitudinal(&self, theta_o: f64, theta_i: f64) -> [f64; 4] {
        let shift = [self.alpha, -self.alpha / 2.0, -1.5 * self.alpha, -1.5 * self.alpha];
        let width = [self.beta_m, self.beta_m / 2.0, 1.5 * self.beta_m, 2.0 * self.beta_m];
        std::array::from_fn(|p| longitudinal(-theta_o - shift[p], width[p] * width[p], theta_i))
    }
}
