//! A fibre on the command line: a preset, a file, and overrides.

use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use vellus::{Color, Fiber, Species};

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
    /// Override a parameter: kappa=0.5, sigma_ca=0.1,0.2,0.4, eumelanin=1.3, reflectance=0.6,0.4,0.2.
    /// Angles in degrees. May be repeated.
    #[arg(long = "set", value_name = "NAME=VALUE", allow_hyphen_values = true)]
    pub set: Vec<String>,
}

/// A fibre, and where ω_o is inclined to.
#[derive(clap::Args, Clone)]
pub struct Incidence {
    #[command(flatten)]
    pub fiber: FiberArgs,
    /// Inclination of ω_o, the direction the fibre is seen or lit from, degrees.
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

    /// Was anything given?
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
        let base = match format {
            Some(format) => {
                let text = vellus_io::read_to_string(path, MAX_FIBER_BYTES);
                let text = text.with_context(|| format!("cannot read {}", path.display()))?;
                Spec::parse(&text, format).with_context(|| format!("in {}", path.display()))?
            }
            None => Spec { preset: Some(path.display().to_string()), ..Spec::default() },
        };
        let mut spec = base.clone();
        for setting in &self.overrides.set {
            spec.set(setting).with_context(|| format!("in --set {setting}"))?;
        }
        spec.fiber().map_err(|error| match (base.fiber(), format) {
            (Ok(_), _) => error.context(format!("in --set {}", self.overrides.set.join(" --set "))),
            // What is wrong already without overrides is not due to them.
            (Err(_), Some(_)) => error.context(format!("in {}", path.display())),
            (Err(_), None) => error,
        })
    }

    /// A short name for titles and file names.
    pub fn name(&self) -> String {
        self.path().file_stem().map_or_else(|| "fiber".to_owned(), |stem| stem.to_string_lossy().into_owned())
    }
}

impl Overrides {
    /// Does any of them give the fibre its colour?
    pub fn give_color(&self) -> bool {
        let colors = ["sigma_ca", "eumelanin", "pheomelanin", "reflectance"];
        self.set.iter().filter_map(|setting| setting.split_once('=')).any(|(name, _)| colors.contains(&name.trim()))
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

/// One value for all channels, or three.
#[derive(Clone, Copy, Deserialize, Serialize)]
#[serde(untagged)]
enum Rgb {
    Grey(f32),
    Rgb([f32; 3]),
}

impl Rgb {
    fn rgb(self) -> [f32; 3] {
        match self {
            Rgb::Grey(x) => [x; 3],
            Rgb::Rgb(c) => c,
        }
    }
}

/// A fibre file. Whatever is missing comes from `preset`, or else from a hair without medulla.
#[derive(Clone, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Spec {
    #[serde(skip_serializing_if = "Option::is_none")]
    preset: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    kappa: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    eta: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    alpha: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    beta_m: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    beta_n: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    sigma_ca: Option<Rgb>,
    #[serde(skip_serializing_if = "Option::is_none")]
    sigma_ms: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    sigma_ma: Option<Rgb>,
    #[serde(skip_serializing_if = "Option::is_none")]
    g: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    layers: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    eumelanin: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pheomelanin: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reflectance: Option<Rgb>,
}

impl Spec {
    /// All parameters of `fiber`, angles in degrees.
    pub fn of(fiber: &Fiber) -> Self {
        // Degrees that were typed come back as typed, not as 5.4800005.
        let degrees = |x: f32| Some((x.to_degrees() * 1e4).round() / 1e4);
        let rgb = |c: [f32; 3]| Some(if c[0] == c[1] && c[1] == c[2] { Rgb::Grey(c[0]) } else { Rgb::Rgb(c) });
        Spec {
            kappa: Some(fiber.kappa),
            eta: Some(fiber.eta),
            alpha: degrees(fiber.alpha),
            beta_m: degrees(fiber.beta_m),
            beta_n: degrees(fiber.beta_n),
            sigma_ca: rgb(fiber.sigma_ca),
            sigma_ms: Some(fiber.sigma_ms),
            sigma_ma: rgb(fiber.sigma_ma),
            g: Some(fiber.g),
            layers: Some(fiber.layers),
            ..Spec::default()
        }
    }

    fn parse(text: &str, format: Format) -> Result<Self> {
        Ok(match format {
            Format::Toml => toml::from_str(text)?,
            Format::Json => serde_json::from_str(text)?,
        })
    }

    fn set(&mut self, setting: &str) -> Result<()> {
        let Some((name, value)) = setting.split_once('=') else { bail!("expected NAME=VALUE") };
        let numbers = value
            .split(',')
            .map(|x| x.trim().parse::<f32>().with_context(|| format!("'{x}' is not a number")))
            .collect::<Result<Vec<f32>>>()?;
        let rgb = match *numbers.as_slice() {
            [x] => Rgb::Grey(x),
            [r, g, b] => Rgb::Rgb([r, g, b]),
            _ => bail!("{name} takes one number or three, not {}", numbers.len()),
        };
        let name = name.trim();
        let number = || match rgb {
            Rgb::Grey(x) => Ok(Some(x)),
            Rgb::Rgb(_) => bail!("{name} takes one number, not three"),
        };
        match name {
            "kappa" => self.kappa = number()?,
            "eta" => self.eta = number()?,
            "alpha" => self.alpha = number()?,
            "beta_m" => self.beta_m = number()?,
            "beta_n" => self.beta_n = number()?,
            "sigma_ms" => self.sigma_ms = number()?,
            "g" => self.g = number()?,
            "layers" => self.layers = number()?,
            "eumelanin" => self.eumelanin = number()?,
            "pheomelanin" => self.pheomelanin = number()?,
            "sigma_ca" => self.sigma_ca = Some(rgb),
            "sigma_ma" => self.sigma_ma = Some(rgb),
            "reflectance" => self.reflectance = Some(rgb),
            _ => bail!(
                "unknown parameter '{name}': known are kappa, eta, alpha, beta_m, beta_n, sigma_ca, sigma_ms, \
                 sigma_ma, g, layers, eumelanin, pheomelanin, reflectance"
            ),
        }
        Ok(())
    }

    fn fiber(&self) -> Result<Fiber> {
        let base = match &self.preset {
            Some(name) => Fiber::preset(name.parse::<Species>()?),
            None => Fiber::hair(),
        };
        let radians = |given: Option<f32>, base: f32| given.map_or(base, f32::to_radians);
        let rgb = |given: Option<Rgb>, base: [f32; 3]| given.map_or(base, Rgb::rgb);
        let mut fiber = Fiber {
            eta: self.eta.unwrap_or(base.eta),
            kappa: self.kappa.unwrap_or(base.kappa),
            alpha: radians(self.alpha, base.alpha),
            beta_m: radians(self.beta_m, base.beta_m),
            beta_n: radians(self.beta_n, base.beta_n),
            sigma_ca: rgb(self.sigma_ca, base.sigma_ca),
            sigma_ms: self.sigma_ms.unwrap_or(base.sigma_ms),
            sigma_ma: rgb(self.sigma_ma, base.sigma_ma),
            g: self.g.unwrap_or(base.g),
            layers: self.layers.unwrap_or(base.layers),
        };
        let melanin = self.eumelanin.is_some() || self.pheomelanin.is_some();
        let ways = [self.sigma_ca.is_some(), melanin, self.reflectance.is_some()];
        if ways.into_iter().filter(|&given| given).count() > 1 {
            bail!("colour is given more than once: use one of sigma_ca, eumelanin/pheomelanin, reflectance");
        }
        if melanin {
            let (eumelanin, pheomelanin) = (self.eumelanin.unwrap_or(0.0), self.pheomelanin.unwrap_or(0.0));
            fiber = fiber.with_color(Color::Melanin { eumelanin, pheomelanin })?;
        } else if let Some(color) = self.reflectance {
            fiber = fiber.with_color(Color::Reflectance(color.rgb()))?;
        }
        fiber.validate()?;
        Ok(fiber)
    }
}
