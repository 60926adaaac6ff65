//! The models that Yan, Jensen and Ramamoorthi 2017 builds on and is compared with, behind the trait
//! [`vellus::Model`], each made from our [`vellus::Fiber`].
//!
//! | model | field | lobes |
//! |---|---|---|
//! | [`Yan2015`] | near | [twelve](yan2015::LOBES) |
//! | [`Chiang2016`] | near | R, TT, TRT, rest |
//! | [`ZinkeWeber2007`] | near | R, TT, TRT, rest (TRRT) |
//!
//! All follow the conventions of [`vellus`]: directions in the fibre's frame with x from root to tip, f·cos θᵢ, densities
//! per solid angle, offset and attenuation of ω_o, lengths in radii.

mod along;
mod around;
pub mod chiang;
mod entry;
mod error;
mod factored;
mod kind;
pub mod yan2015;
mod zinke_weber;

pub use chiang::Chiang2016;
pub use error::Error;
pub use factored::Factored;
pub use kind::{AnyHit, AnyModel, ModelKind};
pub use yan2015::Yan2015;
pub use zinke_weber::ZinkeWeber2007;
