//! Slow implementations in f64. They check the fast code of `vellus`, and measure the effect of its departures from the
//! paper.
//!
//! - [`exact`] is the model of `vellus` itself: the paper with the departures listed in PAPER.md, without
//!   approximations other than quadrature.
//! - [`as_printed`] is the model of Yan, Jensen and Ramamoorthi 2017 with the formulas as the paper prints them.
//!
//! Both allocate memory at every hit. Neither is meant for rendering.

pub mod as_printed;
pub mod exact;
