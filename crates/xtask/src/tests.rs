//! Builds the test programs of the workspace and runs them side by side.
//!
//! The reason of `#[ignore]` names the tier of a test: `"test: 30 fits"` or `"full: 105 million queries"`. A test
//! without `#[ignore]` is in every tier.
//!
//! The programs print JSON (the unstable format of the standard test harness), so that the next program starts while
//! the last tests of the one before still run, a test that hangs has a name, and the report has times.

use crate::run::{Slow, run as run_command, run_json};
use serde_json::Value;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

/// A test that takes this many seconds gets a line as soon as it ends.
const LONG: f64 = 10.0;

/// How much is tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Tier {
    /// Before each commit.
    Check,
    /// Before each merge, and in CI.
    Test,
    /// At night and before a release.
    Full,
}

impl Tier {
    /// The name, which tests read from `VELLUS_TIER`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Check => "check",
            Self::Test => "test",
            Self::Full => "full",
        }
    }

    /// The longest time for one test. It ends a test that waits for ever.
    fn limit(self) -> Duration {
        Duration::from_secs(match self {
            Self::Check => 120,
            Self::Test => 300,
            Self::Full => 3600,
        })
    }

    /// The tier of a test by the reason of its `#[ignore]`, or `None` if the reason names no tier.
    fn of(reason: &str) -> Option<Self> {
        match reason.split_once(": ")?.0 {
            "test" => Some(Self::Test),
            "full" => Some(Self::Full),
            _ => None,
        }
    }
}

/// A test program.
pub struct Program {
    /// The folder of its package. Tests run there, as under `cargo test`.
    folder: PathBuf,
    file: PathBuf,
    /// Package and target.
    name: String,
    tests: Vec<Test>,
}

struct Test {
    name: String,
    tier: Tier,
    /// Why it is not in `check`.
    reason: String,
}

/// What one program reports.
enum Event {
    Started(String),
    Ended { test: String, seconds: f64, failure: Option<String> },
    Closed,
}

/// A program that runs.
struct Running<'a> {
    program: &'a Program,
    child: Child,
    log: PathBuf,
    /// The tests that have started and not ended.
    tests: Vec<(String, Instant)>,
    /// The number of tests that have not started.
    waiting: usize,
}

/// The result of all programs.
#[derive(Default)]
pub struct Summary {
    /// The number of tests that ran.
    pub count: usize,
    /// All tests with their times.
    pub times: Vec<Slow>,
    failures: Vec<String>,
}

/// Compiles the workspace: test programs, and what the tests of the bindings need. One call has one set of features
/// for each dependency, so nothing is compiled twice. Returns the messages of Cargo.
///
/// # Errors
/// A compiler error.
pub fn compile(root: &Path) -> Result<Vec<Value>, String> {
    let mut cargo = Command::new("cargo");
    cargo.args(["build", "--quiet", "--workspace", "--all-features", "--lib", "--bins", "--tests", "--example=batch"]);
    run_json(cargo.arg("--message-format=json-render-diagnostics").current_dir(root))
}

/// Compiles all test programs and lists their tests.
///
/// # Errors
/// A compiler error, or a test whose `#[ignore]` names no tier.
pub fn build(root: &Path) -> Result<Vec<Program>, String> {
    let mut programs = Vec::new();
    for message in compile(root)? {
        let Some(file) = message["executable"].as_str().filter(|_| message["profile"]["test"] == true) else {
            continue;
        };
        let manifest = PathBuf::from(message["manifest_path"].as_str().unwrap_or_default());
        let folder = manifest.parent().unwrap_or(root).to_owned();
        let package = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let target = &message["target"];
        let name = match target["kind"][0].as_str() {
            Some("test" | "example") => format!("{package}/{}", target["name"].as_str().unwrap_or_default()),
            Some("bin") => format!("{package}/bin"),
            _ => package,
        };
        let tests = list(Path::new(file), &name)?;
        if !tests.is_empty() {
            programs.push(Program { folder, file: file.into(), name, tests });
        }
    }
    programs.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(programs)
}

/// The tests in a program.
fn list(file: &Path, program: &str) -> Result<Vec<Test>, String> {
    let found = run_json(harness(file).arg("--list"))?;
    let tests = found.into_iter().filter(|event| event["event"] == "discovered").map(|event| {
        let name = event["name"].as_str().unwrap_or_default().to_owned();
        let reason = event["ignore_message"].as_str().unwrap_or_default().to_owned();
        let tier = if event["ignore"] == true { Tier::of(&reason) } else { Some(Tier::Check) };
        match tier {
            Some(tier) => Ok(Test { name, tier, reason }),
            None => Err(format!(
                "{program}, {name}: the reason of #[ignore] is {reason:?}, it must begin with \"test: \" or \"full: \""
            )),
        }
    });
    tests.collect()
}

/// A test program with output in JSON, which stable compilers allow with `RUSTC_BOOTSTRAP`.
fn harness(file: &Path) -> Command {
    let mut command = Command::new(file);
    command.args(["-Z", "unstable-options", "--format", "json"]).env("RUSTC_BOOTSTRAP", "1");
    command
}

/// Runs the tests that write what they would compare: those whose names begin with `generated_`.
///
/// # Errors
/// The first program that fails.
pub fn generate(programs: &[Program]) -> Result<(), String> {
    for program in programs {
        let name = |test: &Test| test.name.rsplit("::").next().is_some_and(|name| name.starts_with("generated_"));
        let chosen: Vec<&str> = program.tests.iter().filter(|t| name(t)).map(|t| t.name.as_str()).collect();
        if !chosen.is_empty() {
            let mut command = Command::new(&program.file);
            command.args(["--exact", "--include-ignored"]).args(chosen).current_dir(&program.folder);
            command.env("CARGO_MANIFEST_DIR", &program.folder).env("VELLUS_WRITE", "1");
            run_command(&mut command)?;
        }
    }
    Ok(())
}

/// Prints all tests that are not in `check`, with their tiers and reasons.
pub fn print(programs: &[Program]) {
    for tier in [Tier::Check, Tier::Test, Tier::Full] {
        let count = programs.iter().flat_map(|program| &program.tests).filter(|test| test.tier == tier).count();
        println!("{count} tests from `{}` on", tier.name());
        for program in programs.iter().filter(|_| tier > Tier::Check) {
            for test in program.tests.iter().filter(|test| test.tier == tier) {
                println!("  {} {}: {}", program.name, test.name, test.reason);
            }
        }
    }
}

/// Runs the tests of a tier. `folder` gets what the programs print. `environment` is set for all of them.
///
/// # Errors
/// The names of all tests that failed or did not end in time. What they printed is on the standard error.
pub fn run(programs: &[Program], tier: Tier, folder: &Path, environment: &[(&str, String)]) -> Result<Summary, String> {
    std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let threads = std::env::var("RUST_TEST_THREADS").ok().and_then(|n| n.parse().ok());
    let threads: usize = threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, Into::into));
    let mut queue = programs.iter().filter(|program| program.tests.iter().any(|test| test.tier <= tier));
    let mut running: Vec<Option<Running>> = Vec::new();
    let (sender, events) = channel();
    let mut summary = Summary::default();
    loop {
        // The next program starts when no test waits and a core is idle.
        let active = || running.iter().flatten();
        let idle = active().map(|r| r.tests.len()).sum::<usize>() < threads && active().all(|r| r.waiting == 0);
        if idle && let Some(program) = queue.next() {
            let started = start(program, tier, threads, folder, environment, running.len(), &sender)?;
            running.push(Some(started));
            continue;
        }
        if active().next().is_none() {
            break;
        }
        next(&events, &mut running, tier.limit(), &mut summary);
    }
    if summary.failures.is_empty() {
        Ok(summary)
    } else {
        Err(format!("{} tests failed:\n  {}", summary.failures.len(), summary.failures.join("\n  ")))
    }
}

fn start<'a>(
    program: &'a Program,
    tier: Tier,
    threads: usize,
    folder: &Path,
    environment: &[(&str, String)],
    index: usize,
    events: &Sender<(usize, Event)>,
) -> Result<Running<'a>, String> {
    let mut command = harness(&program.file);
    command.args(["--report-time", "--test-threads", &threads.to_string()]);
    command.env("CARGO_MANIFEST_DIR", &program.folder).env("VELLUS_TIER", tier.name());
    command.envs(environment.iter().map(|(name, value)| (name, value))).current_dir(&program.folder);
    let chosen: Vec<&str> = program.tests.iter().filter(|t| t.tier <= tier).map(|t| t.name.as_str()).collect();
    if tier > Tier::Check {
        command.args(["--include-ignored", "--exact"]).args(&chosen);
    }
    let log = folder.join(format!("{}.log", program.name.replace('/', "-")));
    let file = File::create(&log).map_err(|e| format!("{}: {e}", log.display()))?;
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(file);
    let mut child = command.spawn().map_err(|e| format!("{}: {e}", program.file.display()))?;
    if let Some(output) = child.stdout.take() {
        let events = events.clone();
        std::thread::spawn(move || {
            for line in BufReader::new(output).lines().map_while(Result::ok) {
                // Children of tests may print here, too.
                if let Some(event) = serde_json::from_str(&line).ok().and_then(|line| event(&line)) {
                    events.send((index, event)).ok();
                }
            }
            events.send((index, Event::Closed)).ok();
        });
    }
    Ok(Running { program, child, log, tests: Vec::new(), waiting: chosen.len() })
}

fn event(line: &Value) -> Option<Event> {
    let test = line["name"].as_str().filter(|_| line["type"] == "test")?.to_owned();
    let seconds = line["exec_time"].as_f64().unwrap_or_default();
    match line["event"].as_str()? {
        "started" => Some(Event::Started(test)),
        "ok" => Some(Event::Ended { test, seconds, failure: None }),
        "failed" => {
            let output = line["stdout"].as_str().or(line["message"].as_str()).unwrap_or_default();
            Some(Event::Ended { test, seconds, failure: Some(output.to_owned()) })
        }
        _ => None,
    }
}

/// Waits for an event and takes note of it. Ends a program of which a test has taken too long.
fn next(events: &Receiver<(usize, Event)>, running: &mut [Option<Running>], limit: Duration, summary: &mut Summary) {
    match events.recv_timeout(Duration::from_secs(1)) {
        Ok((index, Event::Closed)) => {
            if let Some(ended) = running[index].take() {
                close(ended, summary);
            }
        }
        Ok((index, event)) => {
            if let Some(program) = &mut running[index] {
                program.note(event, summary);
            }
        }
        // A child of a test can keep the pipe of a program open that has ended.
        Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {
            for place in running.iter_mut() {
                if let Some(ended) = place.take_if(|r| r.child.try_wait().is_ok_and(|status| status.is_some())) {
                    close(ended, summary);
                }
            }
        }
    }
    for place in running.iter_mut() {
        let late = |r: &mut Running| r.tests.iter().any(|(_, start)| start.elapsed() > limit);
        if let Some(mut ended) = place.take_if(late) {
            eprintln!("a test is not done after {} s: its program ends", limit.as_secs());
            ended.child.kill().ok();
            close(ended, summary);
        }
    }
}

impl Running<'_> {
    fn note(&mut self, event: Event, summary: &mut Summary) {
        match event {
            Event::Started(test) => {
                self.waiting = self.waiting.saturating_sub(1);
                self.tests.push((test, Instant::now()));
            }
            Event::Ended { test, seconds, failure } => {
                self.tests.retain(|(name, _)| *name != test);
                let name = format!("{} {test}", self.program.name);
                if let Some(output) = failure {
                    eprintln!("FAILED {name}\n{output}");
                    summary.failures.push(name.clone());
                }
                if seconds >= LONG {
                    eprintln!("{seconds:8.1} s  {name}");
                }
                summary.count += 1;
                summary.times.push(Slow { name, seconds });
            }
            Event::Closed => {}
        }
    }
}

/// Takes note of the end of a program. One that crashes has tests that did not end.
fn close(mut ended: Running, summary: &mut Summary) {
    let status = ended.child.wait();
    let name = &ended.program.name;
    let missing = ended.tests.len() + ended.waiting;
    if missing > 0 || !status.as_ref().is_ok_and(|status| status.success() || status.code() == Some(101)) {
        let tests: Vec<&str> = ended.tests.iter().map(|(test, _)| test.as_str()).collect();
        let status = status.map_or_else(|e| e.to_string(), |status| status.to_string());
        let printed = std::fs::read_to_string(&ended.log).unwrap_or_default();
        let what = format!("{name}: {status} with {missing} tests to go, in {}", tests.join(", "));
        eprintln!("FAILED {what}\n{printed}");
        summary.failures.push(what);
    }
}
