//! The integration tests of `vellus-reference`, as one program.

mod ellipse;
mod exit;
mod profile;
mod simulation;
