//! Plots and reports of hair and fur reflectance, as PNG, SVG and HTML.
//!
//! Each module has one picture. Its constructor computes the curves from a fibre or a model. [`save`] draws it. The
//! font is part of the library, so that a picture looks the same on every system.
//!
//! | module | picture |
//! |---|---|
//! | [`lobes`] | azimuthal lobes of one hit (Yan17 Fig. 8) |
//! | [`profile`] | reflectance over θ_i and φ (Yan17 Fig. 11) |
//! | [`sheet`] | the same for several fibres and models on one page |
//! | [`medulla`] | compressed and simulated medulla profiles (Yan17 Fig. 10) |
//! | [`energy`] | energies of the lobes |
//! | [`models`] | several models of one fibre |
//! | [`windows`] | the near field, its average over a window, and quadrature (Yan17 Fig. 12a) |
//! | [`error`] | error of the far field over the number of segments |
//! | [`contact`] | small pictures in rows and columns |
//! | [`curves`], [`bars`] | general charts |
//! | [`fit`] | a fitted profile compared with the measured one, and a report |
//!
//! [`query`] reads queries of the model, and [`text`] writes results as tables, CSV and JSON.
//!
//! ```no_run
//! use vellus::{Fiber, Species};
//! use vellus_models::ModelKind;
//! use vellus_plot::{Named, profile, save};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let fiber = Fiber::preset(Species::RedFox);
//! let model = Named::new("red-fox", ModelKind::Vellus, ModelKind::Vellus.model(&fiber)?);
//! let panel = profile::Panel::new(&model, 0.0, profile::Area::SPHERE);
//! let picture = profile::Picture { panels: vec![panel], theta_o: 0.0 };
//! save(&picture, &["red-fox.png".into()])?;
//! # Ok(()) }
//! ```
#![warn(clippy::print_stdout)]

pub mod bars;
pub mod canvas;
pub mod contact;
pub mod curves;
pub mod energy;
pub mod error;
mod failure;
pub mod fit;
pub mod html;
pub mod lobes;
pub mod medulla;
pub mod models;
mod named;
pub mod profile;
pub mod query;
pub mod sheet;
mod smooth;
pub mod text;
pub mod windows;

pub use canvas::{Draw, check_names, png, save, svg};
pub use failure::{Error, Result};
pub use named::Named;
