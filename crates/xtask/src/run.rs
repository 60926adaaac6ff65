//! Runs commands, and reports the result and the time of each step.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// The result of a step that did not fail.
pub enum Outcome {
    /// It passed.
    Passed,
    /// It could not run, for this reason.
    Skipped(String),
}

/// A test, or something else, with its time in seconds.
pub struct Slow {
    pub name: String,
    pub seconds: f64,
}

/// The steps that have run so far, and what could not run.
pub struct Report {
    steps: Vec<(String, Duration, Outcome)>,
    /// The longest of these are printed.
    pub times: Vec<Slow>,
    /// A line for each test that could not run: its kind, its name and the reason. Tests write it.
    pub skipped: PathBuf,
    /// The kinds of tests that must not be skipped (`VELLUS_REQUIRE`), and the steps (`VELLUS_REQUIRE_STEPS`).
    pub required: [String; 2],
    /// The steps that took more than 1.5 times their minutes.
    late: Vec<String>,
}

/// How many of the slowest tests the report names.
const SLOWEST: usize = 10;

impl Report {
    /// An empty report. Removes the list of skipped tests of the run before.
    pub fn new(root: &Path) -> Self {
        let skipped = root.join("target/skipped.txt");
        std::fs::remove_file(&skipped).ok();
        let list = |name| std::env::var(name).unwrap_or_default();
        let required = ["VELLUS_REQUIRE", "VELLUS_REQUIRE_STEPS"].map(list);
        Self { steps: Vec::new(), times: Vec::new(), skipped, required, late: Vec::new() }
    }

    /// Runs a step that should take at most so many minutes on two cores.
    pub fn step(&mut self, name: &str, minutes: f64, work: impl FnOnce() -> Result<(), String>) -> Result<(), String> {
        self.attempt(name, minutes, || work().map(|()| Outcome::Passed))
    }

    /// Runs a step that can be skipped.
    pub fn attempt(
        &mut self,
        name: &str,
        minutes: f64,
        work: impl FnOnce() -> Result<Outcome, String>,
    ) -> Result<(), String> {
        eprintln!("== {name}");
        let start = Instant::now();
        let outcome = work().map_err(|message| format!("{name}: {message}"))?;
        let time = start.elapsed();
        if time.as_secs_f64() > 1.5 * 60.0 * minutes {
            self.late.push(format!("{name} took {:.1} minutes, {minutes} are planned", time.as_secs_f64() / 60.0));
        }
        self.steps.push((name.to_owned(), time, outcome));
        Ok(())
    }

    /// Prints a line for each step, the slowest tests, and every reason why something did not run.
    ///
    /// # Errors
    /// A skipped step that must run. A test that must run fails by itself. Steps that took too long, if
    /// `CI` is set: other machines may be slower.
    pub fn print(&mut self) -> Result<(), String> {
        self.times.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
        if !self.times.is_empty() {
            eprintln!("the slowest of {} tests:", self.times.len());
        }
        for Slow { name, seconds } in self.times.iter().take(SLOWEST) {
            eprintln!("{seconds:8.1} s  {name}");
        }
        eprintln!("steps:");
        for (name, time, outcome) in &self.steps {
            match outcome {
                Outcome::Passed => eprintln!("{:8.1} s  {name}", time.as_secs_f64()),
                Outcome::Skipped(reason) => eprintln!(" skipped    {name}: {reason}"),
            }
        }
        eprintln!("{:8.1} s  together", self.steps.iter().map(|(_, time, _)| time.as_secs_f64()).sum::<f64>());
        let text = std::fs::read_to_string(&self.skipped).unwrap_or_default();
        let mut lines: Vec<&str> = text.lines().collect();
        lines.sort_unstable();
        lines.dedup();
        if !lines.is_empty() {
            eprintln!("{} tests or parts of tests could not run:\n  {}", lines.len(), lines.join("\n  "));
        }
        self.late.iter().for_each(|line| eprintln!("too slow: {line}"));
        let skipped = self.steps.iter().filter(|(_, _, outcome)| matches!(outcome, Outcome::Skipped(_)));
        let missing: Vec<&str> =
            skipped.map(|(name, ..)| name.as_str()).filter(|n| requires(&self.required[1], n)).collect();
        if !missing.is_empty() {
            return Err(format!("required, but skipped: {}", missing.join(", ")));
        }
        if std::env::var_os("CI").is_some() && !self.late.is_empty() {
            return Err(format!("too slow: {}", self.late.join(", ")));
        }
        Ok(())
    }
}

/// Whether a list such as `torture,Blender` or `all,-Blender` requires a step.
fn requires(list: &str, step: &str) -> bool {
    let has = |wanted: &str| list.split(',').any(|word| word.trim() == wanted);
    has(step) || has("all") && !has(&format!("-{step}"))
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

/// The JSON values that a command prints, one a line. Its messages go to the terminal.
pub fn run_json(command: &mut Command) -> Result<Vec<Value>, String> {
    let line = line(command);
    let output = command.stderr(Stdio::inherit()).output().map_err(|e| format!("cannot run {line}: {e}"))?;
    if !output.status.success() {
        return Err(format!("failed ({}): {line}", output.status));
    }
    let text = String::from_utf8_lossy(&output.stdout);
    Ok(text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect())
}

/// Whether a command exists and succeeds. It prints nothing.
pub fn succeeds(command: &mut Command) -> bool {
    command.output().is_ok_and(|output| output.status.success())
}

fn line(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    words.map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::requires;

    #[test]
    fn lists_name_kinds_or_exclude_them() {
        assert!(requires("gpu, cc", "cc") && requires("all", "cc") && requires("all,-gpu", "cc"));
        assert!(!requires("", "cc") && !requires("gpu", "cc") && !requires("all,-gpu", "gpu"));
    }
}
