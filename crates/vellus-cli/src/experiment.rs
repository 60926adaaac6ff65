//! `vellus experiment`: reproduces the paper and measures its claims.

use crate::interrupt::Interrupt;
use crate::output;
use crate::say::note;
use crate::terminal::Terminal;
use anyhow::{Result, bail};
use std::path::PathBuf;
use vellus_experiments::{EXPERIMENTS, Experiment, Interrupted, Outcome, Quality, Run, Settings, Verdict};
use vellus_experiments::{run as run_one, write_report};

/// Experiments, quality and folder.
#[derive(clap::Args)]
pub struct Args {
    /// Names of experiments, or `all`. Without a name, or with `list`: list all experiments.
    #[arg(value_name = "NAME")]
    names: Vec<String>,
    /// How much work to put in.
    #[arg(long, value_enum, default_value_t)]
    quality: QualityArg,
    /// Folder to write to. Each experiment gets its own folder in it.
    #[arg(long, value_name = "DIR", default_value = "out/experiments")]
    out: PathBuf,
    /// Run finished experiments again.
    #[arg(long)]
    again: bool,
}

/// [`Quality`] on the command line.
#[derive(Clone, Copy, Debug, Default, clap::ValueEnum)]
enum QualityArg {
    /// Seconds in all. Shows that everything runs, and judges no claim.
    Smoke,
    /// About a quarter of an hour in all, on two cores.
    #[default]
    Draft,
    /// The quality of the paper: hours.
    Paper,
}

impl From<QualityArg> for Quality {
    fn from(quality: QualityArg) -> Quality {
        match quality {
            QualityArg::Smoke => Quality::Smoke,
            QualityArg::Draft => Quality::Draft,
            QualityArg::Paper => Quality::Paper,
        }
    }
}

/// Runs the command.
pub fn run(args: &Args) -> Result<()> {
    let chosen = choose(&args.names)?;
    if chosen.is_empty() {
        return output::write(None, listing().as_bytes());
    }
    let (folder, page) = (&args.out, args.out.join("index.html"));
    if folder.exists() && !folder.is_dir() {
        bail!("cannot write {}: it is not a folder", folder.display());
    }
    output::writable(&page)?;
    let settings = Settings { quality: args.quality.into(), folder: folder.clone(), again: args.again };
    let interrupt = Interrupt::watch()?;
    let terminal = Terminal::with_interrupt(&interrupt);
    let mut failed = Vec::new();
    for (i, experiment) in chosen.iter().enumerate() {
        let number = format!("{}/{} {}", i + 1, chosen.len(), experiment.name);
        let result = run_one(experiment, &settings, &terminal);
        terminal.clear();
        match result {
            Ok(Run::Kept(outcome)) => note!("{number}: is there, at {} quality", outcome.quality.name()),
            Ok(Run::Finished(outcome)) => {
                note!("{number}: {}", summary(&outcome));
                write_report(folder)?;
            }
            Err(e) if e.is::<Interrupted>() => {
                write_report(folder)?;
                bail!(interrupt.error(format!(
                    "finished experiments are in {}; unfinished pictures of {} are kept; the same command continues",
                    page.display(),
                    folder.join(experiment.name).display()
                )));
            }
            // The other experiments may still succeed.
            Err(e) => {
                note!("{number}: failed: {e:#}");
                failed.push(experiment.name);
            }
        }
    }
    write_report(folder)?;
    note!("wrote {}", page.display());
    if !failed.is_empty() {
        bail!("{} of {} experiments failed: {}", failed.len(), chosen.len(), failed.join(", "));
    }
    Ok(())
}

/// How many claims hold, and how long the experiment took.
fn summary(outcome: &Outcome) -> String {
    let count = |verdict: Verdict| outcome.claims.iter().filter(|c| c.verdict == verdict).count();
    let counts = Verdict::ALL.into_iter().map(|v| (v, count(v))).filter(|(_, n)| *n > 0);
    let mut parts: Vec<String> = counts.map(|(verdict, n)| verdict.count(n)).collect();
    parts.push(format!("{:.1} s", outcome.seconds));
    parts.join(", ")
}

/// The experiments named, in the order of the list.
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

/// All experiments as a table.
fn listing() -> String {
    let width = |of: fn(&Experiment) -> &str| EXPERIMENTS.iter().map(|e| of(e).chars().count()).max().unwrap_or(0);
    let (first, second) = (width(|e| e.name), width(|e| e.figure));
    let row = |e: &Experiment| format!("  {:first$}  {:second$}  {}\n", e.name, e.figure, e.title);
    let rows: String = EXPERIMENTS.iter().map(row).collect();
    format!("{rows}\nvellus experiment NAME… runs some of them, vellus experiment all runs all.\n")
}
