//! A path tracer for hair and fur.
//!
//! A [`World`] is a scene made ready; [`World::render`] adds samples of every pixel to a [`Film`], in any order and on any
//! number of threads to the same picture.

/// Raised with every change that alters a picture: entries of the changelog that are marked *image*. Films of
/// different versions are not added to each other.
pub const PICTURE_VERSION: u32 = 1;

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
mod sums;
mod surface;
mod swept;
mod triangles;
mod view;
mod widen;
mod world;

pub use curves::{CurveHit, Curves};
pub use film::{Film, Layer};
pub use layout::Layout;
pub use path::{Mode, Settings};
pub use picture::{Depth, PIXELS_NOTE, check_picture};
pub use ray::Ray;
pub use render::Statistics;
pub use segment::{Entry, Segment};
pub use store::{MAX_SAMPLES, Part};
pub use triangles::{TriangleHit, Triangles};
pub use view::Filter;
pub use widen::widen;
pub use world::World;
