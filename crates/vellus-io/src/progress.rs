//! Progress and cancellation of long work.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// The connection between long work and its caller. The work reports its progress, and checks whether it should stop.
///
/// Renderers, fits, simulations and builders of tables take a `&dyn Progress`. They do not use terminals or signals. An
/// application implements the trait for these. By default, both methods do nothing, so an implementation may leave one
/// out. All threads of the work may call them at the same time.
///
/// There are two implementations: `()` ignores reports and never stops the work, and an [`AtomicBool`] stops it once
/// the flag is true.
///
/// ```
/// use std::sync::atomic::AtomicBool;
/// use vellus_io::{Progress, Steps};
///
/// /// Some long work.
/// fn sum(numbers: &[u64], progress: &dyn Progress) -> Option<u64> {
///     let steps = Steps::new(progress, numbers.len() as u64, "adding");
///     let mut sum = 0;
///     for number in numbers {
///         if progress.is_cancelled() {
///             return None;
///         }
///         sum += number;
///         steps.advance(1);
///     }
///     Some(sum)
/// }
///
/// assert_eq!(sum(&[1, 2, 3], &()), Some(6));
/// assert_eq!(sum(&[1, 2, 3], &AtomicBool::new(true)), None);
/// ```
pub trait Progress: Sync {
    /// Receives a report. `done` is the share of the work that is finished, in [0, 1]. `what` names the current stage
    /// in a word or two, such as "fitting".
    ///
    /// Reports arrive often, at least once per unit of work that takes a second. Each stage starts from 0, so its first
    /// report may have a smaller share than the last report of the previous stage.
    fn report(&self, done: f64, what: &str) {
        let _ = (done, what);
    }

    /// Whether the work should stop. The documentation of each function states what then happens to unfinished results.
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// Ignores reports and never stops the work.
impl Progress for () {}

/// Stops the work once the flag is true.
impl Progress for AtomicBool {
    fn is_cancelled(&self) -> bool {
        self.load(Ordering::Relaxed)
    }
}

/// Counts equal steps of one stage, from any number of threads, and reports their share.
pub struct Steps<'a> {
    progress: &'a dyn Progress,
    done: Mutex<u64>,
    total: u64,
    what: &'a str,
}

impl<'a> Steps<'a> {
    /// A stage of `total` steps. Reports that none of them is done.
    pub fn new(progress: &'a dyn Progress, total: u64, what: &'a str) -> Self {
        progress.report(0.0, what);
        Steps { progress, done: Mutex::new(0), total, what }
    }

    /// Reports that `count` more steps are done. Shares never decrease, and never exceed 1.
    pub fn advance(&self, count: u64) {
        // The lock is held during the report. Otherwise two threads could report in the wrong order.
        let mut done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
        *done = done.saturating_add(count).min(self.total);
        let share = if self.total == 0 { 1.0 } else { *done as f64 / self.total as f64 };
        self.progress.report(share, self.what);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Remembers every report.
    #[derive(Default)]
    struct Log(Mutex<Vec<(f64, String)>>);

    impl Progress for Log {
        fn report(&self, done: f64, what: &str) {
            self.0.lock().unwrap().push((done, what.to_owned()));
        }
    }

    #[test]
    fn steps_of_many_threads_are_reported_in_order() {
        let log = Log::default();
        let steps = Steps::new(&log, 400, "counting");
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| (0..100).for_each(|_| steps.advance(1)));
            }
        });
        steps.advance(1);
        let reports = log.0.into_inner().unwrap();
        assert_eq!(reports.len(), 402);
        assert!(reports.windows(2).all(|w| w[0].0 <= w[1].0), "{reports:?}");
        assert_eq!((reports[0].0, reports[401].0), (0.0, 1.0));
        assert!(reports.iter().all(|(_, what)| what == "counting"));
    }

    #[test]
    fn a_flag_cancels() {
        let flag = AtomicBool::new(false);
        assert!(!flag.is_cancelled() && !().is_cancelled());
        flag.store(true, Ordering::Relaxed);
        assert!(flag.is_cancelled());
    }
}
