//! Checkpoints: a run that was stopped continues from them. Also where samples are saved whose picture cannot be
//! written.

use super::Args;
use crate::output;
use crate::say::note;
use anyhow::{Context, Result, anyhow, bail};
use std::cell::{Cell, RefCell};
use std::io::{Error, ErrorKind};
use std::path::{Path, PathBuf};
use vellus_io::Digest;
use vellus_render::Checkpoint;

/// Keeps the checkpoint of one picture.
pub struct Keeper<'a> {
    args: &'a Args,
    path: PathBuf,
    /// A failed checkpoint was reported.
    warned: Cell<bool>,
    /// Rescued films that the checkpoint or the picture makes superfluous.
    rescued: RefCell<Vec<PathBuf>>,
}

impl<'a> Keeper<'a> {
    /// Beside the output.
    pub fn new(args: &'a Args) -> Self {
        let path = args.output.with_extension("checkpoint");
        Keeper { args, path, warned: Cell::new(false), rescued: RefCell::default() }
    }

    /// The checkpoint.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What `--resume` continues from: of the checkpoint, and of the films of the same picture that [`Keeper::rescue`]
    /// saved, the one with the most samples.
    pub fn load(&self, identity: Digest) -> Result<Option<Checkpoint>> {
        if !self.args.resume {
            return Ok(None);
        }
        let read = |path: &Path| -> Result<Checkpoint> {
            let bytes = vellus_io::read(path).with_context(|| format!("cannot read {}", path.display()))?;
            Checkpoint::from_bytes(&bytes).map_err(|e| anyhow!("{}: {e}", path.display()))
        };
        let mut found = if self.path.exists() { Some(read(&self.path)?) } else { None };
        let range = self.args.samples.as_ref();
        let start = range.map_or(0, |samples| samples.start);
        let fits = |part: &Checkpoint| {
            let samples = &part.samples;
            part.identity == identity && samples.start == start && range.is_none_or(|range| samples.end <= range.end)
        };
        for path in rescued_films(identity, start) {
            match read(&path) {
                Ok(part) if fits(&part) => {
                    if found.as_ref().is_none_or(|found| found.samples.end < part.samples.end) {
                        note!("found {}", path.display());
                        found = Some(part);
                    }
                    self.rescued.borrow_mut().push(path);
                }
                Ok(_) => {}
                Err(error) => note!("warning: a rescued film is left out: {error:#}"),
            }
        }
        Ok(found)
    }

    /// Refuses to begin where the disk has no room for the pictures, the checkpoint and the one that replaces it.
    pub fn check_space(&self, pictures: u64, film: u64) -> Result<()> {
        let folder = output::folder(&self.path);
        // Where a system does not tell, writing will.
        let Ok(free) = fs4::available_space(folder) else { return Ok(()) };
        let there = std::fs::metadata(&self.path).map_or(0, |m| m.len());
        let needed = pictures.saturating_add((2 * film).saturating_sub(there));
        if needed > free {
            let mb = |bytes: u64| bytes.div_ceil(1_000_000);
            let what = format!(
                "up to {} MB may be needed in {} (pictures {}, a checkpoint and the one that replaces it {} each), \
                 and {} MB \
                 are free",
                mb(needed),
                folder.display(),
                mb(pictures),
                mb(film),
                free / 1_000_000
            );
            let full = Error::new(ErrorKind::StorageFull, what);
            return Err(full).with_context(|| format!("cannot write {}", self.args.output.display()));
        }
        Ok(())
    }

    /// Writes a checkpoint; false where that fails. The last checkpoint then stays, and rendering continues: a warning
    /// says so once.
    pub fn keep(&self, part: &Checkpoint) -> bool {
        match output::write(Some(&self.path), &part.to_bytes()) {
            Ok(()) => {
                self.remove_rescued();
                true
            }
            Err(e) => {
                if !self.warned.replace(true) {
                    let last = if self.path.exists() { "the last one stays" } else { "there is none" };
                    note!("warning: no checkpoint could be written, {last}: {e:#}");
                }
                false
            }
        }
    }

    /// Removes it, and what it was continued from.
    pub fn remove(&self) {
        std::fs::remove_file(&self.path).ok();
        self.remove_rescued();
    }

    fn remove_rescued(&self) {
        for path in self.rescued.take() {
            std::fs::remove_file(path).ok();
        }
    }

    /// Saves samples that could not be written for the reason given, where that is possible, and reports all this.
    pub fn rescue(&self, part: &Checkpoint, why: anyhow::Error) -> Result<()> {
        let bytes = part.to_bytes();
        let other = rescue_path(part);
        let saved = [&self.path, &other].into_iter().find(|path| output::write(Some(path), &bytes).is_ok());
        let output = self.args.output.display();
        Err(match saved {
            Some(path) => {
                let path = path.display();
                let gaps = if part.samples.end < part.planned { " --allow-gaps" } else { "" };
                why.context(format!(
                    "the picture is not written; all {} samples a pixel are kept in {path} (continue with --resume, \
                     or: vellus \
                     merge{gaps} {path} -o {output})",
                    part.film.samples()
                ))
            }
            None if self.path.exists() => {
                let path = self.path.display();
                why.context(format!(
                    "the picture is not written; {path} has the samples of the last checkpoint (continue with --resume)"
                ))
            }
            None => why.context("the picture is not written, and the samples could not be saved anywhere"),
        })
    }
}

/// The beginning of the names of rescued films of a picture.
fn rescue_prefix(identity: Digest, start: u64) -> String {
    format!("vellus-{}-{start}-", identity.short())
}

fn rescue_path(part: &Checkpoint) -> PathBuf {
    let prefix = rescue_prefix(part.identity, part.samples.start);
    std::env::temp_dir().join(format!("{prefix}{}.film", part.samples.end))
}

/// Films of a picture that were saved where the system keeps temporary files.
fn rescued_films(identity: Digest, start: u64) -> Vec<PathBuf> {
    let prefix = rescue_prefix(identity, start);
    let is_one = |path: &PathBuf| {
        let name = path.file_name().map(|name| name.to_string_lossy()).unwrap_or_default();
        name.starts_with(&prefix) && name.ends_with(".film")
    };
    let Ok(entries) = std::fs::read_dir(std::env::temp_dir()) else { return Vec::new() };
    let mut films: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).filter(is_one).collect();
    films.sort();
    films
}

/// Refuses a checkpoint of another picture, or of other samples than those that are asked for.
pub fn check_same(kept: &Checkpoint, expected: &Checkpoint, args: &Args, path: &Path) -> Result<()> {
    let same = kept.identity == expected.identity && kept.film.fits(&expected.film);
    let fits = kept.samples.start == expected.samples.start
        && (args.samples.is_none() || kept.samples.end <= expected.planned);
    if !same {
        bail!(
            "{} is of another picture: the scene, a file that it reads, or an option has changed. Delete it, or \
             render without \
             --resume",
            path.display()
        );
    }
    if !fits {
        bail!(
            "{} has the samples {:?}, which are not in {}..{}: delete it, or render without --resume",
            path.display(),
            kept.samples,
            expected.samples.start,
            expected.planned
        );
    }
    Ok(())
}
