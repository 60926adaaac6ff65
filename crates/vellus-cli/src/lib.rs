//! The command `vellus`: a renderer and tools for hair and fur. The two functions here are its main function and its
//! definition; other programs use the libraries that it is made of.
// `println!` panics when standard output is closed or full.
#![warn(clippy::print_stdout)]

mod demo;
mod energy;
mod eval;
mod exit;
mod experiment;
mod farm;
mod fiber;
mod fiber_args;
mod fit;
mod groom;
mod interrupt;
mod live;
mod model_args;
mod number;
mod output;
mod plot;
mod reference;
mod render;
mod say;
mod scene;
mod shaders;
mod table;
mod terminal;

use anyhow::{Context, Result};
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use say::note;
use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;

/// Hair and fur: a path tracer, and the reflectance model of Yan, Jensen and Ramamoorthi 2017.
///
/// Without a subcommand, it renders a raccoon for 75 seconds. A good start: vellus scene, then vellus render cat.
///
/// Angles are in degrees, lengths in fibre radii, absorption and scattering per fibre radius. θ is the angle to the
/// plane normal to the fibre, φ the azimuth between the two directions, h the offset of the hit, in [-1, 1].
#[derive(Parser)]
#[command(name = "vellus", version, after_help = exit::HELP)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// List the presets and the parameters of fibres, or show one fibre.
    #[command(subcommand)]
    Fiber(fiber::Command),
    /// Evaluate the model for one query, or for a CSV file of queries.
    Eval(eval::Args),
    /// Compute the energy of each lobe: in closed form, and integrated over the sphere.
    Energy(energy::Args),
    /// Plot lobes, profiles, energies, errors or medulla tables as PNG and SVG.
    Plot(plot::Args),
    /// Build, describe or check medulla tables.
    #[command(subcommand)]
    Table(table::Command),
    /// Render a scene to OpenEXR and PNG.
    Render(Box<render::Args>),
    // No comment here: the help text is the one of its arguments.
    Live(vellus_live::Args),
    /// List the built-in scenes, or write one as USD.
    Scene(scene::Args),
    /// Describe, convert or grow strands.
    #[command(subcommand)]
    Groom(groom::Command),
    // No comment here: the help text is the one of its arguments.
    Fit(Box<fit::Args>),
    /// Reproduce the figures and tables of the paper, and check its claims.
    ///
    /// Each experiment writes to its own folder in --out. The page index.html shows all results. An experiment that is
    /// finished at this quality or a better one, with the same version of vellus, does not run again. After Ctrl-C, the
    /// same command continues.
    Experiment(experiment::Args),
    /// Plan many tasks, and run them on this machine or on a render farm.
    #[command(subcommand)]
    Farm(vellus_farm::Command),
    /// Merge films of sample ranges that `render --samples` wrote.
    Merge(render::MergeArgs),
    /// Write the model for shaders of other renderers: WGSL, GLSL, HLSL, MSL, SPIR-V, and buffers of fibres.
    Shaders(shaders::Args),
    /// Simulate a whole fibre with photons, and compare its energies with those of the model.
    Reference(reference::Args),
}

/// The definition of the command: what it takes, and its help. `examples/manual.rs` writes it as manual pages.
pub fn command() -> clap::Command {
    Cli::command()
}

/// Runs the command with the arguments of this process.
pub fn main() -> ExitCode {
    if let Some(missing) = vellus::missing_instructions() {
        say::without_instructions(missing);
        return ExitCode::from(exit::BAD_INPUT);
    }
    vellus_farm::begin();
    vellus_usd::quiet_caught_panics();
    interrupt::survive_file_size_limit();
    let result = match parse(std::env::args_os()) {
        Ok(cli) => run(cli.command),
        // Help and version arrive here, too.
        Err(error) => match print(&error) {
            Ok(()) => return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(exit::BAD_INPUT)),
            Err(error) => Err(error).context("cannot write to standard output"),
        },
    };
    let result = result.and_then(|()| say::check().context("cannot write to standard output"));
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let (code, message) = exit::report(&error);
            note!("{message}");
            ExitCode::from(code)
        }
    }
}

/// Reads the command line. Every option accepts negative numbers: the error message can then name the allowed range.
fn parse(line: impl IntoIterator<Item = OsString>) -> Result<Cli, clap::Error> {
    fn with_negative_numbers(command: clap::Command) -> clap::Command {
        command.allow_negative_numbers(true).mut_subcommands(with_negative_numbers)
    }
    let mut command = with_negative_numbers(Cli::command());
    let matches = command.try_get_matches_from_mut(line)?;
    Cli::from_arg_matches(&matches).map_err(|error| error.format(&mut command))
}

/// Prints a message of the command-line parser: an error, help or the version.
fn print(error: &clap::Error) -> std::io::Result<()> {
    match error.print().and_then(|()| std::io::stdout().flush()) {
        // Standard error is closed, or the reader of the pipe has quit.
        Err(e) if error.use_stderr() || e.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        result => result,
    }
}

fn run(command: Option<Command>) -> Result<()> {
    match command {
        None => demo::run(),
        Some(Command::Fiber(command)) => fiber::run(&command),
        Some(Command::Eval(args)) => eval::run(&args),
        Some(Command::Energy(args)) => energy::run(&args),
        Some(Command::Plot(args)) => plot::run(&args),
        Some(Command::Table(command)) => table::run(&command),
        Some(Command::Render(args)) => render::run(&args),
        Some(Command::Live(args)) => live::run(&args),
        Some(Command::Scene(args)) => scene::run(&args),
        Some(Command::Groom(command)) => groom::run(&command),
        Some(Command::Fit(args)) => fit::run(&args),
        Some(Command::Experiment(args)) => experiment::run(&args),
        Some(Command::Farm(command)) => farm::run(&command),
        Some(Command::Merge(args)) => render::merge(&args),
        Some(Command::Shaders(args)) => shaders::run(&args),
        Some(Command::Reference(args)) => reference::run(&args),
    }
}
