//! The context of an experiment: its quality, folder and progress.

use crate::{Picture, Quality};
use anyhow::{Context as _, Result};
use std::cell::Cell;
use std::path::{Path, PathBuf};
use vellus_io::Progress;
use vellus_plot::{Draw, save};

/// The context of an experiment.
pub(crate) struct Context<'a> {
    /// The amount of work.
    pub quality: Quality,
    folder: PathBuf,
    again: bool,
    progress: &'a dyn Progress,
}

/// The error of an interrupted experiment.
#[derive(Clone, Copy, Debug)]
pub struct Interrupted;

impl std::fmt::Display for Interrupted {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("interrupted")
    }
}

impl std::error::Error for Interrupted {}

impl<'a> Context<'a> {
    pub fn new(quality: Quality, folder: PathBuf, again: bool, progress: &'a dyn Progress) -> Self {
        Context { quality, folder, again, progress }
    }

    /// The folder of the experiment; it exists.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The path of a file in the folder.
    pub fn path(&self, file: &str) -> PathBuf {
        self.folder.join(file)
    }

    /// Whether to ignore checkpoints of an earlier run.
    pub fn again(&self) -> bool {
        self.again
    }

    /// Returns an error if the experiment should stop. Experiments call it between two steps.
    ///
    /// # Errors
    /// [`Interrupted`].
    pub fn check_interrupted(&self) -> Result<()> {
        if self.progress.is_cancelled() { Err(Interrupted.into()) } else { Ok(()) }
    }

    /// A stage of `len` steps, whose progress is reported.
    pub fn stage(&self, len: u64, what: &'static str) -> Stage<'_> {
        self.progress.report(0.0, what);
        Stage { progress: self.progress, len, what, done: Cell::new(0) }
    }

    /// Receives the progress and can cancel the experiment.
    pub fn progress(&self) -> &dyn Progress {
        self.progress
    }

    /// Writes a file to the folder.
    pub fn write(&self, file: &str, bytes: &[u8]) -> Result<()> {
        write(&self.path(file), bytes)
    }

    /// Draws a picture as NAME.png and NAME.svg.
    pub fn draw(&self, picture: &impl Draw, name: &str, caption: impl Into<String>) -> Result<Picture> {
        let (png, svg) = (format!("{name}.png"), format!("{name}.svg"));
        save(picture, &[self.path(&png), self.path(&svg)])?;
        Ok(Picture::new(png, caption).also(svg))
    }
}

/// Progress of one stage of an experiment.
pub(crate) struct Stage<'a> {
    progress: &'a dyn Progress,
    len: u64,
    what: &'static str,
    done: Cell<u64>,
}

impl Stage<'_> {
    /// Reports `count` more steps.
    pub fn advance(&self, count: u64) {
        self.set(self.done.get() + count);
    }

    /// Reports that `done` steps are done.
    pub fn set(&self, done: u64) {
        self.done.set(done.min(self.len));
        self.progress.report(self.done.get() as f64 / self.len.max(1) as f64, self.what);
    }
}

/// Writes a complete file, or no file if there is an error.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    vellus_io::write(path, bytes).with_context(|| format!("cannot write {}", path.display()))
}
