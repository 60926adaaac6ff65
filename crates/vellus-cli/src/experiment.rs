//! `vellus experiment`: reproduces the paper and measures its claims.

use crate::interrupt::Interrupt;
use crate::number::one_of;
use crate::output;
use crate::say::note;
use crate::terminal::Terminal;
use anyhow::{Result, bail};
use std::path::PathBuf;
use vellus_experiments::{Interrupted, Quality, Run, Settings, find, listing, run as run_one, write_report};

/// Experiments, quality and folder.
#[derive(clap::Args)]
pub struct Args {
    /// Names of experiments, or `all`. Without a name, or with `list`: list all experiments.
    #[arg(value_name = "NAME")]
    names: Vec<String>,
    /// How much work to put in: smoke takes seconds and judges no claim, draft takes a quarter of an hour on two
    /// cores, paper takes hours.
    #[arg(long, value_parser = one_of::<Quality>(Quality::ALL.map(Quality::name)), default_value = "draft")]
    quality: Quality,
    /// Folder to write to. Each experiment gets its own folder in it.
    #[arg(long, value_name = "DIR", default_value = "out/experiments")]
    out: PathBuf,
    /// Run finished experiments again.
    #[arg(long)]
    again: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<()> {
    if args.names.is_empty() || args.names.iter().any(|name| name == "list") {
        return output::write(
            None,
            format!("{}\nvellus experiment NAME… runs some of them, vellus experiment all runs all.\n", listing())
                .as_bytes(),
        );
    }
    let chosen = find(&args.names)?;
    let (folder, page) = (&args.out, args.out.join("index.html"));
    if folder.exists() && !folder.is_dir() {
        bail!("cannot write {}: it is not a folder", folder.display());
    }
    output::writable(&page)?;
    let settings = Settings { quality: args.quality, folder: folder.clone(), again: args.again };
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
                note!("{number}: {}", outcome.summary());
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
