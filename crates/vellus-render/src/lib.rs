//! A path tracer for hair and fur.
//!
//! A [`World`] is a scene made ready; [`World::render`] adds samples of every pixel to a [`Film`], in any order and on any
//! number of threads to the same picture.

/// Raised with every change that alters a picture: entries of the changelog that are marked *image*. Films of
/// different versions are not added to each other.
pub const PICTURE_VERSION: u32 = 1;

#[cfg(feature = "denoise")]
pub mod denoise;
mod error;
mod film;
mod geometry;
mod integrator;
mod light;
mod render;
pub mod session;
mod shading;
pub mod tev;
mod widen;
mod world;

pub use error::Error;
pub use film::checkpoint::{Checkpoint, MAX_SAMPLES};
pub use film::layout::Layout;
pub use film::picture::{Notes, PIXELS_NOTE, PixelType, check_picture};
pub use film::{Film, Layer};
pub use geometry::curves::{CurveHit, Curves};
pub use geometry::ray::Ray;
pub use geometry::segment::{Entry, Segment};
pub use geometry::triangles::{TriangleHit, Triangles};
pub use integrator::settings::{Mode, Settings};
pub use integrator::view::Filter;
pub use render::Statistics;
pub use session::Session;
pub use widen::widen;
pub use world::World;
