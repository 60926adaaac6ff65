//! Monte Carlo simulations: the scattering medulla, and whole fibres. The feature `simulation`.
//!
//! - [`medulla`]: light in a purely scattering cylinder. The tables of the medulla come from it.
//! - [`compress`]: compresses the simulated profiles into short sums of products.
//! - [`build`]: simulates and compresses all profiles of a table file.
//! - [`exits`]: where light that the medulla scattered leaves it, the second table of the model.
//! - [`resume`]: the same, and continues after an interruption.
//! - [`check`]: compares a table with new simulations.
//! - [`mod@energies`]: energies of the paths through a whole fibre, as a reference for the model.
//! - [`mod@profile`]: the far field of a whole fibre with a rough cuticle, as a gonioreflectometer measures it.
//! - [`mod@scattered`]: the light that the medulla of a whole fibre scattered, at its first and at later encounters
//!   with the cuticle.
//! - [`azimuth`]: the azimuth of that light at one offset, beside the model, and that of all light of a flat fibre.
//!
//! ```
//! use vellus::{Fiber, Species};
//! use vellus_reference::simulate::energies::{Fate, Offsets, energies};
//! # fn main() -> Result<(), vellus::Error> {
//! // 10,000 photons over the whole width of a fibre, at an inclination of 30°.
//! let fiber = Fiber::preset(Species::RedFox);
//! let energies = energies(&fiber, 30f64.to_radians(), Offsets::Whole, 10_000, 1, &())?;
//! let r = energies.mean[Fate::R as usize];
//! assert!(r.iter().all(|x| (0.01..0.2).contains(x)), "{r:?}");
//! # Ok(()) }
//! ```

pub mod azimuth;
pub mod build;
pub mod check;
pub mod compress;
pub mod energies;
pub mod exits;
pub mod medulla;
pub mod profile;
pub mod resume;
pub mod scattered;
mod table_file;
mod tracer;

pub use table_file::{ReadError, read_tables};
