//! The integration tests of `vellus-gpu`, as one program.

#[cfg(feature = "device")]
mod color;
#[cfg(feature = "device")]
mod common;
#[cfg(feature = "convert")]
mod conversion;
#[cfg(feature = "device")]
mod far_field;
#[cfg(feature = "device")]
mod lost;
#[cfg(feature = "device")]
mod near_field;
#[cfg(feature = "convert")]
mod ports;
#[cfg(feature = "device")]
mod reduced;
#[cfg(feature = "trace")]
mod trace;
