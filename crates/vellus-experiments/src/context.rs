//! What an experiment is run with.

use super::{Picture, Quality};
use crate::output;
use crate::plot::canvas::{self, Draw};
use anyhow::Result;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Quality, folder, and whether to stop.
pub struct Context {
    pub quality: Quality,
    folder: PathBuf,
    again: bool,
    stop: Arc<AtomicBool>,
}

/// Ctrl-C: what an experiment returns that was stopped by it.
#[derive(Debug)]
pub struct Interrupted;

impl std::fmt::Display for Interrupted {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("interrupted")
    }
}

impl std::error::Error for Interrupted {}

impl Context {
    pub(super) fn new(quality: Quality, folder: PathBuf, again: bool, stop: Arc<AtomicBool>) -> Self {
        Context { quality, folder, again, stop }
    }

    /// The experiment's own folder, which is there.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// A file in it.
    pub fn path(&self, file: &str) -> PathBuf {
        self.folder.join(file)
    }

    /// Checkpoints of an earlier run are not to be gone on from.
    pub fn again(&self) -> bool {
        self.again
    }

    /// What Ctrl-C sets.
    pub fn stop(&self) -> &AtomicBool {
        &self.stop
    }

    /// Was Ctrl-C pressed?
    pub fn interrupted(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Between two steps.
    ///
    /// # Errors
    /// [`Interrupted`] after Ctrl-C.
    pub fn go_on(&self) -> Result<()> {
        if self.interrupted() { Err(Interrupted.into()) } else { Ok(()) }
    }

    /// A bar on standard error, if that is a terminal.
    pub fn progress(&self, len: u64, what: &'static str) -> indicatif::ProgressBar {
        output::progress(len, what)
    }

    /// Writes a file into the folder.
    pub fn write(&self, file: &str, bytes: &[u8]) -> Result<()> {
        output::write(Some(&self.path(file)), bytes)
    }

    /// Draws a picture as NAME.png and NAME.svg.
    pub fn draw(&self, picture: &impl Draw, name: &str, caption: impl Into<String>) -> Result<Picture> {
        let (png, svg) = (format!("{name}.png"), format!("{name}.svg"));
        canvas::save(picture, &[self.path(&png), self.path(&svg)], name)?;
        Ok(Picture::new(png, caption).also(svg))
    }
}
