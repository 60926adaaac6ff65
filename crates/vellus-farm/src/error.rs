//! Errors.

use std::path::PathBuf;

/// What can go wrong with a plan.
///
/// An error whose sources include a temporary [`std::io::Error`] (see [`vellus_io::may_pass`]) may not occur again. All
/// others will.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A plan cannot be made from these options.
    #[error("{0}")]
    Options(String),
    /// The file of a plan is not one that this version writes, or was changed.
    #[error("{}: {what}: plan again", path.display())]
    Plan {
        /// The file.
        path: PathBuf,
        /// The problem.
        what: String,
    },
    /// A file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system reports.
        source: std::io::Error,
    },
    /// A file cannot be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the operating system reports.
        source: std::io::Error,
    },
    /// The plan has no such task.
    #[error("the plan has no task '{name}' (its {count} tasks are 1 to {count}, or {example} and so on)")]
    NoTask {
        /// The name or number.
        name: String,
        /// The number of tasks.
        count: usize,
        /// The name of the first one.
        example: String,
    },
    /// A task needs results that are not there. This may pass: another machine may still work on them.
    #[error("task {task} needs {}, and it is {}", need.name, need.what())]
    Needs {
        /// The task.
        task: String,
        /// The first result that is not there.
        need: Box<crate::TaskStatus>,
        /// An error of the kind [`std::io::ErrorKind::WouldBlock`].
        source: std::io::Error,
    },
    /// The command of a task failed, and would fail again.
    #[error("task {task} failed with exit code {code}{message}")]
    Failed {
        /// The task.
        task: String,
        /// The exit code.
        code: i32,
        /// Where its messages are, and the last of them.
        message: String,
    },
    /// A task ended well, but its result is of other inputs, or not there.
    #[error("task {task} ended, but its result is {what}: its inputs may have changed since the plan was made")]
    Unexpected {
        /// The task.
        task: String,
        /// The state of its result.
        what: String,
    },
    /// A task was killed or failed for a while, too often.
    #[error("task {task} was tried {attempts} times")]
    GaveUp {
        /// The task.
        task: String,
        /// How often it was tried.
        attempts: u32,
        /// An error of the kind [`std::io::ErrorKind::TimedOut`]: how the last attempt ended.
        source: std::io::Error,
    },
    /// Several tasks failed. The source is the first error that will occur again, or else the first.
    #[error("{failed} of {total} tasks failed, and {waiting} need their results")]
    Several {
        /// Tasks that failed.
        failed: usize,
        /// Tasks that were to run.
        total: usize,
        /// Tasks that could not begin.
        waiting: usize,
        /// One of the errors.
        source: Box<Error>,
    },
    /// The caller stopped the work. Finished results and checkpoints are kept.
    #[error("stopped")]
    Stopped,
}
