//! What a job reports while it runs.

use super::{Pass, Session};
use crate::error::Error;
use crate::film::checkpoint::Checkpoint;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// What [`Job::run`](super::Job::run) reports, in the order in which it can happen. No event ends the job.
#[derive(Debug)]
#[non_exhaustive]
pub enum Event<'a> {
    /// A rescued film cannot be read and is left out.
    UnreadableRescue(Error),
    /// The job continues from this rescued film.
    FoundRescue(PathBuf),
    /// The job continues from so many samples a pixel.
    Resumed(u64),
    /// Rendering begins. The job has written no file so far.
    Started(&'a Session<'a>),
    /// A pass is finished.
    Pass(&'a Pass<'a>),
    /// The first, noisy picture is written: see [`Job::preview`](super::Job::preview).
    Preview {
        /// The PNG.
        path: &'a Path,
        /// Its samples a pixel.
        samples: u64,
    },
    /// The first, noisy picture cannot be written.
    PreviewFailed(Error),
    /// A checkpoint cannot be written. Only the first failure of a job is reported.
    CheckpointFailed {
        /// Why.
        error: Error,
        /// The last checkpoint, which stays; `None` if there is none.
        last: Option<&'a Path>,
    },
    /// Rendering has ended.
    Rendered {
        /// The session with its film and statistics. It can have no samples if it was interrupted.
        session: &'a Session<'a>,
        /// How long this run rendered.
        time: Duration,
    },
    /// The film is written: see [`Job::film`](super::Job::film).
    WroteFilm {
        /// The file.
        path: &'a Path,
        /// Its content. It ends before [`Checkpoint::planned`] if another goal than the samples was reached.
        film: &'a Checkpoint,
    },
    /// The denoiser fails: the picture is written without a denoised beauty.
    DenoiserFailed(Error),
    /// A file of the picture is written.
    Wrote(&'a Path),
}
