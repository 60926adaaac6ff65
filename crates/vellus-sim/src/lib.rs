//! Simulations behind the `vellus` fur model.
//!
//! - [`medulla`]: light in a purely scattering cylinder, the source of the tables.
//! - [`compress`]: those profiles as short sums of products.
//! - [`build`]: both together, into a table file.
//! - [`check`]: how good a table is.
//! - [`mod@energies`]: light in the whole fibre, to judge the model by.
//! - [`mod@profile`]: that light as a gantry would measure it, with a rough cuticle.

pub mod build;
pub mod check;
pub mod compress;
pub mod energies;
pub mod medulla;
pub mod profile;
mod tracer;
