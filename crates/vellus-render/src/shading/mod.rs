//! How fibres and meshes scatter light.

pub mod colors;
pub mod fibers;
pub mod surface;
