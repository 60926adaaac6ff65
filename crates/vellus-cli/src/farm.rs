//! `vellus farm`: many tasks, on this machine or on a render farm.

use crate::interrupt::Interrupt;
use crate::output;
use crate::terminal::Terminal;
use anyhow::{Result, bail};
use vellus_experiments::EXPERIMENTS;
use vellus_farm::{Command, Error};
use vellus_io::Digest;

/// Runs the command.
pub fn run(command: &Command) -> Result<()> {
    let interrupt = Interrupt::watch()?;
    let terminal = Terminal::with_interrupt(&interrupt);
    let names = EXPERIMENTS.iter().map(|experiment| experiment.name);
    let result = command.run(std::env::current_exe()?, names, identity, &terminal);
    drop(terminal);
    if let Err(Some(Error::Stopped)) = result.as_ref().map_err(anyhow::Error::downcast_ref) {
        bail!(interrupt.error("finished tasks and checkpoints are kept; the same command continues".to_owned()));
    }
    output::write(None, result?.as_bytes())
}

/// The identity of the picture that a command line renders.
fn identity(line: &[String]) -> Result<Digest> {
    match crate::parse(std::iter::once("vellus").chain(line.iter().map(String::as_str)).map(Into::into))?.command {
        Some(crate::Command::Render(args)) => crate::render::identity(&args),
        _ => bail!("this command renders no picture"),
    }
}
