//! The attacks.

mod damage;
mod disk;
mod fibers;
mod files;
mod kill;
mod nonsense;
mod places;
mod ranges;
mod structure;
mod viewer;

use crate::picture::Picture;
use crate::trial::{Stop, Trial};
use std::path::Path;

/// One way to attack.
pub trait Attack {
    /// Its name on the command line.
    fn name(&self) -> &'static str;

    /// Runs one case. All choices come from the trial's dice.
    fn case(&mut self, trial: &mut Trial) -> Result<(), Stop>;

    /// What it could not do on this machine.
    fn left_out(&self) -> Option<&'static str> {
        None
    }
}

/// All attacks.
pub fn all() -> Vec<Box<dyn Attack>> {
    vec![
        Box::new(kill::Kill::default()),
        Box::new(ranges::Ranges::default()),
        Box::new(damage::Damage::default()),
        Box::new(disk::Disk::default()),
        Box::new(files::Files::default()),
        Box::new(nonsense::Nonsense::default()),
        Box::new(fibers::Fibers),
        Box::new(structure::Structure),
        Box::new(viewer::Viewer),
    ]
}

/// Reads a picture that must exist and be complete.
fn picture(trial: &mut Trial, path: &Path, what: &str) -> Option<Picture> {
    match Picture::read(path) {
        Ok(picture) => Some(picture),
        Err(e) => {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let extension = name.rsplit('.').next().unwrap_or("");
            trial.finding(format!("{what}: the .{extension} cannot be read"), format!("{name}: {e}"));
            None
        }
    }
}

/// Compares a picture with that of an undisturbed run.
fn same(trial: &mut Trial, path: &Path, expected: &Picture, what: &str) {
    if let Some(found) = picture(trial, path, what)
        && let Some(difference) = found.difference(expected)
    {
        trial.finding(format!("{what}: other pixels"), format!("{}: {difference}", path.display()));
    }
}

/// Temporary files of the command in a folder.
fn temporary_files(folder: &Path) -> Result<Vec<std::path::PathBuf>, Stop> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_name().to_string_lossy().starts_with(".vellus-") {
            found.push(entry.path());
        }
    }
    Ok(found)
}
