//! Programs that a test starts. Their signals have the default actions, every wait has a limit, and none outlives its
//! test.

use std::io::Read;
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How long a test waits. What a test waits for takes seconds, and up to a minute on a busy machine.
pub const LIMIT: Duration = Duration::from_secs(300);

const POLL: Duration = Duration::from_millis(2);

/// A program that a test started. It is killed when this is dropped.
pub struct Running {
    child: Child,
    /// The command, for messages.
    name: String,
    stdout: Option<Stream>,
    stderr: Option<Stream>,
}

/// How tests run commands.
pub trait Limited {
    /// As [`Command::spawn`]. What it prints to pipes is read.
    ///
    /// # Errors
    /// Those of the operating system.
    fn start(&mut self) -> std::io::Result<Running>;

    /// As [`Command::output`]. It has no input.
    ///
    /// # Errors
    /// Those of the operating system.
    ///
    /// # Panics
    /// As [`Running::end`].
    fn run(&mut self) -> std::io::Result<Output>;
}

impl Limited for Command {
    fn start(&mut self) -> std::io::Result<Running> {
        #[cfg(unix)]
        default_signals();
        let mut child = self.spawn()?;
        let (stdout, stderr) = (child.stdout.take().map(Stream::new), child.stderr.take().map(Stream::new));
        Ok(Running { child, name: format!("{self:?}"), stdout, stderr })
    }

    fn run(&mut self) -> std::io::Result<Output> {
        self.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).start().map(Running::end)
    }
}

/// Runs a test of this program again, in a process of its own with this environment variable. `name` is that of the
/// test with its modules. Returns true in that process, which does the test.
///
/// # Panics
/// If the test fails there.
pub fn is_alone_with(name: &str, variable: &str, value: &std::path::Path) -> bool {
    const ALONE: &str = "VELLUS_TEST_ALONE";
    if std::env::var_os(ALONE).is_some() {
        return true;
    }
    let mut again = Command::new(std::env::current_exe().expect("this program has a file"));
    again.args(["--exact", "--include-ignored", name]).env(ALONE, "1").env(variable, value);
    let ended = again.run().expect("this program can be started again");
    let [text, errors] = [&ended.stdout, &ended.stderr].map(|bytes| String::from_utf8_lossy(bytes));
    assert!(ended.status.success() && text.contains("1 passed"), "{text}{errors}");
    false
}

/// Waits until something is true.
///
/// # Panics
/// If it is not true after [`LIMIT`]. The message says what was waited for.
pub fn wait_until(what: &str, mut done: impl FnMut() -> bool) {
    assert!(within(LIMIT, || done().then_some(())).is_some(), "waited {LIMIT:?} in vain: {what}");
}

/// The first value that `get` finds within a time.
fn within<T>(limit: Duration, mut get: impl FnMut() -> Option<T>) -> Option<T> {
    let start = Instant::now();
    loop {
        let found = get();
        if found.is_some() || start.elapsed() > limit {
            return found;
        }
        std::thread::sleep(POLL);
    }
}

impl Running {
    /// The number of its process.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// How it ended, or `None` if it still runs after this time.
    pub fn ended_within(&mut self, limit: Duration) -> Option<ExitStatus> {
        within(limit, || self.child.try_wait().expect("the child can be waited for"))
    }

    /// Waits for its end.
    ///
    /// # Panics
    /// If it takes longer than [`LIMIT`].
    pub fn end(self) -> Output {
        self.end_within(LIMIT)
    }

    /// Waits for its end, for a command that may take long.
    ///
    /// # Panics
    /// If it takes longer than the limit.
    pub fn end_within(mut self, limit: Duration) -> Output {
        let status = self.ended_within(limit).unwrap_or_else(|| {
            let errors = self.stderr.take().map_or(Vec::new(), |stream| stream.so_far());
            panic!("{} did not end in {limit:?}: {}", self.name, String::from_utf8_lossy(&errors));
        });
        let all = |stream: Option<Stream>| {
            let Some(stream) = stream else { return Vec::new() };
            let closed = within(limit, || stream.reader.is_finished().then_some(()));
            assert!(closed.is_some(), "{} ended, but another process holds its output after {limit:?}", self.name);
            stream.so_far()
        };
        Output { status, stdout: all(self.stdout.take()), stderr: all(self.stderr.take()) }
    }

    /// Kills it, and waits for its end.
    pub fn kill(mut self) {
        self.child.kill().ok();
        self.child.wait().ok();
    }

    /// Sends a signal.
    #[cfg(unix)]
    pub fn send(&self, signal: Signal) {
        rustix::process::kill_process(rustix::process::Pid::from_child(&self.child), signal).expect("it is our child");
    }

    /// Waits until it has its own action for a signal. Only Linux tells when: elsewhere this waits for two seconds.
    ///
    /// # Panics
    /// If it has none after [`LIMIT`].
    #[cfg(unix)]
    pub fn wait_until_it_catches(&self, signal: Signal) {
        if cfg!(target_os = "linux") {
            let caught = || is_in(&format!("/proc/{}/status", self.id()), "SigCgt:", signal);
            wait_until(&format!("{} catches {signal:?}", self.name), caught);
        } else {
            std::thread::sleep(Duration::from_secs(2));
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended: then nothing happens.
        self.child.kill().ok();
        self.child.wait().ok();
    }
}

/// What a program prints, read by a thread, so that the program never waits for this one.
struct Stream {
    bytes: Arc<Mutex<Vec<u8>>>,
    reader: JoinHandle<()>,
}

impl Stream {
    fn new(mut source: impl Read + Send + 'static) -> Self {
        let bytes = Arc::new(Mutex::new(Vec::new()));
        let shared = Arc::clone(&bytes);
        let reader = std::thread::spawn(move || {
            let mut part = [0; 1 << 14];
            while let Ok(count @ 1..) = source.read(&mut part) {
                shared.lock().expect("no reader panics").extend(&part[..count]);
            }
        });
        Stream { bytes, reader }
    }

    fn so_far(&self) -> Vec<u8> {
        self.bytes.lock().expect("no reader panics").clone()
    }
}

#[cfg(unix)]
pub use rustix::process::Signal;

/// Sends a signal to any process. False if there is none.
#[cfg(unix)]
pub fn kill(process: u32, signal: Signal) -> bool {
    let process = i32::try_from(process).ok().and_then(rustix::process::Pid::from_raw);
    process.is_some_and(|process| rustix::process::kill_process(process, signal).is_ok())
}

/// From now on, children of this process start with default actions for the signals that end a program. `nohup` and
/// scripts that start a program in the background make it ignore some of them, and a child inherits that.
#[cfg(unix)]
pub fn default_signals() {
    static ONCE: std::sync::Once = std::sync::Once::new();
    ONCE.call_once(|| {
        for signal in [Signal::HUP, Signal::INT, Signal::QUIT, Signal::TERM] {
            // A child does not inherit a handler, it gets the default action. This one does what happened before in
            // this process: nothing, or the default action.
            let default = Arc::new(std::sync::atomic::AtomicBool::new(!is_ignored(signal)));
            let registered = signal_hook::flag::register_conditional_default(signal.as_raw(), default);
            registered.expect("a program may handle these signals");
        }
    });
}

/// Only Linux tells. Elsewhere, a signal that was ignored ends the tests.
#[cfg(unix)]
fn is_ignored(signal: Signal) -> bool {
    is_in("/proc/self/status", "SigIgn:", signal)
}

/// Whether a signal is in a mask of Linux.
#[cfg(unix)]
fn is_in(file: &str, mask: &str, signal: Signal) -> bool {
    let status = std::fs::read_to_string(file).unwrap_or_default();
    let bits = status.lines().find_map(|line| line.strip_prefix(mask)).map_or("0", str::trim);
    // The lowest bit is signal 1.
    u64::from_str_radix(bits, 16).is_ok_and(|bits| bits >> (signal.as_raw() - 1) & 1 == 1)
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    const SIGNALS: [Signal; 5] = [Signal::HUP, Signal::INT, Signal::QUIT, Signal::PIPE, Signal::TERM];

    /// The test below, in a process that ignores signals.
    #[test]
    fn ignored_signals_are_not_inherited() {
        let mut shell = Command::new("sh");
        shell.args(["-c", "trap '' HUP INT QUIT PIPE TERM; exec \"$@\"", "sh"]).arg(std::env::current_exe().unwrap());
        shell.args(["--exact", "--include-ignored", "program::tests::children_have_default_signals"]);
        let ended = shell.env("VELLUS_TEST_IGNORES", "1").run().unwrap();
        let text = String::from_utf8_lossy(&ended.stdout);
        assert!(ended.status.success() && text.contains("1 passed"), "{text}");
    }

    #[test]
    fn children_have_default_signals() {
        let before = SIGNALS.map(is_ignored);
        let child = Command::new("sleep").arg("60").start().unwrap();
        for signal in SIGNALS {
            assert!(!is_in(&format!("/proc/{}/status", child.id()), "SigIgn:", signal), "{signal:?}");
        }
        if std::env::var_os("VELLUS_TEST_IGNORES").is_some() {
            assert_eq!(before, [true; 5]);
            // This process still ignores it.
            rustix::process::kill_process(rustix::process::getpid(), Signal::HUP).unwrap();
        }
        child.send(Signal::HUP);
        assert_eq!(std::os::unix::process::ExitStatusExt::signal(&child.end().status), Some(1));
    }

    #[test]
    fn waits_have_a_limit_and_name_the_command() {
        let mut shell = Command::new("sh");
        shell.args(["-c", "echo busy >&2; exec sleep 60"]).stderr(Stdio::piped());
        let child = shell.start().unwrap();
        let id = child.id();
        let end = std::panic::AssertUnwindSafe(|| child.end_within(Duration::from_millis(300)));
        let panic = std::panic::catch_unwind(end).unwrap_err();
        let message = panic.downcast_ref::<String>().unwrap();
        assert!(message.contains("sleep 60") && message.ends_with("did not end in 300ms: busy\n"), "{message}");
        assert!(!std::path::Path::new(&format!("/proc/{id}")).exists(), "it is killed");
    }

    #[test]
    fn more_than_a_pipe_holds_is_read() {
        let ended = Command::new("sh").args(["-c", "head -c 300000 /dev/zero; exit 7"]).run().unwrap();
        assert_eq!((ended.stdout.len(), ended.status.code()), (300_000, Some(7)));
    }
}
