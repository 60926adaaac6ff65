//! The path tracer: camera rays, random numbers, and the paths of light.

pub(crate) mod at_fiber;
mod at_surface;
pub mod cache;
mod color;
pub mod geometry;
pub mod path;
pub mod sampler;
pub mod settings;
pub mod view;
pub(crate) mod window;
