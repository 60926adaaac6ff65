//! `vellus fiber`: the presets of Yan17 Table 4, and the parameters of a fibre.

use crate::fiber_args::{FiberArgs, FileFormat};
use crate::output;
use anyhow::Result;
use std::path::PathBuf;
use vellus_plot::text;

#[derive(clap::Subcommand)]
pub enum Command {
    /// List the presets with their parameters.
    List,
    /// List all parameters: name, meaning, range, unit, and value without a preset.
    Parameters,
    /// Print a fibre in the format that --fiber reads.
    Show {
        /// Preset, or TOML or JSON file.
        name: PathBuf,
        /// Set a parameter, such as kappa=0.5. May be repeated.
        #[arg(long = "set", value_name = "NAME=VALUE", allow_hyphen_values = true)]
        set: Vec<String>,
        /// Format of the output.
        #[arg(long, value_enum, default_value_t = FileFormat::Toml)]
        format: FileFormat,
    },
}

pub fn run(command: &Command) -> Result<()> {
    let text = match command {
        Command::List => format!(
            "{}\nFits of Yan17 Table 4. σ per fibre radius, grey. --fiber also reads files; --set changes a \
             parameter.\n",
            text::presets()
        ),
        Command::Parameters => format!(
            "{}\nThe colour is one of sigma_ca, reflectance and melanin. Single channels are sigma_ca.r, sigma_ma.b,\n\
             eumelanin, pheomelanin and so on.\n",
            text::parameters()
        ),
        Command::Show { name, set, format } => {
            let fiber = FiberArgs::new(name, set).load()?;
            match format {
                FileFormat::Toml => toml::to_string(&fiber)?,
                FileFormat::Json => serde_json::to_string_pretty(&fiber)? + "\n",
            }
        }
    };
    output::write(None, text.as_bytes())
}
