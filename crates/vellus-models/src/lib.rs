//! Earlier reflectance models for hair and fur: those that Yan, Jensen and Ramamoorthi 2017 builds on or compares with.
//!
//! Each implements [`vellus::Model`] and is created from a [`vellus::Fiber`].
//!
//! | model | field | lobes | reported as |
//! |---|---|---|---|
//! | [`Yan2015`] | near | [eleven and a diffuse one](yan2015::LOBES) | all |
//! | [`Chiang2016`] | near | R, TT, TRT, higher orders | R, TT, TRT, rest |
//! | [`DEon2011`] | far | R, TT, TRT, TRRT | R, TT, TRT, rest |
//! | [`ZinkeWeber2007`] | near | R, TT, TRT, TRRT | R, TT, TRT, rest |
//! | [`Marschner2003`] | far | R, TT, TRT | R, TT, TRT |
//! | [`KajiyaKay1989`] | far | specular, diffuse | R, rest |
//!
//! All models follow the conventions of [`vellus`]. Directions are in the frame of the fibre with x from root to tip,
//! and lengths are in fibre radii. Values are f·cos θᵢ, and densities are per solid angle. Offset and attenuation
//! belong to ω_o. Each module names its paper, the parameters that it uses, and the limits of the model.
//! [`AnyModel::far_field`] averages a model over the width of the fibre, in many directions at once.
//!
//! ```
//! use vellus::{Fiber, Model, Scattering, Species, Window};
//! use vellus_models::ModelKind;
//! # fn main() -> Result<(), vellus_models::Error> {
//! let kind: ModelKind = "yan2015".parse()?;
//! let model = kind.model(&Fiber::preset(Species::RedFox))?;
//! let hit = model.at(glam::Vec3::new(0.2, 0.8, 0.5).normalize(), Window::near(0.3));
//! let (f, pdf) = hit.eval_pdf(glam::Vec3::NEG_Y);
//! assert!(f.total()[0] > 0.0 && pdf > 0.0);
//! # Ok(()) }
//! ```
#![warn(clippy::print_stdout)]

mod azimuthal;
pub mod chiang;
pub mod deon;
mod energies;
mod entry;
mod error;
mod factored;
mod far;
mod gauss;
pub mod kajiya_kay;
mod kind;
mod longitudinal;
pub mod marschner;
pub mod yan2015;
pub mod zinke_weber;

pub use chiang::Chiang2016;
pub use deon::DEon2011;
pub use energies::energies;
pub use error::Error;
pub use factored::Factored;
pub use far::{Directions, direction};
pub use gauss::gauss_legendre;
pub use kajiya_kay::KajiyaKay1989;
pub use kind::{AnyHit, AnyModel, ModelKind};
pub use marschner::Marschner2003;
pub use yan2015::Yan2015;
pub use zinke_weber::ZinkeWeber2007;
