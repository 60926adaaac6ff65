//! `vellus groom`: what is in a groom, other formats of it, and growing one.

mod coat;
mod grow;
mod info;

use crate::output;
use crate::render::Input;
use crate::say::say;
use anyhow::{Result, anyhow, bail};
use std::path::{Path, PathBuf};

/// What to do.
#[derive(clap::Subcommand)]
pub enum Command {
    /// Counts, bounds, units, widths, lengths and memory of all strands.
    Info {
        #[command(flatten)]
        input: Input,
    },
    /// Write it in another format: .usda with all there is, or .hair with one set of strands.
    Convert {
        #[command(flatten)]
        input: Input,
        /// File to write.
        #[arg(short, long, value_name = "FILE")]
        output: PathBuf,
        /// Straight pieces of a .hair file that a curved segment becomes.
        #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=64))]
        pieces: u16,
    },
    Grow(Box<grow::Args>),
}

/// Runs it.
pub fn run(command: &Command) -> Result<()> {
    match command {
        Command::Info { input } => output::write(None, info::info(&input.load_to_measure()?).as_bytes()),
        Command::Convert { input, output, pieces } => convert(input, output, usize::from(*pieces)),
        Command::Grow(args) => grow::run(args),
    }
}

fn convert(input: &Input, path: &Path, pieces: usize) -> Result<()> {
    output::check_extension(path, &["usda", "hair"])?;
    input.check()?;
    output::writable(path)?;
    let scene = input.load()?;
    if path.extension().is_none_or(|e| e != "hair") {
        vellus_usd::write(&scene, path)?;
        say!("wrote {}", path.display());
        return Ok(());
    }
    let [strands] = &scene.strands[..] else {
        bail!("a .hair file holds one set of strands, the scene has {}", scene.strands.len());
    };
    let strands = vellus_groom::flatten(strands, pieces);
    let bytes = vellus_groom::write_hair(&strands).map_err(|e| anyhow!("{}: {e}", path.display()))?;
    output::write(Some(path), &bytes)?;
    say!("wrote {}", path.display());
    Ok(())
}
