//! Long work: on all cores, without the interpreter's lock, and with Ctrl-C.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use vellus_io::Progress;

/// How often the interpreter handles signals while work is running.
pub const POLL: Duration = Duration::from_millis(50);

/// What work tells its caller, and the other way round. For the crates it is a [`Progress`].
#[derive(Debug, Default)]
pub struct Watch {
    stop: AtomicBool,
    /// The share of the stage that is finished, and its name.
    latest: Mutex<Option<(f64, String)>>,
}

impl Watch {
    /// Whether work should end at its next opportunity. Its result is then dropped.
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Asks the work to end at its next opportunity.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    fn take(&self) -> Option<(f64, String)> {
        self.latest.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

impl Progress for Watch {
    fn report(&self, done: f64, what: &str) {
        *self.latest.lock().unwrap_or_else(PoisonError::into_inner) = Some((done, what.to_owned()));
    }

    fn is_cancelled(&self) -> bool {
        self.is_stopped()
    }
}

/// The threads of this process. `RAYON_NUM_THREADS` sets their number, otherwise there is one for each core.
///
/// A process that was forked has none of its parent's threads, so it makes new ones.
pub fn pool() -> PyResult<Arc<ThreadPool>> {
    static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    if let Some((owner, pool)) = pool.as_ref()
        && *owner == process
    {
        return Ok(pool.clone());
    }
    let build = ThreadPoolBuilder::new().thread_name(|i| format!("vellus-{i}")).build();
    let new = Arc::new(build.map_err(|e| PyRuntimeError::new_err(e.to_string()))?);
    // A drop would wait for locks that the parent's threads may hold.
    std::mem::forget(pool.replace((process, new.clone())));
    Ok(new)
}

/// Runs work on the threads of [`pool`], with the interpreter's lock released. Rayon's functions inside use the same
/// threads.
///
/// # Errors
/// What a signal handler raises, such as `KeyboardInterrupt`. Then `work` is told to stop, and this waits for it.
pub fn run<R: Send>(py: Python<'_>, work: impl FnOnce(&Watch) -> R + Send) -> PyResult<R> {
    run_reporting(py, None, work)
}

/// The same, and calls `callback(done, what)` with the reports of [`Watch`], in the calling thread, at most once for
/// each [`POLL`].
///
/// # Errors
/// Also what the callback raises.
pub fn run_reporting<R: Send>(
    py: Python<'_>,
    callback: Option<Py<PyAny>>,
    work: impl FnOnce(&Watch) -> R + Send,
) -> PyResult<R> {
    let pool = pool()?;
    let watch = Watch::default();
    let callback = callback.as_ref();
    let poll = || {
        Python::attach(|py| {
            py.check_signals()?;
            match (callback, watch.take()) {
                (Some(callback), Some(report)) => callback.call1(py, report).map(drop),
                _ => Ok(()),
            }
        })
    };
    py.detach(|| {
        let (sender, receiver) = sync_channel(1);
        pool.in_place_scope(|scope| {
            let watch = &watch;
            scope.spawn(move |_| {
                // The receiver outlives the scope.
                sender.send(work(watch)).ok();
            });
            loop {
                match receiver.recv_timeout(POLL) {
                    Ok(result) => return poll().map(|()| result),
                    Err(RecvTimeoutError::Timeout) => {
                        if let Err(interrupt) = poll() {
                            watch.stop();
                            return Err(interrupt);
                        }
                    }
                    // The work panicked. The end of the scope passes the panic on.
                    Err(RecvTimeoutError::Disconnected) => {
                        return Err(PyRuntimeError::new_err("the work ended without a result"));
                    }
                }
            }
        })
    })
}
