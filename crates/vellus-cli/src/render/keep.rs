//! What the user reads about checkpoints and rescued films.

use crate::say::note;
use anyhow::{Result, bail};
use std::ops::Range;
use std::path::{Path, PathBuf};
use vellus_render::session::{Rescue, Store};
use vellus_render::{Checkpoint, Error, Session};

/// The checkpoint of one picture.
pub struct Keeper {
    store: Store,
    output: PathBuf,
    resume: bool,
    /// A failed checkpoint was reported.
    warned: bool,
}

impl Keeper {
    /// The checkpoint beside the output.
    pub fn new(output: &Path, resume: bool) -> Self {
        Keeper { store: Store::beside(output), output: output.to_owned(), resume, warned: false }
    }

    /// The checkpoint's file.
    pub fn path(&self) -> &Path {
        self.store.path()
    }

    /// Refuses to begin if the disk has no room for the pictures, the checkpoint and the one that replaces it.
    pub fn check_space(&self, pictures: u64, film: u64) -> Result<()> {
        Ok(self.store.check_space(pictures, film, &self.output)?)
    }

    /// Does what `--resume` says: continues from the checkpoint or a rescued film, whichever has more samples.
    pub fn resume(&mut self, session: &mut Session, samples: Range<u64>) -> Result<()> {
        if !self.resume {
            return Ok(());
        }
        let own = session.checkpoint();
        let samples = own.samples.start..samples.end;
        let found = self.store.find(own.identity, &samples)?;
        for error in found.unreadable {
            note!("warning: a rescued film is left out: {:#}", anyhow::Error::from(error));
        }
        if let Some(path) = found.rescued {
            note!("found {}", path.display());
        }
        let Some(kept) = found.checkpoint else { return Ok(()) };
        match session.resume(kept) {
            Err(Error::OtherCheckpoint(what)) => {
                bail!("{} {what}: delete it, or render without --resume", self.path().display())
            }
            result => result?,
        }
        note!("continuing from {} samples a pixel", session.film().samples());
        Ok(())
    }

    /// Writes a checkpoint; false if that fails. The last checkpoint then stays, and rendering continues. A
    /// warning is printed once.
    pub fn keep(&mut self, checkpoint: &Checkpoint) -> bool {
        let result = self.store.save(checkpoint);
        if let Err(e) = result {
            if !self.warned {
                let last = if self.path().exists() { "the last one stays" } else { "there is none" };
                note!("warning: no checkpoint could be written, {last}: {:#}", anyhow::Error::from(e));
                self.warned = true;
            }
            return false;
        }
        true
    }

    /// Removes the checkpoint: its picture is complete.
    pub fn remove(&mut self) {
        self.store.remove();
    }

    /// Saves samples whose picture could not be written, and reports where they are.
    pub fn rescue(&self, checkpoint: &Checkpoint, why: Error) -> Result<()> {
        let message = match self.store.rescue(checkpoint) {
            Rescue::Saved(path) => {
                let (path, output) = (path.display(), self.output.display());
                let gaps = if checkpoint.samples.end < checkpoint.planned { " --allow-gaps" } else { "" };
                let samples = checkpoint.film.samples();
                format!(
                    "the picture is not written; all {samples} samples a pixel are kept in {path} (continue with \
                     --resume, or: vellus merge{gaps} {path} -o {output})"
                )
            }
            Rescue::LastCheckpoint(path) => format!(
                "the picture is not written; {} has the samples of the last checkpoint (continue with --resume)",
                path.display()
            ),
            Rescue::Lost => "the picture is not written, and the samples could not be saved anywhere".to_owned(),
        };
        Err(anyhow::Error::from(why).context(message))
    }
}
