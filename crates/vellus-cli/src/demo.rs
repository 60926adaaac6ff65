//! `vellus` without a subcommand: renders a picture of fur in about a minute.

use crate::exit::Interrupted;
use crate::render;
use crate::say::say;
use anyhow::Result;
use clap::Parser;
use std::path::Path;

#[derive(Parser)]
struct Command {
    #[command(flatten)]
    args: render::Args,
}

/// What to render.
const OPTIONS: &str = "raccoon --size 720x480 --spp 4096 -o out/raccoon.exr";

/// Runs the demonstration.
pub fn run() -> Result<()> {
    say!(
        "Rendering a raccoon with 260,000 strands for 75 seconds. Ctrl-C stops earlier and keeps the picture.\n\
         A first, noisy picture appears as out/raccoon.png after a few seconds.\n\
         This is the command: vellus render {OPTIONS} --time 75s\n"
    );
    let options = OPTIONS.split(' ').chain(["--time", "75s"]);
    let mut args = Command::parse_from(["vellus"].into_iter().chain(options)).args;
    args.preview = true;
    let result = render::run(&args);
    let has_ended = result.as_ref().map_or_else(|error| error.is::<Interrupted>(), |()| true);
    if has_ended && Path::new("out/raccoon.png").exists() {
        say!(
            "\nThe picture is out/raccoon.png. Next:\n  \
             vellus render {OPTIONS} --time 10m\n                       take ten minutes: less noise\n  \
             vellus render cat    render another scene; vellus scene lists all\n  \
             vellus --help        show all commands"
        );
    }
    result
}
