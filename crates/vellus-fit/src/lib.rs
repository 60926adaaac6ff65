//! Fits the parameters of a fur model, with their standard errors, to the measured reflectance profile of one fibre
//! (Yan17 Sec. 5.1, Validation).
//!
//! - [`read()`]: reads measured profiles from files. [`simulate`]: makes synthetic profiles.
//! - [`fit()`]: bounded least squares on the log-ratio of fitted to measured values, from many starts, of one profile
//!   or of several profiles of the same fibre.
//! - [`Forward`]: the model that is fitted, Yan et al. 2017 or one of three earlier models.
//!
//! ```
//! use vellus_fit::{Forward, Options, Synthetic, fit, simulate};
//! use vellus::{Fiber, Species};
//! # fn main() -> Result<(), vellus_fit::Error> {
//! let truth = Fiber::preset(Species::Cat);
//! let synthetic = Synthetic { step: [8.0, 4.0], ..Synthetic::default() };
//! let profile = simulate::from_model(Forward::default(), &truth.into(), &synthetic)?;
//! let options = Options { starts: 8, ..Options::default() };
//! let result = fit(&[profile], Forward::default(), &options, &())?;
//! assert!(result.nrmse < 0.02 && (result.specimen.fiber.eta - truth.eta).abs() < 0.02);
//! # Ok(()) }
//! ```
#![warn(clippy::print_stdout)]

mod absorption;
mod aperture;
mod cost;
mod error;
mod fit;
mod forward;
mod image;
mod intervals;
pub mod least_squares;
pub mod matrix;
mod options;
mod outcome;
pub mod parameters;
mod profile;
mod read;
mod refit;
pub mod simulate;
pub mod space;
mod specimen;
mod starts;
mod statistics;
mod verdict;
mod write;

pub use absorption::Absorption;
pub use error::Error;
pub use fit::{errors, fit};
pub use forward::Forward;
pub use options::Options;
pub use outcome::{Combination, Correlations, Estimate, Fit, Part, Rival, Starts, State};
pub use parameters::Name;
pub use profile::{FEWEST, LARGEST, MOST_CHANNELS, Point, Profile, Quantity, WIDEST};
pub use read::{Angles, Axis, Reading, parse_blur, read, read_channels};
pub use refit::{Refit, refit};
pub use simulate::Synthetic;
pub use space::Requests;
pub use specimen::Specimen;
pub use verdict::{Explained, FALSE_ALARM, NOISE_LIKE, NoFit};
pub use write::{Writer, channels_csv, csv, gantry_text, writer};
