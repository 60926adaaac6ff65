//! Builds of tables that continue after an interruption: finished slabs are kept in a folder.

use crate::simulate::build::{Quality, Slab, SlabKind};
use std::io;
use std::path::{Path, PathBuf};
use vellus::TableData;
use vellus_io::{Progress, Steps};

/// A build that was stopped or that could not write to its folder.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// [`Progress::is_cancelled`] stopped the build. The finished slabs are in the folder.
    #[error("cancelled: finished pieces are in {}", .0.display())]
    Cancelled(PathBuf),
    /// A folder or file that cannot be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// The folder or file.
        path: PathBuf,
        /// What the operating system reports.
        source: io::Error,
    },
}

/// Simulates all slabs of `quality` and compresses them. Each finished slab is written to `folder`, which is created.
/// Slabs that an earlier build of the same quality left there are used, so a build that was stopped continues. The
/// result does not depend on this. [`remove_slabs`] removes the slabs once the table is safe.
///
/// # Errors
/// [`Error::Cancelled`] if `progress` stops the work between two slabs, [`Error::Write`] if the folder cannot be
/// written.
pub fn build(quality: &Quality, folder: &Path, progress: &dyn Progress) -> Result<TableData, Error> {
    let failed = |path: &Path| {
        let path = path.to_owned();
        |source| Error::Write { path, source }
    };
    std::fs::create_dir_all(folder).map_err(failed(folder))?;
    let slabs = quality.slabs();
    let steps = Steps::new(progress, slabs.len() as u64, "simulating");
    let mut results = Vec::new();
    for &slab in &slabs {
        if progress.is_cancelled() {
            return Err(Error::Cancelled(folder.to_owned()));
        }
        let path = folder.join(file_name(quality, slab));
        let result = match read_slab(&path, quality.slab_len(slab)) {
            Some(result) => result,
            None => {
                let result = quality.simulate(slab);
                let bytes: Vec<u8> = result.iter().flat_map(|x| x.to_le_bytes()).collect();
                vellus_io::write(&path, &bytes).map_err(failed(&path))?;
                result
            }
        };
        results.push(result);
        steps.advance(1);
    }
    Ok(quality.assemble(&results, progress))
}

/// The usual folder for the slabs of a table file: its name with `.work` added.
pub fn work_folder(file: &Path) -> PathBuf {
    let mut name = file.as_os_str().to_owned();
    name.push(".work");
    name.into()
}

/// Removes the slabs of `quality` from `folder`, and the folder if it is then empty. Other files stay.
pub fn remove_slabs(quality: &Quality, folder: &Path) {
    for slab in quality.slabs() {
        std::fs::remove_file(folder.join(file_name(quality, slab))).ok();
    }
    std::fs::remove_dir(folder).ok();
}

/// The file of a slab. The name contains everything that the numbers depend on.
fn file_name(quality: &Quality, slab: Slab) -> String {
    let [tau, g, h, theta] = quality.nodes;
    let kind = match slab.kind {
        SlabKind::Azimuthal => "azimuthal",
        SlabKind::Longitudinal => "longitudinal",
    };
    let Quality { directions, photons, seed, .. } = quality;
    format!("{kind}-{:02}-{tau}x{g}x{h}x{theta}x{directions}-{photons}-{seed}.f32", slab.tau)
}

/// A slab of an earlier build, if the file is complete.
fn read_slab(path: &Path, len: usize) -> Option<Vec<f32>> {
    let bytes = vellus_io::read_at_most(path, 4 * len as u64).ok()?;
    (bytes.len() == 4 * len)
        .then(|| bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
}
