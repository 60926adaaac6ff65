//! Keeps the samples of one job, and reports what happens to them.

use super::{Event, Rescue, Session, Store};
use crate::error::Error;
use crate::film::checkpoint::Checkpoint;
use std::path::{Path, PathBuf};

/// The store of a job.
pub(super) struct Keeper {
    store: Store,
    /// A failed checkpoint was reported.
    warned: bool,
}

impl Keeper {
    /// Keeps samples beside a picture.
    pub fn new(picture: &Path) -> Self {
        Keeper { store: Store::beside(picture), warned: false }
    }

    /// The store.
    pub fn store(&self) -> &Store {
        &self.store
    }

    /// Continues from the checkpoint or from a rescued film, whichever has more samples.
    pub fn resume(&mut self, session: &mut Session, report: &mut dyn FnMut(Event<'_>)) -> Result<(), Error> {
        let own = session.checkpoint();
        let samples = own.samples.start..if session.exact { own.planned } else { u64::MAX };
        let found = self.store.find(own.identity, &samples)?;
        found.unreadable.into_iter().for_each(|error| report(Event::UnreadableRescue(error)));
        if let Some(path) = found.rescued {
            report(Event::FoundRescue(path));
        }
        if let Some(kept) = found.checkpoint {
            session.resume(kept)?;
            report(Event::Resumed(session.film().samples()));
        }
        Ok(())
    }

    /// Writes a checkpoint, and returns its path. If that fails, the last checkpoint stays, and the first failure is
    /// reported.
    pub fn keep(&mut self, checkpoint: &Checkpoint, report: &mut dyn FnMut(Event<'_>)) -> Option<PathBuf> {
        let result = self.store.save(checkpoint);
        let path = self.store.path();
        match result {
            Ok(()) => return Some(path.to_owned()),
            Err(error) if !self.warned => {
                self.warned = true;
                report(Event::CheckpointFailed { error, last: path.exists().then_some(path) });
            }
            Err(_) => {}
        }
        None
    }

    /// Removes the checkpoint: its picture is complete.
    pub fn remove(&mut self) {
        self.store.remove();
    }

    /// Saves samples that could not be written because of `error`. The returned error says where they are.
    pub fn rescue(&self, checkpoint: &Checkpoint, error: Error) -> Error {
        let rescue: Rescue = self.store.rescue(checkpoint);
        let complete = checkpoint.samples.end >= checkpoint.planned;
        Error::NotWritten { rescue, samples: checkpoint.film.samples(), complete, source: Box::new(error) }
    }
}
