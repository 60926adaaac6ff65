//! The thread that renders, and its queue of commands.

use crate::Error;
use crate::files::Files;
use crate::frame::Frame;
use crate::renderer::Renderer;
use crate::request::Command;
use crate::save::Save;
use crate::session::Session;
use serde_json::Value;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;
use tempfile::TempDir;
use tokio::sync::{OwnedSemaphorePermit, oneshot, watch};
use vellus_render::{Curves, Denoised};

/// The most commands that wait. Further ones are refused.
const MAX_QUEUE: usize = 512;

/// The answer to a command.
pub(crate) type Answer<T> = oneshot::Receiver<Result<T, String>>;
pub(crate) type Reply<T> = oneshot::Sender<Result<T, String>>;

/// What the thread has to do.
pub(crate) enum Job {
    Command(Command, Reply<Value>, Instant),
    /// Makes a file. The permit ends with the work, even if nobody waits for the answer.
    Save(Save, Reply<Vec<u8>>, OwnedSemaphorePermit),
    /// The bytes of a dropped file, and its name.
    Load(String, Vec<u8>, Reply<Value>),
    /// Strands that were built in the background, for a session.
    Built(u64, Curves),
    /// The denoised picture, with the number of the picture and its samples.
    Denoised(u64, u64, Result<Denoised, String>),
    /// A scene that was opened in the background.
    Opened(Result<Box<Session>, String>, Option<Reply<Value>>),
}

impl Job {
    /// Whether the step that is rendered is cancelled for this job.
    fn interrupts(&self) -> Interrupts {
        match self {
            Job::Save(..) | Job::Load(..) | Job::Denoised(..) => Interrupts::Never,
            Job::Command(command, ..) if command.is_question() => Interrupts::Once,
            Job::Command(..) | Job::Built(..) | Job::Opened(..) => Interrupts::Always,
        }
    }
}

/// When a job cancels the step that is rendered.
#[derive(PartialEq)]
enum Interrupts {
    /// It changes the picture, so the step would be wasted.
    Always,
    /// It wants a quick answer. The step after it is finished before the next one: many questions do not stop the
    /// picture.
    Once,
    /// It can wait.
    Never,
}

/// What the threads share.
pub(crate) struct Shared {
    /// Waiting jobs, and whether the thread should end.
    jobs: Mutex<(VecDeque<Job>, bool)>,
    wake: Condvar,
    pub(crate) cancel: AtomicBool,
    /// Whether a change cancels the step that is rendered now.
    pub(crate) interruptible: AtomicBool,
    /// Whether a question has cancelled a step, and no step was finished since.
    pub(crate) questioned: AtomicBool,
    pub(crate) frames: watch::Sender<Option<Arc<Frame>>>,
    pub(crate) states: watch::Sender<Arc<str>>,
}

impl Default for Shared {
    fn default() -> Self {
        Shared {
            jobs: Mutex::default(),
            wake: Condvar::new(),
            cancel: AtomicBool::new(false),
            interruptible: AtomicBool::new(true),
            questioned: AtomicBool::new(false),
            frames: watch::Sender::new(None),
            states: watch::Sender::new(Arc::from("")),
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, (VecDeque<Job>, bool)> {
        self.jobs.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a job, and stops the step that is rendered. Gives the job back if too many wait.
    pub(crate) fn push(&self, job: Job) -> bool {
        let mut jobs = self.lock();
        let inner = matches!(job, Job::Built(..) | Job::Opened(..) | Job::Denoised(..));
        if jobs.1 || (!inner && jobs.0.len() >= MAX_QUEUE) {
            return false;
        }
        let cancels = self.interruptible.load(Ordering::Relaxed)
            && match job.interrupts() {
                Interrupts::Always => true,
                Interrupts::Once => !self.questioned.swap(true, Ordering::Relaxed),
                Interrupts::Never => false,
            };
        jobs.0.push_back(job);
        if cancels {
            self.cancel.store(true, Ordering::Relaxed);
        }
        self.wake.notify_one();
        true
    }

    /// All jobs that wait. Waits for one if the thread has nothing else to do. `None` at the end.
    pub(crate) fn take(&self, idle: bool) -> Option<VecDeque<Job>> {
        let mut jobs = self.lock();
        while idle && jobs.0.is_empty() && !jobs.1 {
            jobs = self.wake.wait(jobs).unwrap_or_else(PoisonError::into_inner);
        }
        if jobs.1 {
            return None;
        }
        // A job that arrives from here on cancels the next step.
        self.cancel.store(false, Ordering::Relaxed);
        Some(std::mem::take(&mut jobs.0))
    }
}

/// Renders a scene on a thread of its own. The thread ends when the engine is dropped.
pub struct Engine {
    shared: Arc<Shared>,
    thread: Option<std::thread::JoinHandle<()>>,
    folder: Arc<TempDir>,
}

impl std::fmt::Debug for Engine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Engine").finish_non_exhaustive()
    }
}

impl Engine {
    /// Opens a scene by name or path, and starts to render. `small` selects the small version of a built-in scene.
    /// Pages may open the scenes in `folder`.
    ///
    /// # Errors
    /// [`Error::Open`], [`Error::Scene`], [`Error::Folder`], or [`Error::System`] without a thread.
    pub fn open(scene: impl AsRef<Path>, small: bool, folder: Option<PathBuf>) -> Result<Self, Error> {
        if let Some(folder) = folder.as_ref().filter(|folder| !folder.is_dir()) {
            return Err(Error::Folder(folder.clone()));
        }
        let session = Session::open(scene.as_ref(), small)?;
        let shared = Arc::new(Shared::default());
        let temporary = tempfile::Builder::new().prefix("vellus-live-").tempdir();
        let temporary = temporary.map_err(|source| Error::System { what: "a temporary folder", source })?;
        let files = folder.map(Files::new);
        let mut renderer = Renderer::new(session, Arc::clone(&shared), files, temporary.path().to_owned());
        renderer.publish_state();
        let thread = std::thread::Builder::new().name("vellus-live".to_owned()).spawn(move || renderer.run());
        let thread = thread.map_err(|source| Error::System { what: "a thread", source })?;
        Ok(Engine { shared, thread: Some(thread), folder: Arc::new(temporary) })
    }

    /// The folder of temporary files. It is removed with the engine.
    pub(crate) fn folder(&self) -> Arc<TempDir> {
        Arc::clone(&self.folder)
    }

    /// Sends a command. `None` if too many commands wait.
    pub(crate) fn send(&self, command: Command) -> Option<Answer<Value>> {
        let (reply, answer) = oneshot::channel();
        self.shared.push(Job::Command(command, reply, Instant::now())).then_some(answer)
    }

    /// Asks for the bytes of a file. The work ends early if the answer is dropped.
    pub(crate) fn save(&self, save: Save, place: OwnedSemaphorePermit) -> Option<Answer<Vec<u8>>> {
        let (reply, answer) = oneshot::channel();
        self.shared.push(Job::Save(save, reply, place)).then_some(answer)
    }

    /// Shows the strands of a dropped file.
    pub(crate) fn load(&self, name: String, bytes: Vec<u8>) -> Option<Answer<Value>> {
        let (reply, answer) = oneshot::channel();
        self.shared.push(Job::Load(name, bytes, reply)).then_some(answer)
    }

    /// The newest picture.
    pub(crate) fn frames(&self) -> watch::Receiver<Option<Arc<Frame>>> {
        self.shared.frames.subscribe()
    }

    /// The newest state, as JSON.
    pub(crate) fn states(&self) -> watch::Receiver<Arc<str>> {
        self.shared.states.subscribe()
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        self.shared.lock().1 = true;
        self.shared.cancel.store(true, Ordering::Relaxed);
        self.shared.wake.notify_one();
        if let Some(thread) = self.thread.take() {
            // A panic of the thread was already reported on standard error.
            let _ = thread.join();
        }
    }
}
