//! What the user sees of a job: messages, a progress bar and a live view.

use crate::output;
use crate::say::{note, say};
use anyhow::{Error, Result, bail};
use indicatif::ProgressBar;
use std::path::Path;
use std::time::Duration;
use vellus_render::session::{Event, Pass};
use vellus_render::tev::Viewer;
use vellus_render::{Film, Session};

/// The messages and the bar of one job.
pub struct Screen<'a> {
    bar: ProgressBar,
    viewer: Option<&'a mut Live>,
    output: &'a Path,
    max_depth: Option<u32>,
    /// Samples a pixel and processor time when rendering began.
    begin: (u64, Option<Duration>),
}

impl<'a> Screen<'a> {
    /// `output` is the name of the picture in the viewer.
    pub fn new(output: &'a Path, max_depth: Option<u32>, viewer: Option<&'a mut Live>) -> Self {
        Screen { bar: ProgressBar::hidden(), viewer, output, max_depth, begin: (0, None) }
    }

    /// Shows an event.
    pub fn show(&mut self, event: Event) {
        match event {
            Event::Started(session) => self.start(session),
            Event::Pass(pass) => self.pass(pass),
            Event::Rendered { session, time } => {
                self.bar.finish_and_clear();
                self.report(session, time.as_secs_f64());
            }
            other => self.bar.suspend(|| print(other)),
        }
    }

    fn start(&mut self, session: &Session) {
        self.bar = output::bar(1000, "[{wide_bar}] {percent}% {msg}");
        self.bar.enable_steady_tick(Duration::from_secs(1));
        self.begin = (session.film().samples(), output::cpu_time());
    }

    fn pass(&mut self, pass: &Pass) {
        self.bar.set_message(message(pass));
        self.bar.set_position((1000.0 * pass.goals.done(&pass.state)) as u64);
        if let Some(viewer) = &mut self.viewer {
            self.bar.suspend(|| viewer.show(&pass.checkpoint.film, self.output));
        }
    }

    fn report(&self, session: &Session, seconds: f64) {
        let (film, statistics) = (session.film(), session.statistics());
        let (samples, rays) = (film.samples(), statistics.rays as f64 * 1e-6);
        let pixels = (film.width() * film.height()) as f64;
        let noise = film.noise().map_or("unknown".to_owned(), |noise| format!("{noise:.4}"));
        let rate = rays / seconds.max(1e-9);
        note!("{samples} samples a pixel, {rays:.2} Mrays in {seconds:.1} s ({rate:.2} Mrays/s), noise {noise}");
        if statistics.rejected > 0 {
            note!("warning: {} samples were not finite and were left out", statistics.rejected);
        }
        warn_of_full_pixels(film);
        if let Some(max) = self.max_depth {
            let share = 100.0 * statistics.cut() / (samples.max(1) as f64 * pixels);
            note!("paths cut after {max} events had {share:.3} % of a sample's throughput left on average");
        }
        if let ((before, Some(began)), Some(now)) = (self.begin, output::cpu_time()) {
            let cpu = (now - began).as_secs_f64();
            let rate = (samples - before) as f64 * pixels * 1e-3 / cpu.max(1e-9);
            note!("{cpu:.3} s of processor time, {rate:.1} thousand samples a second of it");
        }
    }
}

impl Drop for Screen<'_> {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Prints an event.
pub fn print(event: Event) {
    match event {
        Event::UnreadableRescue(e) => note!("warning: a rescued film is left out: {:#}", Error::from(e)),
        Event::FoundRescue(path) => note!("found {}", path.display()),
        Event::Resumed(samples) => note!("continuing from {samples} samples a pixel"),
        Event::Preview { path, samples } => {
            note!("a first picture is in {} ({samples} sample per pixel)", path.display());
        }
        Event::PreviewFailed(e) => note!("warning: no first picture: {e}"),
        Event::CheckpointFailed { error, last } => {
            let last = if last.is_some() { "the last one stays" } else { "there is none" };
            note!("warning: no checkpoint could be written, {last}: {:#}", Error::from(error));
        }
        Event::WroteFilm { path, film } => {
            say!("wrote {}", path.display());
            if film.samples.end < film.planned {
                let planned = film.samples.start..film.planned;
                note!("warning: it has samples {:?} of {planned:?}", film.samples);
            }
        }
        Event::DenoiserFailed(e) => note!("warning: cannot denoise: {e}"),
        Event::Wrote(path) => say!("wrote {}", path.display()),
        _ => {}
    }
}

/// Warns of pixels whose sums are full: see [`Film::full_pixels`].
pub fn warn_of_full_pixels(film: &Film) {
    let full = film.full_pixels();
    if full > 0 {
        note!(
            "warning: {full} pixels are brighter or further away than a film can sum: they are too dark in the \
             picture (scale the lights or the scene down, or render fewer samples)"
        );
    }
}

/// The text of the bar.
fn message(pass: &Pass) -> String {
    let Pass { state, goals, statistics, .. } = pass;
    let rate = statistics.rays as f64 * 1e-6 / state.spent.as_secs_f64().max(1e-9);
    let left = goals.time_left(state).map_or(String::new(), |left| format!(", {} left", clock(left)));
    let noise = state.noise.map_or(String::new(), |noise| format!("noise {noise:.4}, "));
    format!("{} samples, {noise}{rate:.2} Mrays/s{left}", state.samples)
}

/// 0:07, 12:34, 1:02:03.
fn clock(time: Duration) -> String {
    let s = time.as_secs_f64().round() as u64;
    let (h, m, s) = (s / 3600, s / 60 % 60, s % 60);
    if h > 0 { format!("{h}:{m:02}:{s:02}") } else { format!("{m}:{s:02}") }
}

/// A live view of the pictures.
pub struct Live(Option<Viewer>);

impl Live {
    /// Connects to tev.
    pub fn connect(address: &str) -> Result<Self> {
        match Viewer::connect(address) {
            Ok(viewer) => Ok(Live(Some(viewer))),
            Err(e) => bail!("--tev {address}: no viewer answers there ({e}); start tev first"),
        }
    }

    /// Shows a film under the name of its file. A viewer that is gone is reported once.
    fn show(&mut self, film: &Film, path: &Path) {
        let Some(viewer) = &mut self.0 else { return };
        if let Err(e) = viewer.show(film, &path.display().to_string()) {
            note!("warning: the viewer at {} is gone ({e}): rendering goes on without it", viewer.address());
            self.0 = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_written_as_on_a_clock() {
        assert_eq!(["0:07", "12:34", "1:02:03"], [6.6, 754.0, 3723.0].map(|s| clock(Duration::from_secs_f64(s))));
    }
}
