//! `vellus fiber`: the presets of Yan17 Table 4.

use crate::fiber_args::{FiberArgs, Spec};
use crate::output;
use anyhow::Result;
use std::path::PathBuf;
use vellus::{Fiber, Species};

/// What to show.
#[derive(clap::Subcommand)]
pub enum Command {
    /// List the presets with their parameters.
    List,
    /// Show one fibre, in a form that --fiber reads back.
    Show {
        /// A preset, or a TOML or JSON file.
        name: PathBuf,
        /// Override a parameter, as in `vellus eval`.
        #[arg(long = "set", value_name = "NAME=VALUE", allow_hyphen_values = true)]
        set: Vec<String>,
        /// How to write it.
        #[arg(long, value_enum, default_value_t = Format::Toml)]
        format: Format,
    },
}

/// File formats of a fibre.
#[derive(Clone, Copy, clap::ValueEnum)]
pub enum Format {
    /// TOML.
    Toml,
    /// JSON.
    Json,
}

/// Runs it.
pub fn run(command: &Command) -> Result<()> {
    match command {
        Command::List => {
            let header = ["", "κ", "η", "α°", "β_m°", "β_n°", "σ_ca", "σ_ms", "σ_ma", "g", "l"];
            let mut rows = vec![header.map(str::to_owned).to_vec()];
            for species in Species::ALL {
                let f = Fiber::preset(species);
                let degrees = |x: f32| x.to_degrees();
                let values = [
                    f.kappa,
                    f.eta,
                    degrees(f.alpha),
                    degrees(f.beta_m),
                    degrees(f.beta_n),
                    f.sigma_ca[0],
                    f.sigma_ms,
                    f.sigma_ma[0],
                    f.g,
                    f.layers,
                ];
                rows.push([species.to_string()].into_iter().chain(values.map(|x| format!("{x:.2}"))).collect());
            }
            let note =
                "Fits of Yan17 Table 4; σ per fibre radius, grey. Also --fiber FILE.toml, and --set NAME=VALUE.\n";
            output::write(None, format!("{}\n{note}", output::align(&rows)).as_bytes())
        }
        Command::Show { name, set, format } => {
            let spec = Spec::of(&FiberArgs::new(name, set).load()?);
            let text = match format {
                Format::Toml => toml::to_string(&spec)?,
                Format::Json => serde_json::to_string_pretty(&spec)? + "\n",
            };
            output::write(None, text.as_bytes())
        }
    }
}
