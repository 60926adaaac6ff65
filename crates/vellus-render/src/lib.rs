//! A path tracer for hair and fur.

mod bvh;
mod curves;
mod ray;
mod segment;

pub use curves::{CurveHit, Curves};
pub use ray::Ray;
pub use segment::{Entry, Segment};
