//! A path tracer for hair and fur.
//!
//! A [`World`] is a scene made ready; [`World::render`] adds samples of every pixel to a [`Film`], in any order and on any
//! number of threads to the same picture.

mod bvh;
mod curves;
mod fibers;
mod film;
mod intervals;
mod layout;
mod light;
mod memory;
mod path;
mod picture;
mod ray;
mod render;
mod sampler;
mod segment;
mod store;
mod surface;
mod swept;
mod triangles;
mod view;
mod widen;
mod world;

pub use curves::{CurveHit, Curves};
pub use film::{Film, LARGEST, Layer};
pub use layout::Layout;
pub use path::{Mode, Settings};
pub use picture::Depth;
pub use ray::Ray;
pub use render::Statistics;
pub use segment::{Entry, Segment};
pub use store::Part;
pub use triangles::{TriangleHit, Triangles};
pub use view::Filter;
pub use widen::widen;
pub use world::World;
