//! What `vellus` does without a subcommand: a picture of fur, in about a minute.

use crate::render;
use crate::say::say;
use anyhow::Result;
use clap::Parser;

#[derive(Parser)]
struct Command {
    #[command(flatten)]
    args: render::Args,
}

/// Runs it.
pub fn run() -> Result<()> {
    let options = ["raccoon", "--size", "720x480", "--spp", "4096", "--time", "75s", "-o", "out/raccoon.exr"];
    say!("A raccoon of 260,000 strands, for 75 seconds: vellus render {}", options.join(" "));
    render::run(&Command::parse_from(["vellus"].into_iter().chain(options)).args)?;
    say!(
        "\nNext: vellus render raccoon --resume --spp 256 --size 720x480 -o out/raccoon.exr · vellus scene · \
         vellus render cat · vellus plot profile --fiber all · vellus --help"
    );
    Ok(())
}
