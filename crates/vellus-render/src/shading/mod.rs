//! How fibres and meshes scatter light.

pub mod fibers;
pub mod surface;
