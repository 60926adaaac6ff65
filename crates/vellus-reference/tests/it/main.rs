//! The integration tests of `vellus-reference`, as one program.

mod air;
mod ellipse;
mod exit;
mod profile;
mod simulation;
