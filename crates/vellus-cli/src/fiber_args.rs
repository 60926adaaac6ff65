//! A fibre on the command line: a preset or a file, and overrides of parameters.

use anyhow::{Context, Result, bail};
use std::path::{Path, PathBuf};
use vellus::{Fiber, FiberBuilder, Parameter, Species};

/// Which fibre.
#[derive(clap::Args, Clone)]
pub struct FiberArgs {
    /// A preset (see `vellus fiber list`), or a TOML or JSON file [default: red-fox].
    #[arg(long, value_name = "NAME|FILE")]
    pub fiber: Option<PathBuf>,
    #[command(flatten)]
    pub overrides: Overrides,
}

/// Changes of a fibre.
#[derive(clap::Args, Clone, Default)]
pub struct Overrides {
    /// Set a parameter of the fibre: kappa=0.5, sigma_ca=0.1,0.2,0.4, melanin=1.3,0.2 or reflectance=0.6,0.4,0.2. Angles
    /// in degrees. May be repeated. `vellus fiber parameters` lists all names.
    #[arg(long = "set", value_name = "NAME=VALUE", allow_hyphen_values = true, long_help = set_help())]
    pub set: Vec<String>,
}

/// The long help of `--set`: all parameters.
fn set_help() -> String {
    let mut text =
        "Set a parameter of the fibre, such as kappa=0.5 or sigma_ca=0.1,0.2,0.4. May be repeated. Only one of \
                    sigma_ca, reflectance and melanin may be given. The parameters and their ranges:\n"
            .to_owned();
    for parameter in Parameter::ALL {
        let numbers = match parameter.channels() {
            1 => "",
            2 => ", one number (eumelanin) or two",
            _ => ", one number or three (RGB)",
        };
        let (name, range, unit) = (parameter.name(), parameter.range(), parameter.unit().suffix());
        text += &format!("\n  {name}: {}, in {range}{unit}{numbers}", parameter.description());
    }
    text + "\n\nA channel alone has a name too: sigma_ca.r, sigma_ma.b, eumelanin, pheomelanin"
}

/// A fibre and an inclination of ω_o.
#[derive(clap::Args, Clone)]
pub struct Incidence {
    #[command(flatten)]
    pub fiber: FiberArgs,
    /// Inclination of ω_o, the direction toward the camera, in degrees from the normal plane.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true, value_name = "DEG")]
    pub theta_o: f64,
}

/// The largest file of a fibre: 1 MiB.
const MAX_FIBER_BYTES: u64 = 1 << 20;

/// The preset where none is given.
pub const DEFAULT: &str = "red-fox";

impl FiberArgs {
    /// A preset or a file, and overrides.
    pub fn new(fiber: impl Into<PathBuf>, set: &[String]) -> Self {
        FiberArgs { fiber: Some(fiber.into()), overrides: Overrides { set: set.to_vec() } }
    }

    /// Was a fibre or an override given?
    pub fn is_given(&self) -> bool {
        self.fiber.is_some() || !self.overrides.set.is_empty()
    }

    fn path(&self) -> &Path {
        self.fiber.as_deref().unwrap_or(Path::new(DEFAULT))
    }

    /// The fibre, validated.
    pub fn load(&self) -> Result<Fiber> {
        let path = self.path();
        let format = file_format(path);
        let in_file = || format!("in {}", path.display());
        let base = match format {
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
        // An error that the file has without the overrides is the file's.
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
    /// Does one of them give the fibre its colour?
    pub fn give_color(&self) -> bool {
        let names = self.set.iter().filter_map(|setting| setting.split_once('='));
        let mut parameters = names.filter_map(|(name, _)| Parameter::parse(name.trim()));
        parameters.any(|(parameter, _)| parameter.is_color())
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Format {
    Toml,
    Json,
}

fn file_format(path: &Path) -> Option<Format> {
    match path.extension()?.to_str()? {
        "toml" => Some(Format::Toml),
        "json" => Some(Format::Json),
        _ => None,
    }
}

/// What a file says of a fibre. [`FiberBuilder`] has the format.
fn parse(text: &str, format: Format) -> Result<FiberBuilder> {
    Ok(match format {
        Format::Toml => toml::from_str(text)?,
        Format::Json => serde_json::from_str(text)?,
    })
}

/// Sets a parameter: `NAME=VALUE` or `NAME=R,G,B`.
fn set(builder: &mut FiberBuilder, setting: &str) -> Result<()> {
    let Some((name, value)) = setting.split_once('=') else { bail!("expected NAME=VALUE") };
    let numbers = value
        .split(',')
        .map(|x| x.trim().parse::<f32>().with_context(|| format!("'{x}' is not a number")))
        .collect::<Result<Vec<f32>>>()?;
    Ok(builder.set(name.trim(), &numbers)?)
}
