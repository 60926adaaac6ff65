//! One number or eight: the arithmetic that all of the model is generic over.

pub(crate) mod lanes;
pub(crate) mod special;
