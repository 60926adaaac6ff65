//! What rays hit: round curves and triangles, and the hierarchies over them.

pub mod bvh;
pub mod curves;
pub(crate) mod details;
pub mod flat;
pub mod instances;
pub mod memory;
pub mod ray;
pub mod segment;
pub mod swept;
pub mod triangles;
