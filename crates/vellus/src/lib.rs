//! The fur reflectance model of Yan, Jensen and Ramamoorthi 2017, *An Efficient and Practical
//! Near and Far Field Fur Reflectance Model*: near field, far field and everything between.
//!
//! # Conventions
//! - The fibre's axis, root to tip, is the local x axis. θ = asin(ω·x) is measured from the normal
//!   plane, φ = atan2(ω_z, ω_y) about the axis. All directions point away from the fibre.
//! - ω_o is where the path came from (the camera), ω_i the direction queried (the light). Offset h and
//!   attenuation belong to ω_o. The surface normal at the hit has azimuth φ_o − asin h.
//! - Lengths are in fibre radii, σ per fibre radius (D1). Angles are radians.
//! - [`Hit::eval`] returns f·cos θᵢ; [`Hit::pdf`] is per solid angle.
//!
//! ```
//! use vellus::{Bcsdf, Fiber, Species, Window};
//! # fn main() -> Result<(), vellus::Error> {
//! let fiber = Fiber::preset(Species::RedFox).with_absorption([0.2, 0.4, 0.8]);
//! let bcsdf = Bcsdf::new(&fiber)?;                       // validates, collapses the tables
//! let wo = glam::Vec3::new(0.2, 0.8, 0.5).normalize();
//! let hit = bcsdf.at(wo, Window::near(0.3));             // all that depends on ω_o
//! let f = hit.eval(glam::Vec3::new(-0.3, -0.9, 0.1).normalize()).total();
//! let s = hit.sample([0.1, 0.2, 0.3, 0.4, 0.5]);         // direction, pdf, weight, lobe
//! assert!(f.iter().chain(s.iter().flat_map(|s| &s.weight)).all(|x| *x >= 0.0));
//! # Ok(()) }
//! ```
//!
//! `D1`, `D2`, … mark departures from the paper; PAPER.md lists them with their reasons.

mod bcsdf;
mod choose;
mod cylinder;
mod error;
mod far;
mod fiber;
mod lobe;
mod medulla;
mod model;
mod near;
#[cfg(feature = "unstable")]
pub mod parts;
mod prepared;
mod simd;
mod window;

pub use bcsdf::{Bcsdf, Hit};
pub use cylinder::cuticle::{Fresnel, fresnel};
pub use cylinder::fiber_frame::FiberFrame;
pub use cylinder::frame::direction;
pub use error::Error;
pub use fiber::Fiber;
pub use fiber::builder::FiberBuilder;
pub use fiber::color::Color;
pub use fiber::parameter::{Parameter, Range, Unit};
pub use fiber::species::Species;
pub use lobe::{Lobe, Lobes, Sample};
#[cfg(feature = "unstable")]
pub use medulla::grid;
pub use medulla::tables::Tables;
#[cfg(feature = "unstable")]
pub use medulla::tables::{FactorTable, TableData};
pub use model::{Field, Model, Scattering};
pub use near::NearHit;
pub use simd::lanes::Lanes;
pub use window::Window;
