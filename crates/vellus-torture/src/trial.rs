//! One case of an attack: its folder, its runs and its findings.

use crate::child::{CPU_SECONDS, Call, Outcome, Sink};
use crate::dice::Dice;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Why a case ends early.
pub enum Stop {
    /// The time of the whole program is over.
    TimeIsOver,
    /// This program or the machine failed, not the attacked command.
    Broken(String),
}

impl From<std::io::Error> for Stop {
    fn from(e: std::io::Error) -> Self {
        Stop::Broken(e.to_string())
    }
}

impl From<anyhow::Error> for Stop {
    fn from(e: anyhow::Error) -> Self {
        Stop::Broken(format!("{e:#}"))
    }
}

/// A failure of the command.
pub struct Finding {
    /// The same for all findings with the same cause, as far as the program can know.
    pub kind: String,
    /// Details of this finding.
    pub detail: String,
}

/// The data that all cases share.
pub struct Bench {
    /// The command.
    pub vellus: PathBuf,
    /// The end of the program's time.
    pub deadline: Instant,
}

/// A case in progress.
pub struct Trial<'b> {
    pub bench: &'b Bench,
    pub dice: Dice,
    /// The folder in which the command runs.
    pub folder: PathBuf,
    /// Inputs tried.
    pub tried: u64,
    /// Signals sent while the command ran.
    pub kills: u64,
    /// Peak resident memory of a child, KiB.
    pub peak_kb: u64,
    pub findings: Vec<Finding>,
    /// The runs, as shell lines.
    pub script: String,
}

impl<'b> Trial<'b> {
    /// A case in an existing folder.
    pub fn new(bench: &'b Bench, dice: Dice, folder: PathBuf) -> Result<Self, Stop> {
        std::fs::create_dir_all(folder.join("tmp"))?;
        Ok(Trial { bench, dice, folder, tried: 0, kills: 0, peak_kb: 0, findings: Vec::new(), script: String::new() })
    }

    /// A call of the command in the case's folder, with arguments separated by spaces.
    pub fn vellus(&self, args: &str) -> Call {
        let call = Call {
            args: Vec::new(),
            folder: self.folder.clone(),
            stdout: Sink::Read,
            stderr: Sink::Read,
            file_blocks: None,
            umask: None,
            cpu_seconds: CPU_SECONDS,
            signal: None,
        };
        call.args(args)
    }

    /// A path in the case's folder.
    pub fn at(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Runs a call and records its line.
    pub fn run(&mut self, call: &Call) -> Result<Outcome, Stop> {
        writeln!(self.script, "{}", call.line(Path::new("vellus"))).ok();
        let outcome = call.run(&self.bench.vellus, self.bench.deadline)?;
        writeln!(self.script, "# {}", outcome.summary()).ok();
        self.peak_kb = self.peak_kb.max(outcome.peak_kb);
        Ok(outcome)
    }

    /// Runs a call that must succeed before the attack starts. A failure is a finding too.
    pub fn prepare(&mut self, call: &Call) -> Result<bool, Stop> {
        let outcome = self.run(call)?;
        let good = outcome.code == Some(0);
        if !good {
            let kind = format!("an undisturbed run fails: {}", outcome.short());
            self.finding(kind, call.line(Path::new("vellus")));
        }
        Ok(good)
    }

    /// Records a finding.
    pub fn finding(&mut self, kind: impl Into<String>, detail: impl Into<String>) {
        let (kind, detail) = (kind.into(), detail.into());
        writeln!(self.script, "# FINDING: {kind}\n#   {}", detail.replace('\n', "\n#   ")).ok();
        self.findings.push(Finding { kind, detail });
    }

    /// Checks that the command ended by itself, in time, without a panic, and with one of these exit codes.
    pub fn ended_with(&mut self, outcome: &Outcome, codes: &[i32], what: &str) -> bool {
        let good = !outcome.panicked() && outcome.code.is_some_and(|code| codes.contains(&code));
        if !good {
            let expected = codes.iter().map(i32::to_string).collect::<Vec<_>>().join(" or ");
            self.finding(
                format!("{what}: {}, not {expected}", outcome.short()),
                format!("{}\n{}", outcome.summary(), first_lines(&outcome.stderr)),
            );
        }
        good
    }
}

impl Outcome {
    /// Whether it panicked, whatever its exit code.
    pub fn panicked(&self) -> bool {
        self.code == Some(101) || self.stderr.contains("panicked")
    }

    /// How it ended: the same text for all runs with the same cause.
    pub fn short(&self) -> String {
        if self.panicked() {
            let place = self.stderr.lines().find_map(|line| line.split_once("panicked at ").map(|(_, place)| place));
            return format!("panic at {}", place.unwrap_or("an unknown place").trim_end_matches(':'));
        }
        match (self.timed_out, self.signal, self.code) {
            (true, ..) => "no end in time".to_owned(),
            (_, Some(6), _) if self.stderr.contains("memory allocation") => "abort, out of memory".to_owned(),
            (_, Some(24), _) => "too much processor time".to_owned(),
            (_, Some(signal), _) => format!("signal {signal}"),
            (_, _, Some(code)) => format!("exit code {code}"),
            _ => "unknown end".to_owned(),
        }
    }

    /// How it ended, and the resources that it used.
    pub fn summary(&self) -> String {
        let (cpu, mb) = (self.cpu.as_secs_f64(), self.peak_kb / 1024);
        let message = self.stderr.lines().last().unwrap_or("");
        let message: String = message.chars().filter(|c| !c.is_control()).take(300).collect();
        format!("{}, {cpu:.2} s of processor time, {mb} MB: {message}", self.short())
    }
}

/// The beginning of a message, without control characters.
fn first_lines(text: &str) -> String {
    let clean = text.lines().take(6).map(|line| {
        let line: String = line.chars().filter(|c| !c.is_control()).take(300).collect();
        line
    });
    clean.collect::<Vec<_>>().join("\n")
}
