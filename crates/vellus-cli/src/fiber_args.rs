//! A fibre on the command line: a preset or a file, and changes of parameters.

use crate::say::note;
use anyhow::Result;
use std::path::PathBuf;
use vellus::Fiber;
use vellus_open::{FiberSource, Recolor};
use vellus_plot::query::Query;

#[derive(clap::Args, Clone)]
pub struct FiberArgs {
    /// Preset (see `vellus fiber list`), TOML or JSON file, or MaterialX material (FILE.mtlx#NAME) [default: red-fox].
    #[arg(long, value_name = "NAME|FILE")]
    pub fiber: Option<PathBuf>,
    #[command(flatten)]
    pub overrides: Overrides,
}

#[derive(clap::Args, Clone, Default)]
pub struct Overrides {
    /// Set a parameter of the fibre, such as kappa=0.5 or sigma_ca=0.1,0.2,0.4. May be repeated. `vellus fiber
    /// parameters` lists the names, units and ranges.
    #[arg(long = "set", value_name = "NAME=VALUE", allow_hyphen_values = true)]
    pub set: Vec<String>,
}

/// A fibre and an inclination.
#[derive(clap::Args, Clone)]
pub struct Incidence {
    #[command(flatten)]
    pub fiber: FiberArgs,
    /// Inclination of ω_o, the direction toward the camera.
    #[arg(long, default_value_t = 0.0, value_name = "DEG")]
    pub theta_o: f64,
}

impl Incidence {
    /// The fibre, and the inclination, which is in range.
    pub fn checked(&self) -> Result<(&FiberArgs, f64)> {
        Query::new([self.theta_o, 0.0, 0.0, 0.0])?;
        Ok((&self.fiber, self.theta_o))
    }
}

impl FiberArgs {
    /// A preset or a file, and changes.
    pub fn new(fiber: impl Into<PathBuf>, set: &[String]) -> Self {
        FiberArgs { fiber: Some(fiber.into()), overrides: Overrides { set: set.to_vec() } }
    }

    /// Whether a fibre or a change was given.
    pub fn is_given(&self) -> bool {
        self.fiber.is_some() || !self.overrides.set.is_empty()
    }

    /// The fibre as the user describes it.
    pub fn source(&self) -> FiberSource {
        let path = self.fiber.clone().unwrap_or_else(|| FiberSource::default().path);
        FiberSource { path, set: self.overrides.set.clone() }
    }

    /// The fibre, with all parameters in range.
    pub fn load(&self) -> Result<Fiber> {
        let (fiber, warnings) = self.source().read_with_warnings().map_err(|error| error.of_option("--set "))?;
        warnings.iter().for_each(|warning| note!("warning: {warning}"));
        Ok(fiber)
    }

    /// The same for the fibres that a scene has.
    pub fn recolor(&self) -> Result<Recolor> {
        Recolor::new(self.fiber.clone(), self.overrides.set.clone()).map_err(|error| error.of_option("--set ").into())
    }

    /// A short name for titles and file names.
    pub fn name(&self) -> String {
        self.source().name()
    }
}
