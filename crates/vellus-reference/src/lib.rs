//! Slow implementations in f64. They check the fast code of `vellus`, measure the effect of its departures from the
//! paper, and build its tables.
//!
//! - [`exact`] is the model of `vellus` itself: the paper with the departures listed in PAPER.md, without
//!   approximations other than quadrature.
//! - [`as_printed`] is the model of Yan, Jensen and Ramamoorthi 2017 with the formulas as the paper prints them.
//! - `simulate`, with the feature `simulation`, traces photons: in the medulla, for the tables, and in whole fibres.
//!
//! The first two allocate memory at every hit. None is meant for rendering.
#![warn(clippy::print_stdout)]

pub mod as_printed;
pub mod exact;
#[cfg(feature = "simulation")]
pub mod simulate;
