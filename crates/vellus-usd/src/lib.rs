//! USD
mod error;
mod warning;
mod image;
mod rgbe;
mod stage;
pub use image::load_texture;
pub use error::Error;
pub use warning::Warning;
