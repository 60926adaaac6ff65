//! The integration tests of `vellus-farm`, as one program.

mod plan;
mod runner;
