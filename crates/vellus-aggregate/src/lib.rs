//! x
mod aggregate;
mod bunch;
mod chain;
mod error;
mod grid;
mod hit;
mod longitudinal;
mod member;
mod node;
mod once;
mod orders;
mod piecewise;
#[cfg(feature = "simulation")]
pub mod simulation;
pub use aggregate::Aggregate;
pub use bunch::{Bunch, MAX_SPREAD, MAX_TAU};
pub use error::Error;
pub use hit::AggregateHit;
