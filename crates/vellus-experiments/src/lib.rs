//! `vellus experiment`: the paper's figures and tables, reproduced, and what they claim measured.

mod bars;
mod context;
mod curves;
mod energy;
mod grid;
mod list;
mod medulla_tables;
mod one_fiber;
mod outcome;
mod presets;
mod queries;
mod render_animals;
mod render_closeup;
mod render_convergence;
mod render_hair;
mod render_indices;
mod render_lobes;
mod render_zoom;
mod report;
mod scenes;
mod segments;
mod sheet;
mod shot;
mod species;
mod visible;

use crate::interrupt::Interrupt;
use crate::output;
use crate::say::note;
use anyhow::{Context as _, Result, bail};
pub use context::{Context, Interrupted};
use list::{EXPERIMENTS, Experiment};
pub use outcome::{Claim, Outcome, Picture, Table, Verdict};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

/// Which, how well, and where to.
#[derive(clap::Args)]
pub struct Args {
    /// Experiments by name; all is all of them. Without one, or with list, they are listed.
    #[arg(value_name = "NAME")]
    names: Vec<String>,
    /// How much work to put in.
    #[arg(long, value_enum, default_value_t)]
    quality: Quality,
    /// The folder to write to.
    #[arg(long, value_name = "DIR", default_value = "out/experiments")]
    out: PathBuf,
    /// Run also what is finished there.
    #[arg(long)]
    again: bool,
}

/// How much work is put in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, clap::ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Quality {
    /// Seconds in all; shows that everything runs, and judges nothing.
    Smoke,
    /// A quarter of an hour in all on two cores.
    #[default]
    Draft,
    /// As the paper; hours.
    Paper,
}

impl Quality {
    /// One of three, for smoke, draft and paper.
    pub fn pick<T>(self, smoke: T, draft: T, paper: T) -> T {
        match self {
            Quality::Smoke => smoke,
            Quality::Draft => draft,
            Quality::Paper => paper,
        }
    }

    /// In words.
    pub fn name(self) -> &'static str {
        self.pick("smoke", "draft", "paper")
    }
}

/// Runs them.
pub fn run(args: &Args) -> Result<()> {
    let chosen = choose(&args.names)?;
    if chosen.is_empty() {
        return output::write(None, listing().as_bytes());
    }
    if args.out.exists() && !args.out.is_dir() {
        bail!("cannot write {}: it is not a folder", args.out.display());
    }
    output::writable(&args.out.join("index.html"))?;
    let interrupt = Interrupt::watch()?;
    let mut failed = Vec::new();
    for (i, experiment) in chosen.iter().enumerate() {
        let folder = args.out.join(experiment.name);
        let number = format!("{}/{} {}", i + 1, chosen.len(), experiment.name);
        // Hours of paper quality are not written over by a draft.
        let finished = |o: &Outcome| o.quality >= args.quality && o.version == env!("CARGO_PKG_VERSION");
        if let Some(there) = Outcome::read(&folder).filter(|o| !args.again && finished(o)) {
            note!("{number}: is there, at {} quality", there.quality.name());
            continue;
        }
        let context = Context::new(args.quality, folder, args.again, Arc::clone(&interrupt.stop));
        match one(experiment, &context) {
            Ok(outcome) => {
                note!("{number}: {}", told(&outcome));
                report::write(&args.out)?;
            }
            Err(e) if e.is::<Interrupted>() || context.interrupted() => {
                report::write(&args.out)?;
                bail!(interrupt.error(format!(
                    "finished experiments are in {}, and what {} has of unfinished pictures is kept; the same \
                     command continues",
                    args.out.join("index.html").display(),
                    args.out.join(experiment.name).display()
                )));
            }
            // The others may still tell something.
            Err(e) => {
                note!("{number}: failed: {e:#}");
                failed.push(experiment.name);
            }
        }
    }
    report::write(&args.out)?;
    note!("wrote {}", args.out.join("index.html").display());
    if !failed.is_empty() {
        bail!("{} of {} experiments failed: {}", failed.len(), chosen.len(), failed.join(", "));
    }
    Ok(())
}

/// Runs one and keeps what it found.
fn one(experiment: &Experiment, context: &Context) -> Result<Outcome> {
    std::fs::create_dir_all(context.folder())
        .with_context(|| format!("cannot create {}", context.folder().display()))?;
    let start = Instant::now();
    let mut found = (experiment.run)(context)?;
    if context.quality == Quality::Smoke {
        found.withhold_verdicts();
    }
    let outcome = Outcome {
        name: experiment.name.to_owned(),
        figure: experiment.figure.to_owned(),
        title: experiment.title.to_owned(),
        seconds: start.elapsed().as_secs_f64(),
        quality: context.quality,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        threads: rayon::current_num_threads(),
        processor: processor(),
        ..found
    };
    outcome.write(context.folder())?;
    Ok(outcome)
}

/// What the system calls it, or its instructions.
fn processor() -> String {
    let known = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = known.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    name.map_or(std::env::consts::ARCH, |(_, name)| name.trim()).to_owned()
}

/// How many claims hold, and how long it took.
fn told(outcome: &Outcome) -> String {
    let count = |verdict: Verdict| outcome.claims.iter().filter(|c| c.verdict == verdict).count();
    let counts = Verdict::ALL.into_iter().map(|v| (v, count(v))).filter(|(_, n)| *n > 0);
    let mut parts: Vec<String> = counts.map(|(verdict, n)| verdict.count(n)).collect();
    parts.push(format!("{:.1} s", outcome.seconds));
    parts.join(", ")
}

/// In the order of the list, whatever the order of the names.
fn choose(names: &[String]) -> Result<Vec<&'static Experiment>> {
    if names.iter().any(|name| name == "list") {
        return Ok(Vec::new());
    }
    for name in names {
        if name != "all" && !EXPERIMENTS.iter().any(|e| e.name == name) {
            let known: Vec<_> = EXPERIMENTS.iter().map(|e| e.name).collect();
            bail!("there is no experiment '{name}' (known: {}, all)", known.join(", "));
        }
    }
    let chosen = |e: &&Experiment| names.iter().any(|name| name == "all" || name == e.name);
    Ok(EXPERIMENTS.iter().filter(chosen).collect())
}

fn listing() -> String {
    let row = |e: &Experiment| vec![e.name.to_owned(), e.figure.to_owned(), e.title.to_owned()];
    let rows: Vec<Vec<String>> = EXPERIMENTS.iter().map(row).collect();
    let width = |c: usize| rows.iter().map(|row| row[c].chars().count()).max().unwrap_or(0);
    let (first, second) = (width(0), width(1));
    let mut text: String =
        rows.iter().map(|row| format!("  {:first$}  {:second$}  {}\n", row[0], row[1], row[2])).collect();
    text += "\nvellus experiment NAME… runs some, vellus experiment all runs all of them.\n";
    text
}
