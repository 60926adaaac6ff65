//! The fur reflectance model of Yan, Jensen and Ramamoorthi 2017, *An Efficient and Practical Near and Far Field Fur
//! Reflectance Model* ("Yan17" below). It has a near field, a far field, and windows between them.
//!
//! ```
//! use vellus::glam::Vec3;
//! use vellus::{Bcsdf, Fiber, Species, Window};
//! # fn main() -> Result<(), vellus::Error> {
//! let fiber = Fiber::preset(Species::RedFox).with_absorption([0.2, 0.4, 0.8]);
//! let bcsdf = Bcsdf::new(&fiber)?;                       // checks the parameters, prepares the fibre
//! let wo = Vec3::new(0.2, 0.8, 0.5).normalize();         // toward the camera
//! let hit = bcsdf.at(wo, Window::near(0.3));             // prepares everything that depends on ω_o
//! let f = hit.eval(Vec3::new(-0.3, -0.9, 0.1).normalize()).total();
//! let s = hit.sample([0.1, 0.2, 0.3, 0.4, 0.5]);         // direction, pdf, weight, lobe
//! assert!(f.iter().chain(s.iter().flat_map(|s| &s.weight)).all(|x| *x >= 0.0));
//! # Ok(()) }
//! ```
//!
//! [`FiberFrame`] converts a renderer's directions and hits to those of the model. The folder `examples/` has a minimal
//! program, a white furnace, and a path tracer in 150 lines.
//!
//! # Conventions
//! - The x axis of the fibre's frame runs along the fibre, from root to tip. The inclination θ = asin(ω·x) is measured
//!   from the normal plane, and the azimuth φ = atan2(ω_z, ω_y) about the axis. All directions point away from the
//!   fibre. Angles are in radians.
//! - ω_o is the direction that the path came from (the camera), ω_i the direction of the query (the light). The offset
//!   h and the attenuation belong to ω_o. The surface normal at the hit has the azimuth φ_o − asin h.
//! - Lengths are in fibre radii, and absorption and scattering coefficients per fibre radius (D1).
//! - [`Hit::eval`] returns f·cos θᵢ. [`Hit::pdf`] is a density per solid angle.
//! - Names that end in 8 take eight queries at once, in [`wide::f32x8`].
//!
//! The model is not reciprocal: h and the attenuation belong to ω_o (D2). ω_o is the direction of the path that comes
//! from the camera.
//!
//! All types are `Send` and `Sync`.
//!
//! D1, D2, … mark departures from the paper. PAPER.md in the repository lists them with their reasons.
//!
//! # Speed
//! Compile for AVX2, with `RUSTFLAGS="-C target-cpu=x86-64-v3"` or the same in `.cargo/config.toml`. Without it, x86-64
//! processors take 1.1 to 1.7 times as long. [`missing_instructions`] tells whether a processor can run the program.
//!
//! # Stability
//! The feature `unstable` makes `parts`, `packed`, `grid`, `TableData` and `FactorTable` public, for other crates of
//! the repository. They are exempt from semantic versioning: a crate that uses them must require exactly one version.

mod bcsdf;
mod choose;
mod coat;
mod crc32;
mod cylinder;
mod error;
pub(crate) mod exit;
mod far;
mod fiber;
mod half_float;
mod lobe;
mod medulla;
mod model;
mod near;
#[cfg(feature = "unstable")]
pub mod packed;
#[cfg(feature = "unstable")]
pub mod parts;
mod prepared;
mod simd;
mod window;

pub use bcsdf::{Bcsdf, Hit, OwnedHit};
pub use coat::CoatColors;
pub use cylinder::cuticle::{Fresnel, fresnel};
pub use cylinder::fiber_frame::FiberFrame;
pub use cylinder::frame::direction;
pub use error::Error;
pub use fiber::Fiber;
pub use fiber::builder::{FiberBuilder, OutOfReach};
pub use fiber::color::Color;
pub use fiber::exit::ScatterExit;
pub use fiber::parameter::{Parameter, ParameterRange, ParameterUnit};
pub use fiber::species::Species;
pub use lobe::{Lobe, Lobes, Sample};
#[cfg(feature = "unstable")]
pub use medulla::grid;
pub use medulla::tables::Tables;
#[cfg(feature = "unstable")]
pub use medulla::tables::{FactorTable, TableData};
pub use model::{Model, Scattering, WindowSupport};
pub use near::NearHit;
pub use simd::instructions::missing_instructions;
pub use simd::lanes::Lanes;
pub use window::Window;

// Both are part of the public interface.
pub use {glam, wide};
