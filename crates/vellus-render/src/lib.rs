//! A path tracer for hair and fur.

mod bvh;
mod curves;
mod light;
mod ray;
mod sampler;
mod segment;
mod triangles;

pub use curves::{CurveHit, Curves};
pub use ray::Ray;
pub use segment::{Entry, Segment};
