//! Paths of light: camera rays, random numbers, and the path tracer.

pub mod path;
pub mod sampler;
pub mod view;
