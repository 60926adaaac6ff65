//! Runs the command once, under limits.

use crate::trial::Stop;
use rustix::process::{Pid, Signal, kill_process};
use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::Read;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use vellus_testing::program::default_signals;

/// Address space of a child, KiB. The largest valid case needs about 300 MB of it, including thread stacks and
/// arenas.
const MEMORY_KB: u64 = 2 << 20;
/// Processor time of a child in seconds, over all threads. The slowest valid case takes about 3, and twice that if
/// cores are shared.
pub const CPU_SECONDS: u64 = 10;
/// Wall-clock time of a child, for a child that waits forever.
const WALL: Duration = Duration::from_secs(60);
/// Bytes kept of standard output and of standard error.
const KEPT: u64 = 1 << 20;

/// The destination of a standard stream of the child.
#[derive(Clone, PartialEq)]
pub enum Sink {
    /// A pipe to this program, which reads everything.
    Read,
    /// A pipe that nobody reads.
    ClosedPipe,
    /// None: the child starts without the stream.
    Closed,
    /// A file or device.
    File(PathBuf),
}

/// A run of the command.
pub struct Call {
    pub args: Vec<OsString>,
    pub folder: PathBuf,
    pub stdout: Sink,
    pub stderr: Sink,
    /// Largest file that it can write, in blocks of 512 bytes.
    pub file_blocks: Option<u64>,
    pub umask: Option<&'static str>,
    /// Processor time that it can take, seconds.
    pub cpu_seconds: u64,
    /// A signal to send, and when.
    pub signal: Option<(When, Signal)>,
}

/// When a signal is sent.
#[derive(Clone)]
pub enum When {
    /// So long after the start.
    After(Duration),
    /// When another thread says so.
    Told(Arc<AtomicBool>),
}

impl When {
    fn has_come(&self, began: Instant) -> bool {
        match self {
            When::After(time) => began.elapsed() >= *time,
            When::Told(told) => told.load(Ordering::Relaxed),
        }
    }
}

/// The result of a run.
pub struct Outcome {
    pub code: Option<i32>,
    /// The signal that ended the child.
    pub signal: Option<i32>,
    /// Whether the signal of [`Call::signal`] was sent while the child ran.
    pub signalled: bool,
    /// Whether the child was killed because it took longer than the limit.
    pub timed_out: bool,
    /// Processor time at the last measurement, within about 10 ms; 0 if the system does not report it.
    pub cpu: Duration,
    pub peak_kb: u64,
    /// The largest number of threads that the child had.
    pub threads: u64,
    pub stdout: String,
    pub stderr: String,
}

impl Call {
    /// Adds an argument.
    pub fn arg(mut self, arg: impl AsRef<OsStr>) -> Self {
        self.args.push(arg.as_ref().to_owned());
        self
    }

    /// Adds arguments that are separated by blanks.
    pub fn args(mut self, args: &str) -> Self {
        self.args.extend(args.split_whitespace().map(OsString::from));
        self
    }

    /// The shell script that sets the limits and then becomes the command.
    fn script(&self) -> String {
        let mut script = format!("ulimit -c 0; ulimit -v {MEMORY_KB}; ulimit -S -t {}; ", self.cpu_seconds);
        if let Some(blocks) = self.file_blocks {
            script += &format!("ulimit -f {blocks}; ");
        }
        if let Some(umask) = self.umask {
            script += &format!("umask {umask}; ");
        }
        script += "exec \"$0\" \"$@\"";
        for (sink, closing) in [(&self.stdout, " >&-"), (&self.stderr, " 2>&-")] {
            if *sink == Sink::Closed {
                script += closing;
            }
        }
        script
    }

    /// The shell line that does the same.
    pub fn line(&self, vellus: &Path) -> String {
        let quote = |s: &OsStr| match s.to_str() {
            Some(s) if !s.is_empty() && s.bytes().all(|b| b.is_ascii_alphanumeric() || b"-_./=,:%+".contains(&b)) => {
                s.to_owned()
            }
            Some(s) if s.len() > 200 => format!("\"$(printf 'x%.0s' $(seq {}))\"", s.len()),
            Some(s) => format!("'{}'", s.replace('\'', "'\\''")),
            None => {
                let bytes = s.as_encoded_bytes().iter().map(|b| format!("\\x{b:02x}")).collect::<String>();
                format!("$'{bytes}'")
            }
        };
        let words = std::iter::once(vellus.as_os_str()).chain(self.args.iter().map(OsString::as_os_str));
        let mut line = words.map(quote).collect::<Vec<_>>().join(" ");
        for (sink, stream) in [(&self.stdout, "1"), (&self.stderr, "2")] {
            match sink {
                Sink::Read => {}
                Sink::ClosedPipe => line += if stream == "1" { " | true" } else { " 2> >(true)" },
                Sink::Closed => line += &format!(" {stream}>&-"),
                Sink::File(path) => line += &format!(" {stream}>{}", path.display()),
            }
        }
        let blocks = self.file_blocks.map_or(String::new(), |blocks| format!("ulimit -f {blocks}; "));
        let umask = self.umask.map_or(String::new(), |umask| format!("umask {umask}; "));
        if !(blocks.is_empty() && umask.is_empty()) {
            line = format!("sh -c '{umask}{blocks}exec \"$@\"' sh {line}");
        }
        match &self.signal {
            Some((when, signal)) => {
                let after = if let When::After(time) = when { time.as_secs_f64() } else { 3.0 };
                format!("{line} &  sleep {after:.3}; kill -{} $!; wait $!", signal.as_raw())
            }
            None => line,
        }
    }

    /// Runs the command. The run ends when the time of the whole program is over.
    pub fn run(&self, vellus: &Path, deadline: Instant) -> Result<Outcome, Stop> {
        let mut command = Command::new("/bin/sh");
        command.arg("-c").arg(self.script()).arg(vellus).args(&self.args).current_dir(&self.folder);
        // Temporary files stay in the case's folder, and a case may use two threads.
        command.env("TMPDIR", self.folder.join("tmp")).env("XDG_STATE_HOME", self.folder.join("state"));
        command.env("RAYON_NUM_THREADS", "2").env("RUST_BACKTRACE", "0");
        command.stdin(Stdio::null()).stdout(stream(&self.stdout)?).stderr(stream(&self.stderr)?);
        default_signals();
        let mut child = command.spawn()?;
        let (stdout, stderr) = (reader(child.stdout.take()), reader(child.stderr.take()));
        let pid = Pid::from_child(&child);
        let began = Instant::now();
        let (mut signalled, mut timed_out, mut used) = (false, false, Usage::default());
        let status = loop {
            if let Some(status) = child.try_wait()? {
                break status;
            }
            if let Some(now) = usage(pid) {
                used = Usage { threads: used.threads.max(now.threads), ..now };
            }
            if let Some((when, signal)) = &self.signal
                && !signalled
                && when.has_come(began)
            {
                signalled = kill_process(pid, *signal).is_ok();
            }
            if Instant::now() >= deadline {
                end(&mut child)?;
                return Err(Stop::TimeIsOver);
            }
            if began.elapsed() >= WALL && !timed_out {
                timed_out = true;
                end(&mut child)?;
            }
            std::thread::sleep(Duration::from_millis(if began.elapsed().as_millis() < 50 { 1 } else { 5 }));
        };
        Ok(Outcome {
            code: status.code(),
            signal: status.signal(),
            signalled,
            timed_out,
            cpu: used.cpu,
            peak_kb: used.peak_kb,
            threads: used.threads,
            stdout: join(stdout),
            stderr: join(stderr),
        })
    }
}

/// Ends a child that this program started.
fn end(child: &mut Child) -> std::io::Result<()> {
    child.kill()?;
    child.wait().map(drop)
}

fn stream(sink: &Sink) -> std::io::Result<Stdio> {
    Ok(match sink {
        Sink::Read => Stdio::piped(),
        // Drop the reading end at once.
        Sink::ClosedPipe => Stdio::from(std::io::pipe()?.1),
        Sink::Closed => Stdio::null(),
        Sink::File(path) => Stdio::from(File::options().write(true).open(path)?),
    })
}

fn reader(stream: Option<impl Read + Send + 'static>) -> Option<JoinHandle<Vec<u8>>> {
    let mut stream = stream?;
    Some(std::thread::spawn(move || {
        let mut bytes = Vec::new();
        stream.by_ref().take(KEPT).read_to_end(&mut bytes).ok();
        // Read and drop the rest, so that the child does not wait.
        std::io::copy(&mut stream, &mut std::io::sink()).ok();
        bytes
    }))
}

fn join(reader: Option<JoinHandle<Vec<u8>>>) -> String {
    let bytes = reader.and_then(|reader| reader.join().ok()).unwrap_or_default();
    String::from_utf8_lossy(&bytes).into_owned()
}

/// The resources that a child used.
#[derive(Default)]
struct Usage {
    cpu: Duration,
    /// The peak resident memory, KiB.
    peak_kb: u64,
    threads: u64,
}

/// The resources that a child has used so far, as Linux reports them.
fn usage(pid: Pid) -> Option<Usage> {
    let file = |name: &str| std::fs::read_to_string(format!("/proc/{}/{name}", pid.as_raw_nonzero())).ok();
    let stat = file("stat")?;
    // The name, in parentheses, may contain spaces. After it, utime and stime are the words 12 and 13, in 1/100 s.
    let mut words = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
    let mut ticks = || words.next()?.parse::<u64>().ok();
    let cpu = Duration::from_millis(10 * (ticks()? + ticks()?));
    let status = file("status")?;
    let number =
        |name| status.lines().find_map(|line| line.strip_prefix(name)?.split_whitespace().next()?.parse().ok());
    Some(Usage { cpu, peak_kb: number("VmHWM:")?, threads: number("Threads:")? })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn call(args: &str) -> Call {
        let (stdout, stderr) = (Sink::Read, Sink::Read);
        let folder = std::env::temp_dir();
        let call = Call {
            args: Vec::new(),
            folder,
            stdout,
            stderr,
            file_blocks: None,
            umask: None,
            cpu_seconds: 1,
            signal: None,
        };
        call.arg("-c").arg(args)
    }

    fn run(call: &Call) -> Outcome {
        let deadline = Instant::now() + Duration::from_secs(50);
        call.run(Path::new("/bin/sh"), deadline).unwrap_or_else(|_| panic!("no time"))
    }

    #[test]
    fn ways_to_end_are_distinguished() {
        let outcome = run(&call("echo out; echo err >&2; exit 75"));
        assert_eq!((outcome.code, outcome.signal), (Some(75), None));
        assert_eq!((outcome.stdout.as_str(), outcome.stderr.as_str()), ("out\n", "err\n"));
        let mut signalled = call("exec sleep 40");
        signalled.signal = Some((When::After(Duration::from_millis(50)), Signal::TERM));
        let outcome = run(&signalled);
        assert_eq!((outcome.signal, outcome.signalled, outcome.timed_out), (Some(15), true, false));
    }

    #[test]
    fn processor_time_and_files_are_limited() {
        assert_eq!(run(&call("while :; do :; done")).short(), "too much processor time");
        let mut files = call("ulimit -f");
        files.file_blocks = Some(7);
        assert_eq!(run(&files).stdout, "7\n");
    }
}
