//! Reproduces the figures and tables of Yan, Jensen and Ramamoorthi 2017, and measures the claims of the paper.
//!
//! [`EXPERIMENTS`] lists the experiments. [`run`] runs one and writes its [`Outcome`] to a folder; [`write_report`]
//! makes one HTML page of all outcomes in a folder.
//!
//! ```no_run
//! use vellus_experiments::{EXPERIMENTS, Quality, Settings, run, write_report};
//! # fn main() -> anyhow::Result<()> {
//! let settings = Settings { quality: Quality::Draft, folder: "out/experiments".into(), again: false };
//! for experiment in EXPERIMENTS {
//!     run(experiment, &settings, &())?;
//! }
//! write_report(&settings.folder)?;
//! # Ok(()) }
//! ```
#![warn(clippy::print_stdout)]

mod animals;
mod beside;
mod closeup;
pub mod coat;
mod comparison;
mod context;
mod convergence;
mod energy;
mod exit;
pub mod flip;
mod grid;
mod hair;
mod indices;
mod list;
mod lobes;
mod medulla_tables;
mod one_fiber;
mod outcome;
mod presets;
mod printed_far;
mod quality;
mod queries;
mod report;
mod scenes;
mod segments;
mod shot;
mod species;
mod visible;
mod zoom;

pub use context::Interrupted;
pub use list::{EXPERIMENTS, Experiment, find, listing};
pub use outcome::{Claim, NOTHING, Outcome, Picture, Side, Slider, Table, Verdict};
pub use quality::Quality;
pub use report::write_report;

use anyhow::{Context as _, Result};
use context::Context;
use std::path::PathBuf;
use std::time::Instant;
use vellus_io::Progress;

/// Settings of a run.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The amount of work.
    pub quality: Quality,
    /// The folder of all experiments. Each experiment writes to a subfolder with its name.
    pub folder: PathBuf,
    /// Run finished experiments again, and ignore unfinished pictures of earlier runs.
    pub again: bool,
}

/// The outcome of an experiment, and whether this run finished it.
#[derive(Clone, Debug)]
pub enum Run {
    /// An earlier run had finished it, at this or a better quality, with the same version of this crate.
    Kept(Outcome),
    /// This run finished it.
    Finished(Outcome),
}

/// Runs an experiment and writes its outcome, unless an earlier run has done so.
///
/// Unfinished pictures are kept in the folder. The next run continues with them.
///
/// # Errors
/// [`Interrupted`] if `progress` cancels. Otherwise the reason why a file cannot be written or the experiment failed.
pub fn run(experiment: &Experiment, settings: &Settings, progress: &dyn Progress) -> Result<Run> {
    let folder = settings.folder.join(experiment.name);
    let is_finished = |o: &Outcome| o.quality >= settings.quality && o.version == env!("CARGO_PKG_VERSION");
    if let Some(outcome) = Outcome::read(&folder).filter(|o| !settings.again && is_finished(o)) {
        return Ok(Run::Kept(outcome));
    }
    std::fs::create_dir_all(&folder).with_context(|| format!("cannot create {}", folder.display()))?;
    let context = Context::new(settings.quality, folder, settings.again, progress);
    let start = Instant::now();
    // An error after an interruption is a consequence of it.
    let mut found = (experiment.run)(&context).or_else(|e| context.check_interrupted().and(Err(e)))?;
    if settings.quality == Quality::Smoke {
        found.withhold_verdicts();
    }
    let outcome = Outcome {
        name: experiment.name.to_owned(),
        figure: experiment.figure.to_owned(),
        title: experiment.title.to_owned(),
        seconds: start.elapsed().as_secs_f64(),
        quality: settings.quality,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        threads: rayon::current_num_threads(),
        processor: processor(),
        ..found
    };
    outcome.write(context.folder())?;
    Ok(Run::Finished(outcome))
}

/// The name of the processor, or its architecture if the system does not report the name.
fn processor() -> String {
    let known = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = known.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    name.map_or(std::env::consts::ARCH, |(_, name)| name.trim()).to_owned()
}
