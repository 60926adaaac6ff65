//! When rendering ends, and an estimate of how long that takes.

use std::time::Duration;

/// When rendering ends: as soon as one goal is reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goals {
    /// Samples a pixel, those of earlier runs included.
    pub samples: u64,
    /// Noise of the picture, as [`Film::noise`](crate::Film::noise) measures it; above 0. It is tested at 8, 9, …, 16,
    /// 18, …, 32, 36, … samples, so that the end of a picture does not depend on the passes.
    pub noise: Option<f64>,
    /// Time since this run began.
    pub time: Option<Duration>,
}

/// Why rendering ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// All samples are rendered.
    Samples,
    /// The noise is low enough.
    Noise,
    /// The time is over.
    Time,
    /// [`Progress::is_cancelled`](vellus_io::Progress::is_cancelled) returned true.
    Interrupted,
}

impl End {
    /// The word for it in the notes of a picture.
    pub fn name(self) -> &'static str {
        match self {
            End::Samples => "samples",
            End::Noise => "noise",
            End::Time => "time",
            End::Interrupted => "interrupted",
        }
    }
}

/// How far a run is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Samples a pixel, those of earlier runs included.
    pub samples: u64,
    /// Estimated noise of the picture, if it is known.
    pub noise: Option<f64>,
    /// Time since this run began.
    pub spent: Duration,
    /// Seconds that one sample of all pixels took in the last pass; 0 before the first pass.
    pub each: f64,
}

/// With fewer samples the estimate of noise is too uncertain to end a picture.
const TRUSTED: u64 = 8;

/// The noise is tested this often while the number of samples doubles, at most.
const TESTS: u64 = 8;

/// The distance between numbers of samples at which the noise is tested, from this number on.
fn step(samples: u64) -> u64 {
    (samples.checked_ilog2().map_or(1, |log| 1 << log) / TESTS).max(1)
}

impl State {
    fn trusted_noise(&self) -> Option<f64> {
        self.noise.filter(|_| self.samples >= TRUSTED)
    }

    /// The noise, if it is tested at this number of samples.
    fn tested_noise(&self) -> Option<f64> {
        self.trusted_noise().filter(|_| self.samples.is_multiple_of(step(self.samples)))
    }
}

impl Goals {
    /// The goal that is reached now, if any.
    pub fn reached(&self, state: &State) -> Option<End> {
        if state.samples >= self.samples {
            return Some(End::Samples);
        }
        if self.noise.is_some_and(|goal| state.tested_noise().is_some_and(|noise| noise <= goal)) {
            return Some(End::Noise);
        }
        // As close as whole samples allow: one more would end further behind the goal than this is before it.
        let left = self.time?.as_secs_f64() - state.spent.as_secs_f64();
        (state.samples > 0 && left < 0.5 * state.each).then_some(End::Time)
    }

    /// An estimate of the samples a pixel that are left. Noise falls with the square root of their number.
    pub fn samples_left(&self, state: &State) -> u64 {
        let mut left = self.samples.saturating_sub(state.samples);
        if let Some(goal) = self.noise {
            let needed = match state.trusted_noise() {
                Some(noise) => (state.samples as f64 * (noise / goal).powi(2)).ceil() as u64,
                // The noise of a black picture is never known: the number of samples ends it.
                None if state.samples >= TRUSTED => u64::MAX,
                None => TRUSTED,
            };
            left = left.min(needed.saturating_sub(state.samples).max(1));
        }
        if let Some(time) = self.time
            && state.each > 0.0
        {
            let seconds = time.as_secs_f64() - state.spent.as_secs_f64();
            left = left.min((seconds / state.each).round().max(0.0) as u64);
        }
        left
    }

    /// The most samples of the next pass: the noise must be tested after it.
    pub(super) fn next_test(&self, state: &State) -> u64 {
        match self.noise {
            Some(_) => step(state.samples) - state.samples % step(state.samples),
            None => u64::MAX,
        }
    }

    /// An estimate of the time that is left; `None` while there is too little to estimate it from.
    pub fn time_left(&self, state: &State) -> Option<Duration> {
        let trusted = self.noise.is_none() || state.samples >= TRUSTED;
        let seconds = self.samples_left(state) as f64 * state.each;
        (trusted && state.each > 0.0 && seconds < 1e9).then(|| Duration::from_secs_f64(seconds))
    }

    /// An estimate of the share of the work that is done, in [0, 1].
    pub fn done(&self, state: &State) -> f64 {
        let all = state.samples.saturating_add(self.samples_left(state));
        if all == 0 { 1.0 } else { state.samples as f64 / all as f64 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_goal_ends_it_and_gives_the_time() {
        let seconds = Duration::from_secs_f64;
        let state = State { samples: 16, noise: Some(0.04), spent: seconds(8.0), each: 0.5 };
        let goals = Goals { samples: 1000, noise: None, time: None };
        assert_eq!(goals.time_left(&state), Some(seconds(492.0)));
        // A quarter of the noise needs sixteen times the samples.
        let noise = Goals { noise: Some(0.01), ..goals };
        assert_eq!((noise.samples_left(&state), noise.time_left(&state)), (240, Some(seconds(120.0))));
        let time = Goals { time: Some(seconds(20.0)), ..noise };
        assert_eq!((time.samples_left(&state), time.time_left(&state)), (24, Some(seconds(12.0))));
        assert_eq!(time.reached(&state), None);
        assert_eq!(time.reached(&State { samples: 1000, ..state }), Some(End::Samples));
        assert_eq!(time.reached(&State { noise: Some(0.01), ..state }), Some(End::Noise));
        assert_eq!(time.reached(&State { noise: Some(0.01), samples: 4, ..state }), None);
        assert_eq!(time.reached(&State { spent: seconds(19.7), ..state }), None);
        assert_eq!(time.reached(&State { spent: seconds(19.8), ..state }), Some(End::Time));
        // A picture without light has no known noise. Only the number of samples ends it.
        let black = State { samples: 900, noise: None, ..state };
        assert_eq!((noise.reached(&black), noise.samples_left(&black)), (None, 100));
        // There is a picture, however short the time is.
        let first = State { samples: 0, noise: None, spent: seconds(30.0), each: 0.0 };
        assert_eq!((time.reached(&first), time.time_left(&first)), (None, None));
    }
}
