//! The integration tests of `vellus`, as one program.

mod as_printed;
mod coat;
mod edges;
mod energy;
mod exact;
mod exit;
mod far_table;
mod owned;
mod refracted;
mod sampling;
#[cfg(feature = "serde")]
mod text_form;
mod vectors;
mod window;
