//! `vellus table`: the medulla's tables, built, described, checked.

use crate::interrupt::Interrupt;
use crate::number::whole;
use crate::output;
use crate::say::{note, say};
use crate::terminal::Terminal;
use anyhow::{Context, Result, bail};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use vellus::{TableData, Tables};
use vellus_io::Steps;
use vellus_sim::build::{Quality, Slab, SlabKind};
use vellus_sim::check::{ProfileError, TableKind, check_azimuthal, check_longitudinal, summary};

/// Photons that a simulated profile may have.
const PHOTONS: RangeInclusive<u64> = 1000..=1_000_000_000;

/// What to do.
#[derive(clap::Subcommand)]
pub enum Command {
    /// Simulate the medulla and compress the profiles into a table file.
    Build(Build),
    /// Describe a table file, or the shipped tables.
    Info {
        /// A table file; without it, the tables inside this program.
        file: Option<PathBuf>,
    },
    /// Compare a table file, or the shipped tables, with long simulations at random parameters.
    Check(Check),
}

/// How to build.
#[derive(clap::Args)]
pub struct Build {
    /// The table file to write.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// How much work to put in.
    #[arg(long, value_enum, default_value_t = Level::Shipping)]
    quality: Level,
    /// Photons a profile, instead of the quality's.
    #[arg(long, value_parser = whole::<u64>(PHOTONS), value_name = "N")]
    photons: Option<u64>,
    /// Seed; the same one gives the same file on any number of threads.
    #[arg(long, value_parser = whole::<u64>(0..=u64::MAX), value_name = "N")]
    seed: Option<u64>,
    /// Where finished pieces are kept until the table is written, so that an interrupted build goes on
    /// from them. Default: beside the table, with `.work` added.
    #[arg(long, value_name = "DIR")]
    work: Option<PathBuf>,
}

/// Named qualities.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Level {
    /// What this program ships: about 10 minutes on two cores.
    Shipping,
    /// Coarse, seconds: for tests.
    Smoke,
}

/// How to check.
#[derive(clap::Args)]
pub struct Check {
    /// A table file; without it, the tables inside this program.
    file: Option<PathBuf>,
    /// Random profiles of each table.
    #[arg(long, default_value_t = 40, value_parser = whole::<u64>(1..=1_000_000), value_name = "N")]
    profiles: u64,
    /// Photons a profile of the comparison; 32000000 for errors of 0.6 % to be seen.
    #[arg(long, default_value_t = 4_000_000, value_parser = whole::<u64>(PHOTONS), value_name = "N")]
    photons: u64,
    /// Seed of parameters and photons.
    #[arg(long, default_value_t = 7, value_parser = whole::<u64>(0..=u64::MAX), value_name = "N")]
    seed: u64,
    /// Also list every profile.
    #[arg(long)]
    all: bool,
}

/// Runs it.
pub fn run(command: &Command) -> Result<()> {
    match command {
        Command::Build(args) => build(args),
        Command::Info { file } => info(file.as_deref()),
        Command::Check(args) => check(args),
    }
}

/// The largest table file that is read: 1 GiB. The shipped tables have less than 1 MiB.
const MAX_TABLE_BYTES: u64 = 1 << 30;

pub fn load(file: Option<&Path>) -> Result<(TableData, usize)> {
    let read;
    let (bytes, place): (&[u8], _) = match file {
        None => (Tables::SHIPPED, "the shipped tables".to_owned()),
        Some(path) => {
            let place = path.display().to_string();
            read = vellus_io::read_at_most(path, MAX_TABLE_BYTES).with_context(|| format!("cannot read {place}"))?;
            (&read, place)
        }
    };
    Ok((TableData::from_bytes(bytes).with_context(|| place)?, bytes.len()))
}

fn build(args: &Build) -> Result<()> {
    let mut quality = match args.quality {
        Level::Shipping => Quality::shipping(),
        Level::Smoke => Quality::smoke(),
    };
    quality.photons = args.photons.unwrap_or(quality.photons);
    quality.seed = args.seed.unwrap_or(quality.seed);
    output::writable(&args.out)?;
    let work = match &args.work {
        Some(work) => work.clone(),
        None if args.out.metadata().is_ok_and(|m| !m.is_file()) => {
            bail!("{} is not a regular file: --work must say where to keep finished pieces", args.out.display())
        }
        None => {
            let mut name = args.out.as_os_str().to_owned();
            name.push(".work");
            PathBuf::from(name)
        }
    };
    std::fs::create_dir_all(&work).with_context(|| format!("cannot create {}", work.display()))?;
    let slabs = quality.slabs();
    let interrupt = Interrupt::watch()?;
    let terminal = Terminal::new();
    let steps = Steps::new(&terminal, slabs.len() as u64, "simulating");
    let mut results = Vec::new();
    for &slab in &slabs {
        if interrupt.is_set() {
            let kept = format!("finished pieces are in {}, the same command continues from them", work.display());
            return Err(interrupt.error(kept).into());
        }
        let path = work.join(slab_name(&quality, slab));
        let result = match read_slab(&path, quality.slab_len(slab)) {
            Some(result) => result,
            None => {
                let result = quality.simulate(slab);
                output::write(Some(&path), &result.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>())?;
                result
            }
        };
        results.push(result);
        steps.advance(1);
    }
    let data = quality.assemble(&results, &terminal);
    terminal.clear();
    let bytes = data.to_bytes()?;
    output::write(Some(&args.out), &bytes)?;
    // Only the pieces of this build; a folder that holds anything else stays.
    for &slab in &slabs {
        std::fs::remove_file(work.join(slab_name(&quality, slab))).ok();
    }
    std::fs::remove_dir(&work).ok();
    // Not to standard output, where the table itself may go.
    note!("wrote {}: {} bytes", args.out.display(), bytes.len());
    Ok(())
}

/// The name says all that the numbers depend on.
fn slab_name(quality: &Quality, slab: Slab) -> String {
    let [tau, g, h, theta] = quality.nodes;
    let kind = match slab.kind {
        SlabKind::Azimuthal => "azimuthal",
        SlabKind::Longitudinal => "longitudinal",
    };
    let Quality { directions, photons, seed, .. } = quality;
    format!("{kind}-{:02}-{tau}x{g}x{h}x{theta}x{directions}-{photons}-{seed}.f32", slab.tau)
}

/// A piece from an earlier run, if it is whole.
fn read_slab(path: &Path, len: usize) -> Option<Vec<f32>> {
    let bytes = vellus_io::read_at_most(path, 4 * len as u64).ok()?;
    (bytes.len() == 4 * len)
        .then(|| bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
}

fn info(file: Option<&Path>) -> Result<()> {
    let (data, bytes) = load(file)?;
    let mut rows = vec![["table", "rank", "τ", "g", "h or θ", "angles", "bytes"].map(str::to_owned).to_vec()];
    for (name, table) in
        [("C^N azimuthal", &data.azimuthal), ("C^M backward", &data.backward), ("C^M forward", &data.forward)]
    {
        let mut row = vec![name.to_owned(), table.rank.to_string()];
        row.extend(table.factors.iter().map(|f| (f.len() / table.rank).to_string()));
        row.push((2 * table.factors.iter().map(Vec::len).sum::<usize>()).to_string());
        rows.push(row);
    }
    let [tau, g, h] = data.mean_path_nodes;
    let path =
        ["⟨L⟩ mean path".to_owned(), String::new(), tau.to_string(), g.to_string(), h.to_string(), String::new()];
    rows.push(path.into_iter().chain([(2 * data.mean_path.len()).to_string()]).collect());
    say!("{}{bytes} bytes in all; half floats; every factor is non-negative", output::align(&rows));
    Ok(())
}

fn check(args: &Check) -> Result<()> {
    let (data, _) = load(args.file.as_deref())?;
    let terminal = Terminal::new();
    let steps = Steps::new(&terminal, 2 * args.profiles, "simulating");
    let mut errors: Vec<ProfileError> = Vec::new();
    for index in 0..args.profiles {
        errors.push(check_azimuthal(&data, args.photons, args.seed, index));
        steps.advance(1);
        errors.extend(check_longitudinal(&data, args.photons, args.seed, index));
        steps.advance(1);
    }
    terminal.clear();
    if args.all {
        let mut rows = vec![["", "τ", "g", "h or θ°", "L1 %", "noise %"].map(str::to_owned).to_vec()];
        for e in &errors {
            let [tau, g, last] = e.parameters;
            let last = if e.kind == TableKind::Azimuthal { last } else { last.to_degrees() };
            let values = [tau, g, last, 100.0 * e.l1, 100.0 * e.noise];
            rows.push([e.kind.name().to_owned()].into_iter().chain(values.map(|x| format!("{x:.3}"))).collect());
        }
        say!("{}", output::align(&rows));
    }
    let header = ["L1 error, % of the profile", "mean", "95th", "max", "simulation's noise"];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    for kind in TableKind::ALL {
        let of = |f: fn(&ProfileError) -> f64| summary(errors.iter().filter(|e| e.kind == kind).map(f).collect());
        let (l1, noise) = (of(|e| e.l1), of(|e| e.noise));
        let values = [l1.mean, l1.p95, l1.max, noise.mean].map(|x| format!("{:.2}", 100.0 * x));
        rows.push([kind.name().to_owned()].into_iter().chain(values).collect());
    }
    let path = summary(errors.iter().filter_map(|e| e.mean_path).map(f64::abs).collect());
    let values = [path.mean, path.p95, path.max].map(|x| format!("{:.2}", 100.0 * x));
    rows.push(["⟨L⟩, relative error %".to_owned()].into_iter().chain(values).collect());
    say!(
        "{}{} random profiles of each table, between its nodes, {} photons each; the error includes the noise",
        output::align(&rows),
        args.profiles,
        args.photons
    );
    Ok(())
}
