//! Events as text for users.

use super::{Event, Pass};
use std::fmt;
use std::time::Duration;

impl fmt::Display for Event<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Event::UnreadableRescue(error) => write!(f, "warning: a rescued film is left out: {}", Chain(error)),
            Event::FoundRescue(path) => write!(f, "found {}", path.display()),
            Event::Resumed(samples) => write!(f, "continuing from {samples} samples a pixel"),
            Event::Filling(_) => write!(f, "filling the radiance cache"),
            Event::Filled { cells, bytes, time } => {
                let (mb, seconds) = (*bytes as f64 * 1e-6, time.as_secs_f64());
                write!(f, "radiance cache: {cells} cells, {mb:.1} MB, {seconds:.1} s")
            }
            Event::Started(_) => write!(f, "rendering"),
            Event::Pass(pass) => pass.fmt(f),
            Event::Preview { path, samples } => {
                write!(f, "a first picture is in {} ({samples} sample per pixel)", path.display())
            }
            Event::PreviewFailed(error) => write!(f, "warning: no first picture: {error}"),
            Event::CheckpointFailed { error, last } => {
                let last = if last.is_some() { "the last one stays" } else { "there is none" };
                write!(f, "warning: no checkpoint could be written, {last}: {}", Chain(error))
            }
            Event::Rendered { session, time } => {
                let (samples, seconds) = (session.film().samples(), time.as_secs_f64());
                let rays = session.statistics().rays as f64 * 1e-6;
                let rate = rays / seconds.max(1e-9);
                let noise = session.film().noise().map_or("unknown".to_owned(), |noise| format!("{noise:.4}"));
                write!(
                    f,
                    "{samples} samples a pixel, {rays:.2} Mrays in {seconds:.1} s ({rate:.2} Mrays/s), noise {noise}"
                )
            }
            Event::Rejected(samples) => write!(f, "warning: {samples} samples were not finite and were left out"),
            Event::FullPixels(pixels) => write!(
                f,
                "warning: {pixels} pixels are brighter or further away than a film can sum: they are too dark in the \
                 picture (scale the lights or the scene down, or render fewer samples)"
            ),
            Event::Cut { depth, share } => write!(
                f,
                "paths cut after {depth} events had {:.3} % of a sample's throughput left on average",
                100.0 * share
            ),
            Event::Clamped { limit, share } => {
                write!(f, "the limit of {limit} for indirect light removed {:.2} % of the light", 100.0 * share)
            }
            Event::CpuTime { time, samples } => {
                let seconds = time.as_secs_f64();
                let rate = *samples as f64 * 1e-3 / seconds.max(1e-9);
                write!(f, "{seconds:.3} s of processor time, {rate:.1} thousand samples a second of it")
            }
            Event::WroteFilm(path) | Event::Wrote(path) => write!(f, "wrote {}", path.display()),
            Event::IncompleteFilm { samples, planned } => {
                write!(f, "warning: it has samples {samples:?} of {planned:?}")
            }
            Event::Hint(hint) => hint.fmt(f),
            Event::DenoiserFailed(error) => write!(f, "warning: cannot denoise: {error}"),
        }
    }
}

/// One line about the work so far: samples, noise, speed, and the time that is left.
impl fmt::Display for Pass<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Pass { state, goals, statistics, .. } = self;
        let rate = statistics.rays as f64 * 1e-6 / state.spent.as_secs_f64().max(1e-9);
        let left = goals.time_left(state).map_or(String::new(), |left| format!(", {} left", clock(left)));
        let noise = state.noise.map_or(String::new(), |noise| format!("noise {noise:.4}, "));
        write!(f, "{} samples, {noise}{rate:.2} Mrays/s{left}", state.samples)
    }
}

/// An error and its causes in one line.
pub(super) struct Chain<'a>(pub &'a dyn std::error::Error);

impl fmt::Display for Chain<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0)?;
        self.0.source().map_or(Ok(()), |cause| write!(f, ": {}", Chain(cause)))
    }
}

/// 0:07, 12:34, 1:02:03.
fn clock(time: Duration) -> String {
    let s = time.as_secs_f64().round() as u64;
    let (h, m, s) = (s / 3600, s / 60 % 60, s % 60);
    if h > 0 { format!("{h}:{m:02}:{s:02}") } else { format!("{m}:{s:02}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Error;

    #[test]
    fn times_are_written_as_on_a_clock() {
        assert_eq!(["0:07", "12:34", "1:02:03"], [6.6, 754.0, 3723.0].map(|s| clock(Duration::from_secs_f64(s))));
    }

    #[test]
    fn problems_are_warnings_with_their_cause() {
        let error = Error::Write { path: "a.checkpoint".into(), source: std::io::Error::other("the disk is full") };
        let text = Event::CheckpointFailed { error, last: None }.to_string();
        let expected =
            "warning: no checkpoint could be written, there is none: cannot write a.checkpoint: the disk is full";
        assert_eq!(text, expected);
    }
}
