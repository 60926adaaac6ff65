//! The integration tests of `vellus-usd`, as one program.

mod blender;
mod common;
mod features;
mod hostile;
mod malformed;
mod round_trip;
mod sources;
