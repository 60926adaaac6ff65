//! The colour of a dense coat of fibres.
pub mod moments;
