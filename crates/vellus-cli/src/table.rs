//! `vellus table`: builds, describes and checks the tables of the medulla.

use crate::interrupt::Interrupt;
use crate::number::one_of;
use crate::output;
use crate::say::{note, say};
use crate::terminal::Terminal;
use anyhow::{Result, bail};
use std::path::PathBuf;
use vellus_io::parse;
use vellus_plot::medulla::PHOTONS;
use vellus_plot::text;
use vellus_reference::simulate::build::Quality;
use vellus_reference::simulate::{check, read_tables, resume};

#[derive(clap::Subcommand)]
pub enum Command {
    /// Simulate the medulla and write a table file.
    Build(Build),
    /// Describe a table file.
    Info {
        /// Table file. Default: the tables that vellus contains.
        file: Option<PathBuf>,
    },
    /// Compare a table file with simulations at random parameters.
    Check(Check),
}

#[derive(clap::Args)]
pub struct Build {
    /// Table file to write.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Simulate the table of first exits too, and write it to this file.
    #[arg(long, value_name = "FILE")]
    exits: Option<PathBuf>,
    /// Quality: shipping is that of the tables that vellus contains, smoke is a fast test.
    #[arg(long, value_parser = one_of::<Quality>(Quality::NAMES), default_value = "shipping", value_name = "NAME")]
    quality: Quality,
    /// Photons per profile. Default: depends on the quality.
    #[arg(long, value_parser = parse::whole::<u64>(PHOTONS), value_name = "N")]
    photons: Option<u64>,
    /// Seed. The same seed gives the same file, with any number of threads.
    #[arg(long, value_parser = parse::whole::<u64>(0..=u64::MAX), value_name = "N")]
    seed: Option<u64>,
    /// Folder for finished pieces, from which an interrupted build continues. Default: FILE.work.
    #[arg(long, value_name = "DIR")]
    work: Option<PathBuf>,
}

#[derive(clap::Args)]
pub struct Check {
    /// Table file. Default: the tables that vellus contains.
    file: Option<PathBuf>,
    /// Random profiles of each table.
    #[arg(long, default_value_t = 40, value_parser = parse::whole::<u64>(1..=1_000_000), value_name = "N")]
    profiles: u64,
    /// Photons per simulated profile. Errors of 0.6 % need 32000000.
    #[arg(long, default_value_t = 4_000_000, value_parser = parse::whole::<u64>(PHOTONS), value_name = "N")]
    photons: u64,
    /// Seed of the parameters and of the photons.
    #[arg(long, default_value_t = 7, value_parser = parse::whole::<u64>(0..=u64::MAX), value_name = "N")]
    seed: u64,
    /// List every profile.
    #[arg(long)]
    all: bool,
}

pub fn run(command: &Command) -> Result<()> {
    match command {
        Command::Build(args) => build(args),
        Command::Info { file } => {
            let (data, bytes) = read_tables(file.as_deref())?;
            say!("{}{bytes} bytes in all; half floats; every factor is non-negative", text::table_info(&data));
            Ok(())
        }
        Command::Check(args) => check(args),
    }
}

fn build(args: &Build) -> Result<()> {
    let mut quality = args.quality.clone();
    quality.photons = args.photons.unwrap_or(quality.photons);
    quality.seed = args.seed.unwrap_or(quality.seed);
    output::writable(&args.out)?;
    let work = match &args.work {
        Some(work) => work.clone(),
        None if args.out.metadata().is_ok_and(|m| !m.is_file()) => {
            bail!("{} is not a regular file: give a folder for finished pieces with --work", args.out.display())
        }
        None => resume::work_folder(&args.out),
    };
    let interrupt = Interrupt::watch()?;
    let terminal = Terminal::with_interrupt(&interrupt);
    let result = resume::build(&quality, &work, &terminal);
    terminal.clear();
    if let Err(resume::Error::Cancelled(folder)) = &result {
        let kept = format!("finished pieces are in {}; the same command continues", folder.display());
        return Err(interrupt.error(kept).into());
    }
    let bytes = result?.to_bytes()?;
    output::write(Some(&args.out), &bytes)?;
    resume::remove_slabs(&quality, &work);
    // This does not go to standard output, because --out may be /dev/stdout.
    note!("wrote {}: {} bytes", args.out.display(), bytes.len());
    if let Some(path) = &args.exits {
        output::write(Some(path), &quality.exits.build(quality.seed, &terminal).to_bytes())?;
        terminal.clear();
    }
    Ok(())
}

fn check(args: &Check) -> Result<()> {
    let (data, _) = read_tables(args.file.as_deref())?;
    let errors = check::check(&data, args.profiles, args.photons, args.seed, &Terminal::new());
    if args.all {
        say!("{}", text::profile_errors(&errors));
    }
    say!(
        "{}{} random profiles of each table, between its nodes, {} photons each; the error includes the noise",
        text::table_errors(&errors),
        args.profiles,
        args.photons
    );
    Ok(())
}
