//! What a job reports while it runs.

use super::{Hint, Pass, Session};
use crate::error::Error;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// What [`Job::run`](super::Job::run) reports, in the order in which it can happen. No event ends the job.
///
/// Its text is for users: a line for a log or a terminal. The texts of problems begin with `warning: `.
#[derive(Debug)]
#[non_exhaustive]
pub enum Event<'a> {
    /// A rescued film cannot be read and is left out.
    UnreadableRescue(Error),
    /// The job continues from this rescued film.
    FoundRescue(PathBuf),
    /// The job continues from this many samples a pixel.
    Resumed(u64),
    /// The radiance cache is being filled: the share that is done.
    Filling(f64),
    /// The radiance cache is filled.
    Filled {
        /// Number of cells.
        cells: usize,
        /// Bytes in memory.
        bytes: usize,
        /// How long it took.
        time: Duration,
    },
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
    /// So many samples were not finite. They are left out.
    Rejected(u64),
    /// So many pixels have sums at the end of their range: see [`Film::full_pixels`](crate::Film::full_pixels).
    FullPixels(usize),
    /// [`Settings::max_depth`](crate::Settings::max_depth) cut off paths.
    Cut {
        /// The greatest depth.
        depth: u32,
        /// The throughput that is lost, as a share of that of all paths.
        share: f64,
    },
    /// [`Settings::clamp_indirect`](crate::Settings::clamp_indirect) limited indirect light.
    Clamped {
        /// The limit.
        limit: f32,
        /// The light that was removed, as a share of all light.
        share: f64,
    },
    /// The processor time that rendering took, with that of filling the cache, if the system reports it.
    CpuTime {
        /// Processor time of all threads of this program.
        time: Duration,
        /// Samples of all pixels of this run.
        samples: u64,
    },
    /// The film is written: see [`Job::film`](super::Job::film).
    WroteFilm(&'a Path),
    /// The film has fewer samples than were planned: another goal was reached.
    IncompleteFilm {
        /// The samples of the film.
        samples: Range<u64>,
        /// The samples that were planned.
        planned: Range<u64>,
    },
    /// The denoiser fails: the picture is written without a denoised beauty.
    DenoiserFailed(Error),
    /// A file of the picture is written.
    Wrote(&'a Path),
    /// The picture shows nothing, and why.
    Hint(Hint),
}
