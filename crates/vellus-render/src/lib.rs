//! A path tracer for hair and fur.

mod bvh;
mod ray;
mod segment;
