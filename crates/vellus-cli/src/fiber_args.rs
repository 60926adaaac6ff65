//! A fibre on the command line: a preset or a file, and changes of parameters.

use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use std::path::{Path, PathBuf};
use vellus::{Fiber, FiberBuilder, Parameter, Species};
use vellus_plot::query::Query;

#[derive(clap::Args, Clone)]
pub struct FiberArgs {
    /// Preset (see `vellus fiber list`), or TOML or JSON file [default: red-fox].
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

/// The formats of files of fibres. They are also the extensions.
#[derive(Clone, Copy, PartialEq, ValueEnum)]
pub enum FileFormat {
    Toml,
    Json,
}

/// The largest file of a fibre: 1 MiB.
const MAX_FIBER_BYTES: u64 = 1 << 20;

/// The default preset.
const DEFAULT: &str = "red-fox";

impl FiberArgs {
    /// A preset or a file, and changes.
    pub fn new(fiber: impl Into<PathBuf>, set: &[String]) -> Self {
        FiberArgs { fiber: Some(fiber.into()), overrides: Overrides { set: set.to_vec() } }
    }

    /// Whether a fibre or a change was given.
    pub fn is_given(&self) -> bool {
        self.fiber.is_some() || !self.overrides.set.is_empty()
    }

    fn path(&self) -> &Path {
        self.fiber.as_deref().unwrap_or(Path::new(DEFAULT))
    }

    /// The fibre, with all parameters in range.
    pub fn load(&self) -> Result<Fiber> {
        let path = self.path();
        let in_file = || format!("in {}", path.display());
        let extension = path.extension().and_then(|e| e.to_str());
        let base = match extension.and_then(|e| FileFormat::from_str(e, false).ok()) {
            Some(format) => {
                let text = vellus_io::read_to_string(path, MAX_FIBER_BYTES);
                let text = text.with_context(|| format!("cannot read {}", path.display()))?;
                parse(&text, format).with_context(in_file)?
            }
            None => FiberBuilder::new(Fiber::preset(path.display().to_string().parse::<Species>()?)),
        };
        let mut builder = base.clone();
        for setting in &self.overrides.set {
            set(&mut builder, setting).with_context(|| format!("in --set {setting}"))?;
        }
        // If the file is wrong without the changes, too, the message names the file.
        builder.build().with_context(|| match base.build() {
            Ok(_) => format!("in --set {}", self.overrides.set.join(" --set ")),
            Err(_) => in_file(),
        })
    }

    /// A short name for titles and file names.
    pub fn name(&self) -> String {
        self.path().file_stem().map_or_else(|| "fiber".to_owned(), |stem| stem.to_string_lossy().into_owned())
    }
}

impl Overrides {
    /// Whether one of them sets the colour of the fibre.
    pub fn give_color(&self) -> bool {
        let names = self.set.iter().filter_map(|setting| setting.split_once('='));
        let mut parameters = names.filter_map(|(name, _)| Parameter::parse(name.trim()));
        parameters.any(|(parameter, _)| parameter.is_color())
    }
}

fn parse(text: &str, format: FileFormat) -> Result<FiberBuilder> {
    Ok(match format {
        FileFormat::Toml => toml::from_str(text)?,
        FileFormat::Json => serde_json::from_str(text)?,
    })
}

/// Sets a parameter: `NAME=VALUE` or `NAME=R,G,B`.
fn set(builder: &mut FiberBuilder, setting: &str) -> Result<()> {
    let Some((name, value)) = setting.split_once('=') else { bail!("expected NAME=VALUE") };
    if name.trim() == "exit" {
        builder.set_exit(value.trim().parse()?);
        return Ok(());
    }
    let number = |x: &str| x.trim().parse::<f32>().with_context(|| format!("'{x}' is not a number"));
    let numbers = value.split(',').map(number).collect::<Result<Vec<f32>>>()?;
    Ok(builder.set(name.trim(), &numbers)?)
}
