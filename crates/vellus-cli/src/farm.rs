//! `vellus farm`: many tasks, on this machine or on a render farm.

use crate::interrupt::Interrupt;
use crate::output;
use crate::terminal::Terminal;
use anyhow::{Result, bail};
use vellus_experiments::EXPERIMENTS;
use vellus_farm::{Command, Error};
use vellus_io::{Digest, Progress};

/// Runs the command.
pub fn run(command: &Command) -> Result<()> {
    let interrupt = Interrupt::watch()?;
    // Until tasks start, there is nothing to keep.
    interrupt.set_immediate(!matches!(command, Command::Task(_)));
    let terminal = Started { terminal: Terminal::with_interrupt(&interrupt), interrupt: &interrupt };
    let names = EXPERIMENTS.iter().map(|experiment| experiment.name);
    let result = command.run(std::env::current_exe()?, names, identity, &terminal);
    drop(terminal);
    if let Err(Some(Error::Stopped)) = result.as_ref().map_err(anyhow::Error::downcast_ref) {
        bail!(interrupt.error("finished tasks and checkpoints are kept; the same command continues".to_owned()));
    }
    output::write(None, result?.as_bytes())
}

/// The terminal, which hears of tasks as soon as they start. From then on, a signal lets them keep their results.
struct Started<'a> {
    terminal: Terminal,
    interrupt: &'a Interrupt,
}

impl Progress for Started<'_> {
    fn report(&self, done: f64, what: &str) {
        self.interrupt.set_immediate(false);
        self.terminal.report(done, what);
    }

    fn is_cancelled(&self) -> bool {
        self.terminal.is_cancelled()
    }
}

/// The identity of the picture that a command line renders.
fn identity(line: &[String]) -> Result<Digest> {
    match crate::parse(std::iter::once("vellus").chain(line.iter().map(String::as_str)).map(Into::into))?.command {
        Some(crate::Command::Render(args)) => crate::render::identity(&args),
        _ => bail!("this command renders no picture"),
    }
}
