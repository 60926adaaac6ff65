//! Checkpoints: what a run goes on from after it was killed, and where a picture is saved that cannot be written.

use super::Args;
use crate::output;
use crate::say::note;
use anyhow::{Context, Result, anyhow, bail};
use std::cell::Cell;
use std::path::{Path, PathBuf};
use vellus_render::Part;

/// Keeps the checkpoint of one picture.
pub struct Keeper<'a> {
    args: &'a Args,
    path: PathBuf,
    /// A failure was told.
    warned: Cell<bool>,
}

impl<'a> Keeper<'a> {
    /// Beside the output.
    pub fn new(args: &'a Args) -> Self {
        Keeper { args, path: args.output.with_extension("checkpoint"), warned: Cell::new(false) }
    }

    /// The checkpoint.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What was kept, where it is asked for and there.
    pub fn load(&self) -> Result<Option<Part>> {
        if !self.args.resume || !self.path.exists() {
            return Ok(None);
        }
        let bytes = std::fs::read(&self.path).with_context(|| format!("cannot read {}", self.path.display()))?;
        Part::from_bytes(&bytes).map(Some).map_err(|e| anyhow!("{}: {e}", self.path.display()))
    }

    /// Refuses to begin where the disk has no room for the pictures, the checkpoint and the one that takes its place.
    pub fn check_space(&self, pictures: u64, film: u64) -> Result<()> {
        let folder = output::folder(&self.path);
        // Where a system does not tell, writing will.
        let Ok(free) = fs4::available_space(folder) else { return Ok(()) };
        let there = std::fs::metadata(&self.path).map_or(0, |m| m.len());
        let needed = pictures + (2 * film).saturating_sub(there);
        if needed > free {
            let mb = |bytes: u64| bytes.div_ceil(1_000_000);
            bail!(
                "cannot write {}: up to {} MB may be needed in {} (pictures {}, a checkpoint and the one that takes its \
                 place {} each), and {} MB are free",
                self.args.output.display(),
                mb(needed),
                folder.display(),
                mb(pictures),
                mb(film),
                free / 1_000_000
            );
        }
        Ok(())
    }

    /// Writes a checkpoint. Where that fails the last one stays, and rendering goes on: a warning says so once.
    pub fn keep(&self, part: &Part) {
        if let Err(e) = output::write(Some(&self.path), &part.to_bytes())
            && !self.warned.replace(true)
        {
            let last = if self.path.exists() { "the last one stays" } else { "there is none" };
            note!("warning: no checkpoint could be written, {last}: {e:#}");
        }
    }

    /// Removes it.
    pub fn remove(&self) {
        std::fs::remove_file(&self.path).ok();
    }

    /// Saves what was rendered and could not be written for the reason given, where that can be done; and says all this.
    pub fn rescue(&self, part: &Part, why: anyhow::Error) -> Result<()> {
        let bytes = part.to_bytes();
        let name = format!("vellus-{:016x}-{}-{}.film", part.fingerprint, part.samples.start, part.samples.end);
        let other = std::env::temp_dir().join(name);
        let saved = [&self.path, &other].into_iter().find(|path| output::write(Some(path), &bytes).is_ok());
        let output = self.args.output.display();
        Err(match saved {
            Some(path) => {
                let path = path.display();
                why.context(format!(
                    "the picture is not written; all samples are kept in {path} (vellus merge {path} -o {output})"
                ))
            }
            None if self.path.exists() => {
                let path = self.path.display();
                why.context(format!(
                    "the picture is not written; {path} has the samples of the last checkpoint (--resume)"
                ))
            }
            None => why.context("the picture is not written, and what was rendered could be kept nowhere"),
        })
    }
}
