//! `vellus fiber`: the presets of Yan17 Table 4, and the parameters of a fibre.

use crate::fiber_args::FiberArgs;
use crate::number::one_of;
use crate::output;
use crate::say::note;
use crate::terminal::Terminal;
use anyhow::{Error, Result};
use std::path::PathBuf;
use vellus_experiments::coat::Sheet;
use vellus_open::FiberFormat;
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
        #[arg(long, value_parser = one_of::<FiberFormat>(FiberFormat::NAMES), default_value = "toml")]
        format: FiberFormat,
    },
    /// Draw coats of fur in white light over two parameters, as one picture.
    Sheet(Sheet),
}

pub fn run(command: &Command) -> Result<()> {
    let text = match command {
        Command::List => text::presets(),
        Command::Parameters => text::parameters(),
        Command::Show { name, set, format } => {
            format.write(&FiberArgs::new(name, set).load()?).map_err(Error::from_boxed)?
        }
        Command::Sheet(sheet) => {
            sheet.save(&Terminal::new(), |warning| note!("warning: {warning}"))?;
            format!("wrote {}\n", sheet.output.display())
        }
    };
    output::write(None, text.as_bytes())
}
