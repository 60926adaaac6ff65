//! The process of a task.

use crate::plan::confine;
use std::path::Path;
use std::process::{Child, Command, ExitStatus};
use std::thread::sleep;
use std::time::Duration;
use vellus_io::Progress;

/// The environment variable with the process that waits for a task.
const PARENT: &str = "VELLUS_FARM_PARENT";

/// The environment variable with the folder of the plan, for the process of a task.
const FOLDER: &str = "VELLUS_FARM_FOLDER";

/// How often a process is looked at.
const POLL: Duration = Duration::from_millis(20);

/// How a process ended.
pub enum End {
    /// By itself, with this exit code.
    Code(i32),
    /// A signal of somebody else ended it.
    Killed(String),
    /// It was asked to stop.
    Stopped,
}

/// Runs a command of the plan in the folder `dir`. If `progress` cancels, it is asked to stop: it keeps its checkpoint.
///
/// # Errors
/// Errors of the operating system.
pub fn run(command: &mut Command, dir: &Path, progress: &dyn Progress) -> std::io::Result<End> {
    let mut child = command.env(PARENT, std::process::id().to_string()).env(FOLDER, dir).spawn()?;
    let mut stopped = false;
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(if stopped { End::Stopped } else { end(status) });
        }
        if !stopped && progress.is_cancelled() {
            stopped = true;
            stop(&mut child)?;
        }
        sleep(POLL);
    }
}

/// 128 and the numbers of SIGHUP, SIGINT and SIGTERM: the program was stopped, and kept its results.
const STOPPED: [i32; 3] = [129, 130, 143];

fn end(status: ExitStatus) -> End {
    match status.code() {
        Some(code) if !STOPPED.contains(&code) => End::Code(code),
        _ => End::Killed(status.to_string()),
    }
}

#[cfg(unix)]
fn stop(child: &mut Child) -> std::io::Result<()> {
    use rustix::process::{Pid, Signal, kill_process};
    // It has not been waited for, so its number is not that of another process.
    kill_process(Pid::from_child(child), Signal::TERM).map_err(Into::into)
}

#[cfg(not(unix))]
fn stop(child: &mut Child) -> std::io::Result<()> {
    child.kill()
}

/// Begins a task, if a [`Runner`](crate::Runner) started this process. Links in the folder of the plan are then
/// refused.
///
/// On Linux, the process is asked to stop once the runner is killed. The program calls it first.
pub fn begin() {
    if let Some(dir) = std::env::var_os(FOLDER) {
        // Without a current folder, nothing can be written either.
        confine(Path::new(&dir)).ok();
    }
    #[cfg(target_os = "linux")]
    {
        use rustix::process::{Pid, Signal, getpid, getppid, kill_process, set_parent_process_death_signal};
        let parent = std::env::var(PARENT).ok().and_then(|id| Pid::from_raw(id.parse().ok()?));
        if parent.is_none() {
            return;
        }
        set_parent_process_death_signal(Some(Signal::TERM)).ok();
        // The parent may have ended before.
        if getppid() != parent {
            kill_process(getpid(), Signal::TERM).ok();
        }
    }
}
