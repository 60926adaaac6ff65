//! A path tracer for hair and fur.
//!
//! A [`World`] is a scene prepared for rays. [`World::render`] adds samples of every pixel to a [`Film`]; a [`Session`]
//! does so in passes until a goal is reached, with progress, cancellation and checkpoints ([`session`]). A film becomes
//! an OpenEXR or a PNG file with [`Film::to_exr`] and [`Film::to_png`].
//!
//! Curves are not tessellated: [`Curves`] intersects round tubes of varying radius, with motion blur. A fibre scatters
//! by [`vellus::Bcsdf`] or any other [`vellus::Model`]. A picture has the same bits for any number of threads, and for
//! any division of its samples into ranges.
//!
//! ```
//! use glam::{Vec3, Vec4};
//! use vellus::{Fiber, Species};
//! use vellus_render::{Display, Film, Layer, Settings, World};
//! use vellus_scene::{Basis, Camera, Look, Scene, Strands};
//!
//! // One strand of red fox fur, one unit long. Control points are x, y, z and radius.
//! let strands = Strands {
//!     name: "fur".to_owned(),
//!     basis: Basis::Linear,
//!     starts: vec![0, 2],
//!     points: vec![Vec4::new(0.0, -0.5, 0.0, 0.1), Vec4::new(0.0, 0.5, 0.0, 0.05)],
//!     moved: None,
//!     normals: None, root_uv: None,
//!     look: 0,
//!     varying: Vec::new(),
//! };
//! let scene = Scene {
//!     strands: vec![strands],
//!     looks: vec![Look::constant("red-fox", Fiber::preset(Species::RedFox))],
//!     camera: Some(Camera::look_at(Vec3::Z * 4.0, Vec3::ZERO, Vec3::Y, 0.5, 1.0)),
//!     // A scene without lights gets a white dome.
//!     ..Scene::default()
//! };
//!
//! let world = World::new(scene)?;
//! let settings = Settings::new([32, 32]);
//! let mut film = Film::new(settings.size, settings.area(), world.layout(&[Layer::Depth]));
//! let statistics = world.render(&settings, &mut film, 0..4, &())?;
//! assert!(statistics.rays > 32 * 32 * 4);
//! // The strand covers most of a pixel in the middle of the picture, and nothing of the corner.
//! assert!(film.mean(16, 16, Layer::Fibers, 0) > 0.5);
//! assert_eq!(film.mean(0, 0, Layer::Fibers, 0), 0.0);
//! let png = film.to_png(None, Display::default(), &[])?;
//! assert!(png.starts_with(b"\x89PNG"));
//! # Ok::<(), vellus_render::Error>(())
//! ```
//!
//! The feature `denoise` loads Intel Open Image Denoise at run time.
#![warn(clippy::print_stdout)]

/// The version of the pictures. It changes with every change that alters a picture: the changelog marks these *image*.
/// Films of different versions cannot be merged.
pub const PICTURE_VERSION: u32 = 10;

#[cfg(feature = "denoise")]
pub mod denoise;
mod edit;
mod error;
mod fill;
mod film;
mod geometry;
mod integrator;
mod light;
pub mod packed;
mod render;
pub mod session;
mod shading;
mod shown;
mod simplify;
pub mod tev;
mod widen;
mod world;

pub use edit::{Pick, PickedStrand, Varying};
pub use error::Error;
pub use fill::{Kept, Shot};
pub use film::checkpoint::{Checkpoint, MAX_SAMPLES};
pub use film::cryptomatte::Thing;
pub use film::denoised::{Denoise, Denoised};
pub use film::layout::Layout;
pub use film::picture::{Notes, PIXELS_NOTE, PixelType, check_picture};
pub use film::tone::{Display, Tone};
pub use film::{Film, Layer};
pub use geometry::curves::{CurveHit, Curves};
pub use geometry::ray::Ray;
pub use geometry::segment::{Entry, Segment};
pub use geometry::triangles::{TriangleHit, Triangles};
pub use integrator::cache::RadianceCache;
pub use integrator::settings::{Mode, Settings};
pub use integrator::view::Filter;
pub use render::Statistics;
pub use session::Session;
pub use shown::Shown;
pub use simplify::{Lod, simplify};
pub use widen::{prepare, widen};
pub use world::World;
