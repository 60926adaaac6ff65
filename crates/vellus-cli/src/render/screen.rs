//! What the user sees of a job: messages, a progress bar and a live view.

use crate::output;
use crate::say::{note, say};
use anyhow::{Result, anyhow};
use indicatif::ProgressBar;
use std::path::Path;
use std::time::Duration;
use vellus_render::session::{Event, Pass};
use vellus_render::tev::Viewer;

/// Connects to tev.
pub fn connect(address: &str) -> Result<Viewer> {
    Viewer::connect(address).map_err(|e| anyhow!("--tev {address}: no viewer answers there ({e}); start tev first"))
}

/// The messages and the bar of one job.
pub struct Screen<'a> {
    bar: ProgressBar,
    viewer: &'a mut Option<Viewer>,
    output: &'a Path,
}

impl<'a> Screen<'a> {
    /// `output` is the name of the picture in the viewer. A viewer that is gone is reported once, and removed.
    pub fn new(output: &'a Path, viewer: &'a mut Option<Viewer>) -> Self {
        let bar = output::bar(1000, "[{wide_bar}] {percent}% {msg}");
        bar.enable_steady_tick(Duration::from_secs(1));
        Screen { bar, viewer, output }
    }

    /// Shows an event.
    pub fn show(&mut self, event: Event) {
        match event {
            Event::Filling(done) => self.step(done, event.to_string()),
            Event::Started(_) => self.step(0.0, String::new()),
            Event::Pass(pass) => self.show_pass(pass),
            Event::Rendered { .. } => {
                self.bar.finish_and_clear();
                print(event);
            }
            event => self.bar.suspend(|| print(event)),
        }
    }

    fn step(&self, done: f64, message: String) {
        self.bar.set_message(message);
        self.bar.set_position((1000.0 * done) as u64);
    }

    fn show_pass(&mut self, pass: &Pass) {
        self.step(pass.goals.done(&pass.state), pass.to_string());
        let Some(viewer) = self.viewer else { return };
        if let Err(e) = viewer.show(&pass.checkpoint.film, &self.output.display().to_string()) {
            let address = viewer.address();
            self.bar.suspend(|| note!("warning: the viewer at {address} is gone ({e}): rendering goes on without it"));
            *self.viewer = None;
        }
    }
}

impl Drop for Screen<'_> {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Prints an event: files that were written to standard output, everything else to standard error.
pub fn print(event: Event) {
    match event {
        Event::WroteFilm(_) | Event::Wrote(_) => say!("{event}"),
        event => note!("{event}"),
    }
}
