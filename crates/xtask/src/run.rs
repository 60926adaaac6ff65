//! Runs commands, and reports the result and the time of each step.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// The result of a step that did not fail.
pub enum Outcome {
    /// It passed.
    Passed,
    /// It could not run, for this reason.
    Skipped(String),
}

/// The steps that have run so far.
#[derive(Default)]
pub struct Report {
    steps: Vec<(String, Duration, Outcome)>,
}

impl Report {
    /// Runs a step.
    pub fn step(&mut self, name: &str, work: impl FnOnce() -> Result<(), String>) -> Result<(), String> {
        self.attempt(name, || work().map(|()| Outcome::Passed))
    }

    /// Runs a step that can be skipped.
    pub fn attempt(&mut self, name: &str, work: impl FnOnce() -> Result<Outcome, String>) -> Result<(), String> {
        eprintln!("== {name}");
        let start = Instant::now();
        let outcome = work().map_err(|message| format!("{name}: {message}"))?;
        self.steps.push((name.to_owned(), start.elapsed(), outcome));
        Ok(())
    }

    /// Prints a line for each step, with every reason for a skipped one.
    pub fn print(&self) {
        for (name, time, outcome) in &self.steps {
            let seconds = time.as_secs_f64();
            match outcome {
                Outcome::Passed => eprintln!("{seconds:8.1} s  {name}"),
                Outcome::Skipped(reason) => eprintln!(" skipped    {name}: {reason}"),
            }
        }
    }
}

/// Runs cargo in a folder.
pub fn cargo(folder: &Path, args: &[&str]) -> Result<(), String> {
    run(Command::new("cargo").args(args).current_dir(folder))
}

/// Runs a command. The error names the command.
pub fn run(command: &mut Command) -> Result<(), String> {
    let line = line(command);
    eprintln!("> {line}");
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("failed ({status}): {line}")),
        Err(e) => Err(format!("cannot run {line}: {e}")),
    }
}

/// The standard output of a command.
pub fn output(command: &mut Command) -> Result<String, String> {
    let line = line(command);
    let output = command.output().map_err(|e| format!("cannot run {line}: {e}"))?;
    if output.status.success() {
        String::from_utf8(output.stdout).map_err(|e| format!("{line}: {e}"))
    } else {
        Err(format!("failed ({}): {line}\n{}", output.status, String::from_utf8_lossy(&output.stderr)))
    }
}

/// Whether a command exists and succeeds. It prints nothing.
pub fn succeeds(command: &mut Command) -> bool {
    command.output().is_ok_and(|output| output.status.success())
}

fn line(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    words.map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
}
