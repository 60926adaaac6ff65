//! The integration tests of `vellus-sim`, as one program.

mod exit;
mod profile;
mod simulation;
