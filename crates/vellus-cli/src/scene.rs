//! `vellus scene`: the built-in scenes.

use crate::say::say;
use anyhow::{Result, anyhow};
use std::path::PathBuf;

/// Which, and where to.
#[derive(clap::Args)]
pub struct Args {
    /// A built-in scene; without it, they are listed.
    name: Option<String>,
    /// The small version, of a fortieth of the strands.
    #[arg(long)]
    small: bool,
    /// USD file to write, .usda.
    #[arg(short, long, default_value = "out/scene.usda", value_name = "FILE")]
    output: PathBuf,
}

/// Lists them, or writes one.
pub fn run(args: &Args) -> Result<()> {
    let Some(name) = &args.name else {
        for (name, what) in vellus_groom::SCENES {
            say!("  {name:12}{what}");
        }
        say!("\nvellus render NAME renders one, vellus scene NAME -o FILE.usda writes it.");
        return Ok(());
    };
    let scene = vellus_groom::scene(name, args.small).ok_or_else(|| {
        let names: Vec<_> = vellus_groom::SCENES.iter().map(|(name, _)| *name).collect();
        anyhow!("there is no scene '{name}' (known: {})", names.join(", "))
    })?;
    vellus_usd::write(&scene, &args.output)?;
    say!("wrote {}", args.output.display());
    Ok(())
}
