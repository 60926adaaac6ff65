//! The command `vellus`: the fur reflectance model from the shell.

mod demo;
mod energy;
mod eval;
mod exit;
mod experiment;
mod fiber;
mod fiber_args;
mod fit;
mod groom;
mod interrupt;
mod model_args;
mod number;
mod output;
mod plot;
mod query;
mod reference;
mod render;
mod say;
mod scene;
mod table;
mod terminal;

use anyhow::{Context, Result};
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use say::note;
use std::io::Write;
use std::process::ExitCode;

/// Hair and fur: the reflectance model of Yan, Jensen and Ramamoorthi 2017, and a path tracer.
///
/// Angles are in degrees, lengths in fibre radii, absorption and scattering per fibre radius. θ is measured
/// from the plane normal to the fibre, x runs from root to tip, φ is the azimuth between both
/// directions, h the offset at which the fibre is hit.
///
/// Without a subcommand: renders a raccoon for 75 seconds.
#[derive(Parser)]
#[command(name = "vellus", version, after_help = exit::HELP)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// List the preset fibres, or show one.
    #[command(subcommand)]
    Fiber(fiber::Command),
    /// Evaluate the model: one query, or a CSV of them.
    Eval(eval::Args),
    /// Energy of each lobe in closed form beside the integral of `eval` over the sphere.
    Energy(energy::Args),
    /// Draw lobes, profiles, medulla tables or energies to PNG and SVG.
    #[command(subcommand)]
    Plot(plot::Command),
    /// Build, describe or check the tables of light scattered by the medulla.
    #[command(subcommand)]
    Table(table::Command),
    /// Path-trace a scene to OpenEXR and PNG.
    Render(Box<render::Args>),
    /// List the built-in scenes, or write one as USD.
    Scene(scene::Args),
    /// What is in a groom, and other formats of it.
    #[command(subcommand)]
    Groom(groom::Command),
    // Without a line of its own here, so that `--help` has all that its arguments say.
    Fit(Box<fit::Args>),
    /// Reproduce the paper: pictures, numbers, and one page (index.html) that says what holds.
    ///
    /// Each experiment writes into a folder of its own in --out. One that is finished, at this quality or a better one and by the same
    /// version of this program, is not run again; Ctrl-C leaves what is finished, and the same command goes on.
    Experiment(experiment::Args),
    /// Put together films that `render --samples` rendered apart.
    Merge(render::MergeArgs),
    /// Monte Carlo of the whole fibre, beside the model's energies.
    Reference(reference::Args),
}

/// What this program was compiled for (`.cargo/config.toml`), and the processor may lack.
fn missing_instructions() -> Option<&'static str> {
    #[cfg(target_arch = "x86_64")]
    {
        let has = |there: bool, needed: bool| there || !needed;
        if !has(is_x86_feature_detected!("avx2"), cfg!(target_feature = "avx2")) {
            return Some("AVX2");
        }
        if !has(is_x86_feature_detected!("fma"), cfg!(target_feature = "fma")) {
            return Some("FMA");
        }
    }
    None
}

fn main() -> ExitCode {
    if let Some(missing) = missing_instructions() {
        note!(
            "error: this program was compiled for processors with {missing}, which this one lacks: delete the lines \
             about it in .cargo/config.toml and compile it again"
        );
        return ExitCode::from(exit::BAD_INPUT);
    }
    vellus_usd::quiet_caught_panics();
    interrupt::survive_file_size_limit();
    let result = match parse() {
        Ok(cli) => run(cli.command),
        // Help and version too.
        Err(error) => match said(&error) {
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

/// Reads the command line. Negative numbers are values of every option, so that a message can name the range of the
/// option.
fn parse() -> Result<Cli, clap::Error> {
    fn with_negative_numbers(command: clap::Command) -> clap::Command {
        command.allow_negative_numbers(true).mut_subcommands(with_negative_numbers)
    }
    let mut command = with_negative_numbers(Cli::command());
    let matches = command.try_get_matches_from_mut(std::env::args_os())?;
    Cli::from_arg_matches(&matches).map_err(|error| error.format(&mut command))
}

/// Prints what the parser of the command line has to say.
fn said(error: &clap::Error) -> std::io::Result<()> {
    match error.print().and_then(|()| std::io::stdout().flush()) {
        // A closed standard error or a reader that has enough.
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
        Some(Command::Plot(command)) => plot::run(&command),
        Some(Command::Table(command)) => table::run(&command),
        Some(Command::Render(args)) => render::run(&args),
        Some(Command::Scene(args)) => scene::run(&args),
        Some(Command::Groom(command)) => groom::run(&command),
        Some(Command::Fit(args)) => fit::run(&args),
        Some(Command::Experiment(args)) => experiment::run(&args),
        Some(Command::Merge(args)) => render::merge(&args),
        Some(Command::Reference(args)) => reference::run(&args),
    }
}
