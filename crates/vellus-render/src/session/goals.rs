//! When rendering ends, and how long that will take.

use std::time::Duration;

/// What ends it, whichever comes first.
#[derive(Clone, Copy, Debug)]
pub struct Goals {
    /// Samples a pixel that are rendered in all.
    pub samples: u64,
    /// Noise of the picture.
    pub noise: Option<f64>,
    /// Time rendered in this run.
    pub time: Option<Duration>,
}

/// What ended it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    Samples,
    Noise,
    Time,
    Interrupted,
}

impl End {
    /// In notes.
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
#[derive(Clone, Copy, Debug)]
pub struct State {
    /// Samples a pixel, those of earlier runs too.
    pub samples: u64,
    /// Estimated noise of the picture, if it is known.
    pub noise: Option<f64>,
    /// Time rendered in this run.
    pub spent: Duration,
    /// Seconds that the last samples took, each of all pixels; 0 before the first.
    pub each: f64,
}

/// Samples from which on the estimate of noise is trusted.
const TRUSTED: u64 = 8;

impl State {
    fn trusted_noise(&self) -> Option<f64> {
        self.noise.filter(|_| self.samples >= TRUSTED)
    }
}

impl Goals {
    /// What ends it now, if anything does.
    pub fn reached(&self, state: &State) -> Option<End> {
        if state.samples >= self.samples {
            return Some(End::Samples);
        }
        if self.noise.is_some_and(|goal| state.trusted_noise().is_some_and(|noise| noise <= goal)) {
            return Some(End::Noise);
        }
        // The nearest it can come: the next sample would end further behind than this is before.
        let left = self.time?.as_secs_f64() - state.spent.as_secs_f64();
        (state.samples > 0 && left < 0.5 * state.each).then_some(End::Time)
    }

    /// Samples that are still to come, as far as one can tell: noise falls with the square root of their number.
    pub fn samples_left(&self, state: &State) -> u64 {
        let mut left = self.samples.saturating_sub(state.samples);
        if let Some(goal) = self.noise {
            let needed = match state.trusted_noise() {
                Some(noise) => (state.samples as f64 * (noise / goal).powi(2)).ceil() as u64,
                // A black picture stays unknown: the number of samples ends it.
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

    /// The time that is left, as far as one can tell; `None` before there is anything to tell it by.
    pub fn time_left(&self, state: &State) -> Option<Duration> {
        let trusted = self.noise.is_none() || state.samples >= TRUSTED;
        let seconds = self.samples_left(state) as f64 * state.each;
        (trusted && state.each > 0.0 && seconds < 1e9).then(|| Duration::from_secs_f64(seconds))
    }
}

/// 0:07, 12:34, 1:02:03.
pub fn clock(time: Duration) -> String {
    let s = time.as_secs_f64().round() as u64;
    let (h, m, s) = (s / 3600, s / 60 % 60, s % 60);
    if h > 0 { format!("{h}:{m:02}:{s:02}") } else { format!("{m}:{s:02}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_goal_ends_it_and_tells_the_time() {
        let seconds = Duration::from_secs_f64;
        let state = State { samples: 16, noise: Some(0.04), spent: seconds(8.0), each: 0.5 };
        let goals = Goals { samples: 1000, noise: None, time: None };
        assert_eq!(goals.time_left(&state), Some(seconds(492.0)));
        // A quarter of the noise: sixteen times the samples.
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
        // A picture without light has no known noise: only the number of samples ends it.
        let black = State { samples: 900, noise: None, ..state };
        assert_eq!((noise.reached(&black), noise.samples_left(&black)), (None, 100));
        // However little time there is, there is a picture.
        let first = State { samples: 0, noise: None, spent: seconds(30.0), each: 0.0 };
        assert_eq!((time.reached(&first), time.time_left(&first)), (None, None));
        assert_eq!(["0:07", "12:34", "1:02:03"], [6.6, 754.0, 3723.0].map(|s| clock(seconds(s))));
    }
}
