//! Arithmetic with one number or eight. The whole model is generic over it.

pub(crate) mod instructions;
pub(crate) mod lanes;
pub(crate) mod special;
