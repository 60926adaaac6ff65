//! A scene as plain data, in world space: what readers make, groomers grow and the renderer takes.
//!
//! Lengths are in the scene's own unit, whatever it is: nothing here depends on it. Directions are right-handed.
//! Strands run from root to tip. [`Scene::validate`] says what is wrong with one.

mod camera;
mod error;
mod framing;
mod light;
mod look;
mod mesh;
mod scene;
mod strands;
mod texture;
mod units;

pub use camera::Camera;
pub use error::Error;
pub use light::{Ground, Light};
pub use look::{Look, Value};
pub use mesh::{Mesh, Surface, Tint};
pub use scene::Scene;
pub use strands::{Basis, MAX_COORDINATE, Strands, Values};
pub use texture::{Texture, Wrap};
pub use units::Units;
pub use vellus::Parameter;
