//! `vellus fiber`: the parameters of a fibre, and the presets of Yan17 Table 4.

use crate::fiber_args::FiberArgs;
use crate::output;
use anyhow::Result;
use std::path::PathBuf;
use vellus::{Fiber, Parameter, Species};

/// What to show.
#[derive(clap::Subcommand)]
pub enum Command {
    /// List the presets and their parameters.
    List,
    /// List all parameters: name, unit, range, value without a preset, and meaning.
    Parameters,
    /// Print one fibre in the format that --fiber reads.
    Show {
        /// A preset, or a TOML or JSON file.
        name: PathBuf,
        /// Set a parameter, as in `vellus eval`. May be repeated.
        #[arg(long = "set", value_name = "NAME=VALUE", allow_hyphen_values = true)]
        set: Vec<String>,
        /// The format of the output.
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

/// Runs the command.
pub fn run(command: &Command) -> Result<()> {
    match command {
        Command::List => output::write(None, list().as_bytes()),
        Command::Parameters => output::write(None, parameters().as_bytes()),
        Command::Show { name, set, format } => {
            let fiber = FiberArgs::new(name, set).load()?;
            let text = match format {
                Format::Toml => toml::to_string(&fiber)?,
                Format::Json => serde_json::to_string_pretty(&fiber)? + "\n",
            };
            output::write(None, text.as_bytes())
        }
    }
}

/// The first channel of a parameter in the unit of files, if the fibre stores it.
fn value(parameter: Parameter, fiber: &Fiber) -> Option<f32> {
    parameter.get(fiber).map(|value| parameter.unit().from_stored(value[0]))
}

/// A table of the presets. They are grey: the first channel says all.
fn list() -> String {
    let stored = || Parameter::ALL.into_iter().filter(|p| p.default_value().is_some());
    let header = stored().map(|p| format!("{}{}", p.symbol(), p.unit().sign()));
    let mut rows = vec![std::iter::once(String::new()).chain(header).collect::<Vec<_>>()];
    for species in Species::ALL {
        let fiber = Fiber::preset(species);
        let values = stored().filter_map(|p| value(p, &fiber)).map(|x| format!("{x:.2}"));
        rows.push(std::iter::once(species.to_string()).chain(values).collect());
    }
    let note = "Fits of Yan17 Table 4; σ per fibre radius, grey. Also --fiber FILE.toml, and --set NAME=VALUE.";
    format!("{}\n{note}\n", output::align(&rows))
}

/// A table of the parameters.
fn parameters() -> String {
    let hair = Fiber::hair();
    let mut text = String::new();
    for p in Parameter::ALL {
        let default =
            value(p, &hair).map_or(String::new(), |x| format!("; without a preset {:.2}{}", x, p.unit().sign()));
        let channels = match p.channels() {
            1 => "",
            2 => "; one number or two",
            _ => "; one number or three",
        };
        text += &format!("{:12} {}\n", p.name(), p.description());
        text += &format!("{:12} in {}{}{channels}{default}\n", "", p.range(), p.unit().suffix());
    }
    text + "\nGive the colour by one of sigma_ca, reflectance and melanin. Channels alone are sigma_ca.r, sigma_ma.b, eumelanin,\n\
            pheomelanin and so on.\n"
}
