//! Progress of long work on the terminal.

use crate::interrupt::Interrupt;
use crate::output;
use indicatif::ProgressBar;
use vellus_io::Progress;

/// Steps of the bar: thousandths of the work.
const STEPS: u64 = 1000;

/// A progress bar on standard error, if that is a terminal. Long work stops once a signal arrives.
pub struct Terminal {
    bar: ProgressBar,
    interrupt: Option<Interrupt>,
}

impl Terminal {
    /// For work that signals do not stop.
    pub fn new() -> Self {
        Terminal { bar: output::progress(STEPS, ""), interrupt: None }
    }

    /// For work that a signal stops.
    pub fn with_interrupt(interrupt: &Interrupt) -> Self {
        Terminal { bar: output::progress(STEPS, ""), interrupt: Some(interrupt.clone()) }
    }

    /// Removes the bar. The next report shows it again.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        self.clear();
    }
}

impl Progress for Terminal {
    fn report(&self, done: f64, what: &str) {
        if self.bar.message() != what || self.bar.is_finished() || done == 0.0 {
            self.bar.set_message(what.to_owned());
            self.bar.reset();
        }
        self.bar.set_position((done * STEPS as f64) as u64);
    }

    fn is_cancelled(&self) -> bool {
        self.interrupt.as_ref().is_some_and(Interrupt::is_set)
    }
}
