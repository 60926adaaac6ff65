//! `vellus scene`: lists the built-in scenes, and writes them.

use crate::output;
use crate::say::say;
use anyhow::{Result, anyhow};
use std::path::PathBuf;

/// The scene and the file.
#[derive(clap::Args)]
pub struct Args {
    /// A built-in scene. Without a name: list all.
    name: Option<String>,
    /// Use the small version, with 1/40 of the strands.
    #[arg(long, requires = "name")]
    small: bool,
    /// File to write, .usda or .usdc.
    #[arg(short, long, default_value = "out/scene.usda", value_name = "FILE")]
    output: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<()> {
    let Some(name) = &args.name else {
        for (name, what) in vellus_groom::SCENES {
            say!("  {name:12}{what}");
        }
        say!("\nRender a scene: vellus render NAME. Write it as USD: vellus scene NAME -o FILE.usda");
        return Ok(());
    };
    let names = vellus_groom::SCENES.map(|(name, _)| name);
    let unknown = || anyhow!("there is no scene '{name}' (known: {})", names.join(", "));
    // Check everything before growing strands.
    if !names.contains(&name.as_str()) {
        return Err(unknown());
    }
    output::check_extension(&args.output, &["usda", "usdc"])?;
    output::writable(&args.output)?;
    let scene = vellus_groom::scene(name, args.small).ok_or_else(unknown)?;
    vellus_usd::write(&scene, &args.output)?;
    say!("wrote {}", args.output.display());
    Ok(())
}
