//! Signals that stop long work. The work then keeps its results.

use crate::exit::Interrupted;
use crate::say::error_line;
use anyhow::{Context, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};

/// Whether a signal has asked the program to stop, and which one.
#[derive(Clone)]
pub struct Interrupt {
    /// True after the first signal.
    pub stop: Arc<AtomicBool>,
    signal: Arc<AtomicI32>,
    /// See [`Interrupt::set_immediate`].
    immediate: Arc<AtomicBool>,
}

impl Interrupt {
    /// From now on, the first SIGINT (Ctrl-C), SIGTERM or SIGHUP sets [`Interrupt::stop`], and the next one ends the
    /// program at once. Signals that were ignored when the program started stay ignored: `nohup` works this way.
    pub fn watch() -> Result<Self> {
        let interrupt = Interrupt { stop: Arc::default(), signal: Arc::default(), immediate: Arc::default() };
        interrupt.register().context("cannot watch for signals")?;
        Ok(interrupt)
    }

    /// If this is true, the first signal ends the program at once. Use it while there are no results to keep.
    pub fn set_immediate(&self, immediate: bool) {
        self.immediate.store(immediate, Ordering::Relaxed);
    }

    /// Whether a signal has arrived.
    pub fn is_set(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// The error of interrupted work. `kept` says which results were kept, where, and how to continue.
    pub fn error(&self, kept: String) -> Interrupted {
        Interrupted { signal: self.signal.load(Ordering::Relaxed), kept }
    }

    #[cfg(unix)]
    fn register(&self) -> std::io::Result<()> {
        use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
        use std::time::{Duration, Instant};
        /// Signals within this time count as one, because `timeout` and a closing terminal send two.
        const REPEATED: Duration = Duration::from_millis(500);

        let watched = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|&signal| !is_ignored(signal));
        let mut signals = signal_hook::iterator::Signals::new(watched)?;
        let Interrupt { stop, signal: first, immediate } = self.clone();
        let watch = move || {
            let mut since = None;
            for signal in signals.forever() {
                if immediate.load(Ordering::Relaxed) {
                    error_line(format_args!("interrupted: the work had not begun, no file was changed"));
                    signal_hook::low_level::exit(128 + signal);
                }
                match since {
                    None => {
                        first.store(signal, Ordering::Relaxed);
                        stop.store(true, Ordering::Relaxed);
                        since = Some(Instant::now());
                    }
                    Some(since) if since.elapsed() < REPEATED => {}
                    Some(_) => signal_hook::low_level::exit(128 + signal),
                }
            }
        };
        std::thread::Builder::new().name("signals".to_owned()).spawn(watch)?;
        Ok(())
    }

    #[cfg(not(unix))]
    fn register(&self) -> std::io::Result<()> {
        use signal_hook::consts::{SIGINT, SIGTERM};
        use signal_hook::flag;
        for signal in [SIGINT, SIGTERM] {
            flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&self.stop))?;
            flag::register(signal, Arc::clone(&self.stop))?;
        }
        self.signal.store(SIGINT, Ordering::Relaxed);
        Ok(())
    }
}

/// Whether a signal was ignored when the program started. Only Linux reports this without unsafe code.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

/// Makes writes beyond the limit of `ulimit -f` fail with an error. By default, the system kills the program.
pub fn survive_file_size_limit() {
    // If this fails, the default behaviour remains.
    #[cfg(unix)]
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default()).ok();
}
