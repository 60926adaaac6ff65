//! The integration tests of `vellus-groom`, as one program.

mod files;
mod grow;
mod interpolate;
