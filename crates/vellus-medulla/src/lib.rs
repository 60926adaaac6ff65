//! Simulations behind the `vellus` fur model.
//!
//! - [`medulla`]: light in a purely scattering cylinder, the source of the tables.
//! - [`compress`]: those profiles as short sums of products.
//! - [`build`]: both together, into a table file.

pub mod build;
pub mod compress;
pub mod medulla;
