//! The integration tests of `vellus-reference`, as one program.

mod exit;
mod profile;
mod section;
mod simulation;
