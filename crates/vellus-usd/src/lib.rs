//! Scenes of hair and fur as USD: files (.usda, .usdc, .usdz) into a [`vellus_scene::Scene`] and back.

mod camera;
mod crate_check;
mod curves;
mod error;
mod image;
mod layout;
mod light;
mod look;
mod mesh;
mod network;
mod place;
mod primvar;
mod reader;
mod rgbe;
mod stage;
mod surface;
mod uv_texture;
mod text;
mod warning;
mod write;
mod write_geometry;
mod write_look;

pub use error::Error;
pub use image::load_texture;
pub use reader::{Options, read};
pub use warning::Warning;
pub use write::write;
