//! Runs tasks with a stand-in for the command, which ends as the test asks.
#![cfg(unix)]

use std::num::NonZero;
use std::path::PathBuf;
use std::process::Command;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};
use tempfile::TempDir;
use vellus_farm::{Error, Experiments, Plan, Ran, Runner, State, Totals, Work};
use vellus_io::{Digest, Progress};
use vellus_testing::program::{LIMIT, Limited, wait_until};

/// A plan of experiments, and a script in place of the command.
struct Bench {
    folder: TempDir,
    plan: Plan,
    limit: Limit,
}

impl Bench {
    fn new(names: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let names = names.iter().map(|&name| name.to_owned()).collect();
        let work = Work::Experiments(Experiments { quality: "smoke".to_owned(), names });
        let plan = Plan::new(folder.path(), work, |_: &[String]| Ok::<_, Error>(Digest::of(b""))).unwrap();
        Bench { folder, plan, limit: Limit(Instant::now()) }
    }

    /// The command: `script` runs first. If it does not end the command, all results are written. `$name` is the
    /// experiment, `$count` the number of times that it was started, and `$dir` the folder of results.
    fn program(&self, script: &str) -> PathBuf {
        let path = self.folder.path().join("vellus");
        let text = format!(
            "#!/bin/sh\nname=$2; dir=${{4#--out=}}; mkdir -p \"$dir/$name\"\n\
             echo x >> \"$dir/$name/starts\"; count=$(wc -l < \"$dir/$name/starts\")\n\
             {script}\n\
             if [ $name = all ]; then cat \"$dir\"/*/result.json > \"$dir/index.html\"\n\
             else echo $name > \"$dir/$name/result.json\"; fi\n"
        );
        // Another process writes it: a child of another test could otherwise inherit the open file, and the system
        // does not start a program that is open for writing.
        let mut write = Command::new("sh");
        write.args(["-c", "printf %s \"$2\" > \"$1\" && chmod 755 \"$1\"", "sh"]);
        assert!(write.arg(&path).arg(text).run().unwrap().status.success());
        path
    }

    fn runner(&self, script: &str, retries: u32) -> Runner<'_> {
        let (plan, program, progress) = (&self.plan, self.program(script), &self.limit);
        Runner { plan, program, retries, threads: None, log: true, progress }
    }

    fn states(&self) -> Vec<State> {
        self.plan.status().tasks.iter().map(|task| task.state).collect()
    }
}

/// Stops work that takes too long: it then ends with an error.
struct Limit(Instant);

impl Progress for Limit {
    fn is_cancelled(&self) -> bool {
        self.0.elapsed() > LIMIT
    }
}

const TWO: NonZero<usize> = NonZero::new(2).unwrap();

#[test]
fn finished_tasks_are_left_out_and_damaged_ones_run_again() {
    let bench = Bench::new(&["a", "b", "c"]);
    let runner = bench.runner("", 0);
    assert_eq!(runner.run_all(TWO).unwrap(), Totals { kept: 0, done: 4, retries: 0 });
    assert_eq!(bench.states(), [State::Done; 4]);
    assert_eq!(runner.run_all(TWO).unwrap(), Totals { kept: 4, done: 0, retries: 0 });
    assert_eq!(runner.run_one("a").unwrap(), Ran { attempts: 0 });

    let result = bench.folder.path().join("experiments/b/result.json");
    std::fs::write(&result, "other").unwrap();
    let page = bench.folder.path().join("experiments/index.html");
    std::fs::remove_file(page).unwrap();
    let receipt = bench.folder.path().join("receipts/c.json");
    std::fs::write(&receipt, std::fs::read(bench.folder.path().join("receipts/a.json")).unwrap()).unwrap();
    assert_eq!(bench.states(), [State::Done, State::Damaged, State::Foreign, State::Missing]);
    // The names are in the table, with the reason.
    let text = bench.plan.status().to_string();
    assert!(text.contains("b: damaged (") && text.contains("c: foreign ("), "{text}");
    assert_eq!(runner.run_all(TWO).unwrap(), Totals { kept: 1, done: 3, retries: 0 });
    assert_eq!(std::fs::read(&result).unwrap(), b"b\n");
}

#[test]
fn kills_and_temporary_failures_are_tried_again() {
    let bench = Bench::new(&["a", "b", "c"]);
    // a is killed twice, b ends with 75 once, c is asked to stop once by somebody else.
    let script = "case $name$count in a1|a2) kill -9 $$;; b1) exit 75;; c1) exit 143;; esac";
    let totals = bench.runner(script, 2).run_all(TWO).unwrap();
    assert_eq!(totals, Totals { kept: 0, done: 4, retries: 4 });
    let log = |name: &str| std::fs::read_to_string(bench.folder.path().join(format!("logs/{name}.log"))).unwrap();
    assert!(log("a").contains("attempt 2: it was stopped: signal: 9") && log("b").contains("exit code 75"));
}

#[test]
fn attempts_have_an_end() {
    let bench = Bench::new(&["a"]);
    let error = bench.runner("kill -9 $$", 2).run_one("a").unwrap_err();
    let Error::GaveUp { attempts: 3, source, .. } = &error else { panic!("{error}") };
    // The command then ends with 75.
    assert!(vellus_io::may_pass(source), "{source}");
}

#[test]
fn bad_input_is_never_tried_again() {
    let bench = Bench::new(&["a", "b"]);
    let runner = bench.runner("if [ $name = a ]; then echo no such colour >&2; exit 2; fi", 5);
    let Error::Several { failed: 1, total: 3, waiting: 1, source } = runner.run_all(TWO).unwrap_err() else { panic!() };
    assert!(source.to_string().contains("exit code 2") && source.to_string().contains("no such colour"), "{source}");
    assert_eq!(std::fs::read_to_string(bench.folder.path().join("experiments/a/starts")).unwrap(), "x\n");
    assert_eq!(bench.states(), [State::Missing, State::Done, State::Missing]);
    let error = runner.run_one("report").unwrap_err();
    assert!(error.to_string().contains("task report needs a, and it is missing"), "{error}");
}

#[test]
fn a_result_that_is_not_there_is_an_error() {
    let bench = Bench::new(&["a"]);
    let error = bench.runner("exit 0", 5).run_one("a").unwrap_err();
    assert!(matches!(error, Error::Read { .. }), "{error}");
}

#[test]
fn a_stop_reaches_the_command() {
    let bench = Bench::new(&["a", "b", "c"]);
    let flag = AtomicBool::new(false);
    let script = "trap 'echo stopped > \"$dir/$name/stopped\"; exit 143' TERM\nsleep 20 & wait";
    let runner = Runner { progress: &flag, ..bench.runner(script, 5) };
    let start = Instant::now();
    std::thread::scope(|scope| {
        let run = scope.spawn(|| runner.run_all(TWO));
        let at = |name: &str, file: &str| bench.folder.path().join("experiments").join(name).join(file);
        wait_until("two tasks", || ["a", "b"].iter().all(|name| at(name, "starts").exists()));
        // The trap is set a moment later.
        std::thread::sleep(Duration::from_millis(200));
        flag.store(true, std::sync::atomic::Ordering::Relaxed);
        assert!(matches!(run.join().unwrap(), Err(Error::Stopped)));
        assert!(at("a", "stopped").exists() && at("b", "stopped").exists() && !at("c", "starts").exists());
    });
    assert!(start.elapsed().as_secs() < 15);
}
