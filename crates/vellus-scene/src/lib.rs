//! Scenes as plain data, in world space. Readers and groomers create scenes, and the renderer takes them.
//!
//! Lengths are in the unit of the scene. Nothing in this crate depends on the unit. Coordinate systems are
//! right-handed. Strands go from root to tip. [`Scene::validate`] checks a scene.
//!
//! ```
//! use glam::{Vec3, Vec4};
//! use vellus::{Fiber, Species};
//! use vellus_scene::{Basis, Camera, LightShape, Look, Scene, Strands};
//! # fn main() -> Result<(), vellus_scene::Error> {
//! // One straight hair of length 5 and radius 0.004 under a white sky.
//! let hair = Strands {
//!     name: "hair".to_owned(),
//!     basis: Basis::Linear,
//!     starts: vec![0, 2],
//!     points: vec![Vec4::new(0.0, 0.0, 0.0, 0.004), Vec4::new(0.0, 5.0, 0.0, 0.004)],
//!     moved: None,
//!     normals: None, root_uv: None,
//!     look: 0,
//!     varying: Vec::new(),
//! };
//! let sky = LightShape::Dome { radiance: [1.0; 3], texture: None, rotation: glam::Mat3::IDENTITY, ground: None };
//! let scene = Scene {
//!     strands: vec![hair],
//!     looks: vec![Look::constant("fox", Fiber::preset(Species::RedFox))],
//!     lights: vec![sky.into()],
//!     camera: Some(Camera::look_at(Vec3::new(0.0, 2.5, 8.0), Vec3::new(0.0, 2.5, 0.0), Vec3::Y, 0.8, 1.5)),
//!     ..Scene::default()
//! };
//! scene.validate()?;
//! # Ok(()) }
//! ```
#![warn(clippy::print_stdout)]

mod camera;
mod custom;
mod error;
mod framing;
mod instances;
mod light;
mod link;
mod look;
mod mesh;
mod pixels;
mod polygon;
mod scene;
mod select;
mod strands;
mod texture;
mod units;
mod view;

pub use camera::{Camera, Fit};
pub use custom::{Custom, CustomValues, Per};
pub use error::Error;
pub use instances::{Instance, MAX_COPIED, Prototype, Simplified, corners};
pub use light::{Ground, Light, LightShape, Profile, Shaping};
pub use link::{Link, MAX_LINKED, Objects};
pub use look::{Look, ReflectanceOf, Value};
pub use mesh::{Mesh, NormalMap, Opacity, SKIN, Surface, Tint};
pub use pixels::{Pixels, Tables};
pub use polygon::triangulate;
pub use scene::Scene;
pub use select::Broken;
pub use strands::{Basis, MAX_COORDINATE, Strands, Values};
pub use texture::{Texture, Wrap};
pub use units::Units;
pub use vellus::Parameter;
pub use view::View;
