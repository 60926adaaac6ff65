//! Long work: on all cores, without the interpreter's lock, and with Ctrl-C.

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// How often the interpreter handles signals while work is running.
const POLL: Duration = Duration::from_millis(50);

/// Whether the caller no longer wants the result.
#[derive(Debug, Default)]
pub struct Stop(AtomicBool);

impl Stop {
    /// Whether work should end at its next opportunity. Its result is then dropped.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    fn set(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// The threads of this process. `RAYON_NUM_THREADS` sets their number, otherwise there is one for each core.
///
/// A process that was forked has none of its parent's threads, so it makes new ones.
fn pool() -> PyResult<Arc<ThreadPool>> {
    static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    if let Some((owner, pool)) = pool.as_ref()
        && *owner == process
    {
        return Ok(pool.clone());
    }
    let build = ThreadPoolBuilder::new().thread_name(|i| format!("vellus-{i}")).build();
    let new = Arc::new(build.map_err(|e| pyo3::exceptions::PyRuntimeError::new_err(e.to_string()))?);
    // A drop would wait for locks that the parent's threads may hold.
    std::mem::forget(pool.replace((process, new.clone())));
    Ok(new)
}

/// Runs work on the threads of [`pool`], with the interpreter's lock released. Rayon's functions inside use the same
/// threads.
///
/// # Errors
/// What a signal handler raises, such as `KeyboardInterrupt`. Then `work` is told to stop, and this waits for it.
pub fn run<R: Send>(py: Python<'_>, work: impl FnOnce(&Stop) -> R + Send) -> PyResult<R> {
    let pool = pool()?;
    let stop = Stop::default();
    py.detach(|| {
        let (sender, receiver) = sync_channel(1);
        pool.in_place_scope(|scope| {
            let stop = &stop;
            scope.spawn(move |_| {
                // The receiver outlives the scope.
                sender.send(work(stop)).ok();
            });
            loop {
                match receiver.recv_timeout(POLL) {
                    Ok(result) => return Ok(result),
                    Err(RecvTimeoutError::Timeout) => {
                        if let Err(interrupt) = Python::attach(|py| py.check_signals()) {
                            stop.set();
                            return Err(interrupt);
                        }
                    }
                    // The work panicked. The end of the scope passes the panic on.
                    Err(RecvTimeoutError::Disconnected) => {
                        return Err(pyo3::exceptions::PyRuntimeError::new_err("the work ended without a result"));
                    }
                }
            }
        })
    })
}
