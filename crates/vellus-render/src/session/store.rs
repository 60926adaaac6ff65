//! The checkpoint file of one picture, and films that were rescued when it could not be written.

use super::text::Chain;
use crate::error::{Error, Rescue};
use crate::film::checkpoint::Checkpoint;
use std::io::ErrorKind;
use std::ops::Range;
use std::path::{Path, PathBuf};
use vellus_io::Digest;

/// Where the samples of a picture are kept between runs.
///
/// The checkpoint has the name of the picture, with the extension `.checkpoint`. Samples that cannot be written there
/// are rescued: see [`Store::rescue`].
#[derive(Debug)]
pub struct Store {
    path: PathBuf,
    /// Rescued films that the next checkpoint or picture makes superfluous.
    rescued: Vec<PathBuf>,
}

/// What [`Store::find`] found.
#[derive(Debug, Default)]
pub struct Found {
    /// The film with the most samples.
    pub checkpoint: Option<Checkpoint>,
    /// The rescued film that it comes from; `None` if it is the checkpoint.
    pub rescued: Option<PathBuf>,
    /// Rescued films that cannot be read, and why.
    pub unreadable: Vec<Error>,
}

impl Store {
    /// The store of a picture.
    pub fn beside(picture: &Path) -> Self {
        Store { path: picture.with_extension("checkpoint"), rescued: Vec::new() }
    }

    /// The checkpoint.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Looks for samples to continue from: the checkpoint, and rescued films of the same picture whose samples begin at
    /// `samples.start` and end within `samples`. The one with the most samples wins. A checkpoint of another picture is
    /// returned too: [`Session::resume`](crate::Session::resume) refuses it.
    ///
    /// # Errors
    /// [`Error::Read`] or [`Error::Film`] if there is a checkpoint that cannot be read.
    pub fn find(&mut self, identity: Digest, samples: &Range<u64>) -> Result<Found, Error> {
        let mut found = Found::default();
        if self.path.exists() {
            found.checkpoint = Some(read_film(&self.path)?);
        }
        let fits = |film: &Checkpoint| {
            film.identity == identity && film.samples.start == samples.start && film.samples.end <= samples.end
        };
        let films = rescued_films(identity, samples.start).unwrap_or_else(|error| {
            found.unreadable.push(error);
            Vec::new()
        });
        for path in films {
            match read_film(&path) {
                Ok(film) if fits(&film) => {
                    let best = found.checkpoint.as_ref();
                    if best.is_none_or(|best| best.samples.end < film.samples.end) {
                        (found.checkpoint, found.rescued) = (Some(film), Some(path.clone()));
                    }
                    self.rescued.push(path);
                }
                Ok(_) => {}
                Err(error) => found.unreadable.push(error),
            }
        }
        Ok(found)
    }

    /// Checks that the disk has room for the pictures, the checkpoint, and the checkpoint that replaces it.
    /// `pictures` and `film` are bytes, at most.
    ///
    /// # Errors
    /// [`Error::Write`] with [`ErrorKind::StorageFull`] if it has not. A system that does not report its free space
    /// passes: writing will fail there.
    pub fn check_space(&self, pictures: u64, film: u64, picture: &Path) -> Result<(), Error> {
        let folder = vellus_io::folder(&self.path);
        let Ok(free) = fs4::available_space(folder) else { return Ok(()) };
        let there = std::fs::metadata(&self.path).map_or(0, |m| m.len());
        let needed = pictures.saturating_add((2 * film).saturating_sub(there));
        if needed <= free {
            return Ok(());
        }
        let what = no_room([needed, pictures, film, free], folder);
        let source = std::io::Error::new(ErrorKind::StorageFull, what);
        Err(Error::Write { path: picture.to_owned(), source })
    }

    /// Replaces the checkpoint, and removes the rescued films that it supersedes.
    ///
    /// # Errors
    /// [`Error::Write`] if it cannot be written. The last checkpoint then stays.
    pub fn save(&mut self, checkpoint: &Checkpoint) -> Result<(), Error> {
        write(&self.path, &checkpoint.to_bytes())?;
        self.remove_rescued();
        Ok(())
    }

    /// Removes the checkpoint and the rescued films: their picture is complete.
    pub fn remove(&mut self) {
        std::fs::remove_file(&self.path).ok();
        self.remove_rescued();
    }

    fn remove_rescued(&mut self) {
        for path in std::mem::take(&mut self.rescued) {
            std::fs::remove_file(path).ok();
        }
    }

    /// Saves samples whose picture cannot be written: as the checkpoint, or else in the user's own folder, where
    /// [`Store::find`] finds them. That is the folder `films` in [`vellus_io::state_folder`].
    pub fn rescue(&self, checkpoint: &Checkpoint) -> Rescue {
        let bytes = checkpoint.to_bytes();
        let Checkpoint { identity, samples, .. } = checkpoint;
        if write(&self.path, &bytes).is_ok() {
            return Rescue::Saved(self.path.clone());
        }
        let name = format!("{}{}.film", rescue_prefix(*identity, samples.start), samples.end);
        let saved = rescue_folder().and_then(|folder| {
            make_private(&folder)?;
            let path = folder.join(name);
            write(&path, &bytes).map(|()| path)
        });
        match saved {
            Ok(path) => Rescue::Saved(path),
            Err(_) if self.path.exists() => Rescue::LastCheckpoint(self.path.clone()),
            Err(error) => Rescue::Lost(Chain(&error).to_string()),
        }
    }
}

/// The folder of rescued films.
fn rescue_folder() -> Result<PathBuf, Error> {
    let state = vellus_io::state_folder();
    state.map(|state| state.join("films")).map_err(|source| Error::Write { path: "films".into(), source })
}

/// Makes the folder of rescued films and the one above it private.
fn make_private(folder: &Path) -> Result<(), Error> {
    let folders = folder.parent().into_iter().chain([folder]);
    folders.into_iter().try_for_each(|folder| {
        vellus_io::make_private(folder).map_err(|source| Error::Write { path: folder.to_owned(), source })
    })
}

/// Rescued films of a picture, sorted by name. Only regular files of this user count: films are trusted.
fn rescued_films(identity: Digest, start: u64) -> Result<Vec<PathBuf>, Error> {
    let Some(folder) = rescue_folder().ok().filter(|folder| folder.symlink_metadata().is_ok()) else {
        return Ok(Vec::new());
    };
    make_private(&folder)?;
    let prefix = rescue_prefix(identity, start);
    let is_one = |path: &PathBuf| {
        let name = path.file_name().map(|name| name.to_string_lossy()).unwrap_or_default();
        let is_own = |file: std::fs::Metadata| file.is_file() && vellus_io::is_own(&file);
        name.starts_with(&prefix) && name.ends_with(".film") && path.symlink_metadata().is_ok_and(is_own)
    };
    let entries = std::fs::read_dir(&folder).map_err(|source| Error::Read { path: folder, source })?;
    let mut films: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).filter(is_one).collect();
    films.sort();
    Ok(films)
}

/// Says that a folder has too little space. Bytes: all that is needed, of it the pictures and one film, and free space.
fn no_room([needed, pictures, film, free]: [u64; 4], folder: &Path) -> String {
    // Whole megabytes would hide why a small picture does not fit.
    let (unit, name) = if needed < 10_000_000 { (1000, "kB") } else { (1_000_000, "MB") };
    format!(
        "up to {} {name} may be needed in {} (pictures {}, a checkpoint and the one that replaces it {} each), and {} \
         {name} are free",
        needed.div_ceil(unit),
        folder.display(),
        pictures.div_ceil(unit),
        film.div_ceil(unit),
        free / unit
    )
}

/// How the names of rescued films of a picture begin.
fn rescue_prefix(identity: Digest, start: u64) -> String {
    format!("vellus-{}-{start}-", identity.short())
}

/// Reads a film or a checkpoint.
///
/// # Errors
/// [`Error::Read`] if the file cannot be read, [`Error::Film`] if it is damaged or no film.
pub fn read_film(path: &Path) -> Result<Checkpoint, Error> {
    let bytes = vellus_io::read(path).map_err(|source| Error::Read { path: path.to_owned(), source })?;
    Checkpoint::from_bytes(&bytes).map_err(|e| Error::Film { path: path.to_owned(), what: e.to_string() })
}

/// Writes a film or a checkpoint. A file is replaced as a whole or not at all: see [`vellus_io::write()`].
///
/// # Errors
/// [`Error::Write`].
pub fn write_film(path: &Path, film: &Checkpoint) -> Result<(), Error> {
    write(path, &film.to_bytes())
}

pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    vellus_io::write(path, bytes).map_err(|source| Error::Write { path: path.to_owned(), source })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_about_space_have_units_of_its_size() {
        let small = no_room([350_208, 55_296, 147_456, 345_999], Path::new("out"));
        assert!(
            small.starts_with("up to 351 kB ")
                && small.ends_with(
                    "(pictures 56, a checkpoint and the one that \
             replaces it 148 each), and 345 kB are free"
                ),
            "{small}"
        );
        let large = no_room([20_000_001, 4_000_000, 8_000_000, 19_999_999], Path::new("out"));
        assert!(large.starts_with("up to 21 MB ") && large.ends_with("and 19 MB are free"), "{large}");
    }
}
