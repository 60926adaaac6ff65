//! `vellus groom`: describes, converts and grows hair and fur.

mod grow;

use crate::output;
use crate::render::Input;
use crate::say::{note, say};
use anyhow::{Result, bail};
use std::path::{Path, PathBuf};
use vellus_groom::Interpolation;
use vellus_open::{Flavor, Options, Writing};
use vellus_scene::Strands;
use vellus_usd::Shot;

/// The number of strands that `interpolate` makes of one, if nothing says it.
const DENSER: f32 = 10.0;

/// Programs that read grooms from Alembic archives.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub enum Program {
    /// Unreal Engine, specification 1.5.
    Unreal,
}

/// The subcommands.
#[derive(clap::Subcommand)]
pub enum Command {
    /// Describe strands: counts, bounds, units, widths, lengths, memory, and the frames of an animation.
    Info {
        #[command(flatten)]
        input: Input,
    },
    /// Convert to .usda or .usdc (the whole scene), to .abc (geometry and camera), or to .hair (one set of strands).
    Convert {
        #[command(flatten)]
        input: Input,
        /// File to write, .usda, .usdc, .abc or .hair. A .usdc file is smaller and faster than a .usda file.
        #[arg(short, long, value_name = "FILE")]
        output: PathBuf,
        /// Straight segments in a .hair file for each curved one.
        #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=64))]
        pieces: u16,
        /// The program that will read an .abc file: names, types and scopes of its groom specification.
        #[arg(long = "for", value_name = "PROGRAM")]
        program: Option<Program>,
    },
    /// Grow strands between those that are there, such as guides. Each follows three strands around it; waves and curls
    /// are those of the nearest one.
    Interpolate {
        #[command(flatten)]
        input: Input,
        /// File to write, .usda, .usdc or .abc.
        #[arg(short, long, value_name = "FILE")]
        output: PathBuf,
        #[command(flatten)]
        interpolation: Interpolation,
    },
    Grow(Box<grow::Args>),
}

/// Runs the command.
pub fn run(command: &Command) -> Result<()> {
    match command {
        Command::Info { input } => {
            let opened = input.open_to_measure()?;
            let mut text = vellus_groom::describe(&opened.scene, opened.header.as_ref());
            if let Some(Shot { range: Some([first, last]), frames_per_second, .. }) = opened.shot {
                let [first, last, rate] = [first, last, frames_per_second].map(|x| (x * 1e3).round() / 1e3);
                text = format!("time      frames {first} to {last}, {rate} a second\n{text}");
            }
            output::write(None, text.as_bytes())
        }
        Command::Convert { input, output, pieces, program } => convert(input, output, usize::from(*pieces), *program),
        Command::Interpolate { input, output, interpolation } => interpolate(input, output, *interpolation),
        Command::Grow(args) => grow::run(args),
    }
}

fn interpolate(input: &Input, path: &Path, interpolation: Interpolation) -> Result<()> {
    output::check_extension(path, &["usda", "usdc", "abc"])?;
    let mut input = input.clone();
    input.strands = Some(input.strands.unwrap_or(DENSER));
    let options = Options { interpolation, ..input.options(None)? };
    output::writable(path)?;
    let scene = input.open_with(&options)?.scene;
    vellus_open::write(&scene, path, Writing::default())?;
    let count: usize = scene.all_strands().map(Strands::len).sum();
    let output = path.display();
    say!("{count} strands\nwrote {output}\nNext: vellus render {output}");
    Ok(())
}

fn convert(input: &Input, path: &Path, pieces: usize, program: Option<Program>) -> Result<()> {
    output::check_extension(path, &["usda", "usdc", "abc", "hair"])?;
    let flavor = match program {
        Some(Program::Unreal) if path.extension().is_none_or(|extension| extension != "abc") => {
            bail!("--for unreal: Unreal reads grooms from .abc files, not {}", path.display());
        }
        Some(Program::Unreal) => Flavor::Unreal,
        None => Flavor::Plain,
    };
    let options = Options { custom: true, ..input.options(None)? };
    output::writable(path)?;
    let scene = input.open_with(&options)?.scene;
    vellus_open::write(&scene, path, Writing { pieces, flavor })?;
    let dropped = vellus_open::dropped(&scene, path, flavor);
    if !dropped.is_empty() {
        note!("warning: {} does not have {}", path.display(), dropped.join(", "));
    }
    say!("wrote {}", path.display());
    Ok(())
}
