//! `vellus farm`: many tasks, on this machine or on a render farm.

use crate::interrupt::Interrupt;
use crate::output;
use crate::say::{note, say};
use crate::terminal::Terminal;
use anyhow::{Result, bail};
use vellus_experiments::EXPERIMENTS;
use vellus_farm::{Command, Error};
use vellus_io::Digest;

/// Runs the command.
pub fn run(command: &Command) -> Result<()> {
    let (interrupt, program) = (Interrupt::watch()?, std::env::current_exe()?);
    let terminal = Terminal::with_interrupt(&interrupt);
    let result = match command {
        Command::Plan(args) => {
            let plan = args.plan(&EXPERIMENTS.iter().map(|e| e.name).collect::<Vec<_>>(), identity)?;
            return Ok(say!("{} tasks in {}", plan.tasks().len(), plan.dir().display()));
        }
        Command::Status(args) => return output::write(None, args.text()?.as_bytes()),
        Command::Emit(args) => return Ok(say!("wrote {}", args.emit()?.display())),
        Command::Run(args) => args.run(program, &terminal),
        Command::Task(args) => args.run(program, &terminal),
    };
    drop(terminal);
    match result {
        Err(Error::Stopped) => {
            bail!(interrupt.error("finished tasks and checkpoints are kept; the same command continues".to_owned()))
        }
        result => Ok(note!("{}", result?)),
    }
}

/// The identity of the picture that a command line renders.
fn identity(line: &[String]) -> Result<Digest> {
    match crate::parse(std::iter::once("vellus").chain(line.iter().map(String::as_str)).map(Into::into))?.command {
        Some(crate::Command::Render(args)) => crate::render::identity(&args),
        _ => bail!("this command renders no picture"),
    }
}
