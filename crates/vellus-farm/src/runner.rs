//! Runs one task until it is done.

use crate::child::{self, End};
use crate::{Error, Plan, State, Task, receipt};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};
use vellus_io::{Progress, may_pass};
use vellus_render::session::read_film;

/// The exit code of a temporary failure.
const MAY_PASS: i32 = 75;

/// The first and the longest wait after a temporary failure: a full disk is not empty at once.
const WAIT: [Duration; 2] = [Duration::from_secs(1), Duration::from_secs(60)];

/// The last lines of a log are looked for in this many bytes at its end.
const TAIL: usize = 4096;

/// Runs tasks of a plan with the command `vellus`.
pub struct Runner<'a> {
    /// The plan.
    pub plan: &'a Plan,
    /// The command `vellus`.
    pub program: PathBuf,
    /// How often a task is tried again after it was killed, or ended with exit code 75.
    pub retries: u32,
    /// Threads of each task; `None` if the program should choose.
    pub threads: Option<usize>,
    /// Messages of tasks go to `logs/NAME.log` in the folder of the plan, not to the terminal. Attempts that failed are
    /// noted there in any case.
    pub log: bool,
    /// Cancels.
    pub progress: &'a dyn Progress,
}

/// What a runner did for a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ran {
    /// How often its command was started. 0 if it was finished already.
    pub attempts: u32,
}

impl Runner<'_> {
    /// Runs a task, unless it is done. A task is killed only with the program, so `progress` cancels at once.
    ///
    /// # Errors
    /// [`Error::NoTask`] and [`Error::Needs`]. [`Error::Failed`] and [`Error::Unexpected`] if another attempt would
    /// fail too. [`Error::GaveUp`] if no attempt is left. [`Error::Stopped`] if `progress` cancelled.
    pub fn run_one(&self, name: &str) -> Result<Ran, Error> {
        let index = self.plan.find(name)?;
        let task = &self.plan.tasks()[index];
        let is_done = |task: &Task| self.plan.state(task).state == State::Done;
        let mut later = self.plan.tasks()[index..].iter().filter(|other| other.needs.contains(&task.name)).peekable();
        // A film may be deleted once its picture is there.
        if is_done(task) || later.peek().is_some() && later.all(is_done) {
            return Ok(Ran { attempts: 0 });
        }
        for need in self.plan.needs(index) {
            let need = self.plan.state(&self.plan.tasks()[need]);
            if need.state != State::Done {
                let (task, need) = (task.name.clone(), Box::new(need));
                let source = std::io::Error::new(ErrorKind::WouldBlock, "run that task first");
                return Err(Error::Needs { task, need, source });
            }
        }
        self.attempt(task)
    }

    /// Starts the command of a task, again and again.
    pub(crate) fn attempt(&self, task: &Task) -> Result<Ran, Error> {
        let (mut wait, log) = (WAIT[0], self.plan.dir().join("logs").join(format!("{}.log", task.name)));
        for attempts in 1.. {
            if self.progress.is_cancelled() {
                break;
            }
            self.remove_useless(task);
            let pause = match self.start(task, &log) {
                Ok(End::Stopped) => break,
                Ok(End::Code(0)) => return self.finish(task).map(|()| Ran { attempts }),
                Ok(End::Code(MAY_PASS)) => (format!("it ended with exit code {MAY_PASS}"), wait),
                Ok(End::Killed(how)) => (format!("it was stopped: {how}"), Duration::ZERO),
                Ok(End::Code(code)) => {
                    let message = if self.log { last_line(&log) } else { String::new() };
                    return Err(Error::Failed { task: task.name.clone(), code, message });
                }
                Err(error) if may_pass(&error) => (error.to_string(), wait),
                Err(source) => {
                    let folder = self.plan.folder();
                    let path = if folder.is_dir() { &self.program } else { folder };
                    return Err(Error::Read { path: path.to_owned(), source });
                }
            };
            let (how, pause) = pause;
            note(&log, &format!("attempt {attempts}: {how}")).ok();
            if attempts > self.retries {
                let source = std::io::Error::new(ErrorKind::TimedOut, how);
                return Err(Error::GaveUp { task: task.name.clone(), attempts, source });
            }
            self.pause(pause);
            if !pause.is_zero() {
                wait = (2 * wait).min(WAIT[1]);
            }
        }
        Err(Error::Stopped)
    }

    fn pause(&self, time: Duration) {
        let start = Instant::now();
        while start.elapsed() < time && !self.progress.is_cancelled() {
            sleep(Duration::from_millis(20));
        }
    }

    fn start(&self, task: &Task, log: &Path) -> std::io::Result<End> {
        let mut command = Command::new(&self.program);
        command.args(self.plan.arguments(task)).current_dir(self.plan.folder()).stdin(Stdio::null());
        if let Some(threads) = self.threads {
            command.env("RAYON_NUM_THREADS", threads.to_string());
        }
        if self.log {
            let file = vellus_io::append(log)?;
            command.stdout(file.try_clone()?).stderr(file);
        }
        child::run(&mut command, self.plan.dir(), self.progress)
    }

    /// Removes a checkpoint that the command would refuse: a damaged one, or one of another picture.
    fn remove_useless(&self, task: &Task) {
        let (Some(samples), Some(output)) = (&task.samples, task.outputs.first()) else { return };
        let path = self.plan.output(output).with_extension("checkpoint");
        let fits = |film: vellus_render::Checkpoint| {
            film.identity.to_string() == task.identity
                && film.samples.start == samples.start
                && film.samples.end <= samples.end
        };
        if path.exists() && !read_film(&path).is_ok_and(fits) {
            std::fs::remove_file(path).ok();
        }
    }

    /// Checks the result of a command that ended well.
    fn finish(&self, task: &Task) -> Result<(), Error> {
        if task.samples.is_none() {
            receipt::write(self.plan, task)?;
        }
        let status = self.plan.state(task);
        if status.state == State::Done {
            return Ok(());
        }
        Err(Error::Unexpected { task: task.name.clone(), what: status.what() })
    }
}

/// Appends a line to a log.
fn note(log: &Path, line: &str) -> std::io::Result<()> {
    vellus_io::append(log)?.write_all(format!("{line}\n").as_bytes())
}

/// Where a log is, and its last line.
fn last_line(log: &Path) -> String {
    let bytes = vellus_io::read(log).unwrap_or_default();
    let text = String::from_utf8_lossy(&bytes[bytes.len().saturating_sub(TAIL)..]).into_owned();
    let line = text.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or_default();
    format!(" ({}: {})", log.display(), vellus_io::excerpt(line.as_bytes(), 400))
}
