//! Temporary files that a program left behind because it was killed.

use std::ffi::OsStr;
use std::fs::{File, Metadata, OpenOptions};
use std::io::Result;
use std::path::Path;
use std::time::Duration;

/// How the names of temporary files begin. Six letters or digits follow.
pub(crate) const PREFIX: &str = ".vellus-";

/// The most entries of a folder that are looked at: a folder with a hundred thousand files would cost seconds.
const MOST: usize = 4096;

/// How long a leftover must have been unchanged. Its writer holds a lock, but some network file systems do not show the
/// locks of other machines. A writer there changes its file more often than this.
const QUIET: Duration = Duration::from_secs(600);

/// Removes leftovers of the same user from a folder. `own` is a temporary file that this program has made there.
pub(crate) fn remove(folder: &Path, own: &File) {
    let (Ok(own), Ok(entries)) = (own.metadata(), std::fs::read_dir(folder)) else { return };
    for entry in entries.take(MOST).flatten().filter(|entry| is_temporary(&entry.file_name())) {
        if is_left(&entry.path(), &own).unwrap_or(false) {
            std::fs::remove_file(entry.path()).ok();
        }
    }
}

fn is_temporary(name: &OsStr) -> bool {
    let rest = name.to_str().and_then(|name| name.strip_prefix(PREFIX));
    rest.is_some_and(|rest| rest.len() == 6 && rest.bytes().all(|b| b.is_ascii_alphanumeric()))
}

/// Whether it is a regular file of the same user as `own`, has not changed for a while, and nobody holds its lock.
fn is_left(path: &Path, own: &Metadata) -> Result<bool> {
    let is_old = |metadata: &Metadata| {
        let age = metadata.modified().ok().and_then(|time| time.elapsed().ok());
        metadata.is_file() && owner(metadata) == owner(own) && age.is_some_and(|age| age > QUIET)
    };
    // Before it is opened, because opening a pipe would wait.
    if !is_old(&std::fs::symlink_metadata(path)?) {
        return Ok(false);
    }
    // Some network file systems lock only files that are open for writing.
    let file = OpenOptions::new().write(true).open(path)?;
    Ok(is_old(&file.metadata()?) && file.try_lock().is_ok())
}

#[cfg(unix)]
fn owner(metadata: &Metadata) -> u32 {
    std::os::unix::fs::MetadataExt::uid(metadata)
}

#[cfg(not(unix))]
fn owner(_metadata: &Metadata) {}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::SystemTime;

    #[test]
    fn files_of_writers_that_are_gone_are_removed_and_no_others() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let long_ago = SystemTime::now() - 2 * QUIET;
        let make = |name: &str, time: SystemTime| {
            let file = File::create(path(name)).unwrap();
            file.set_modified(time).unwrap();
            file
        };
        let mut kept = vec![".vellus-abcdefg", ".vellus-abc", ".vellus-a.c123", "vellus-abcdef", ".vellus-locked"];
        for name in &kept[..4] {
            make(name, long_ago);
        }
        let writer = make(".vellus-locked", long_ago);
        writer.try_lock().unwrap();
        make(".vellus-recent", SystemTime::now());
        make(".vellus-future", SystemTime::now() + 2 * QUIET);
        std::fs::create_dir(path(".vellus-folder")).unwrap();
        kept.extend([".vellus-recent", ".vellus-future", ".vellus-folder", "a"]);
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(path("vellus-abcdef"), path(".vellus-linked")).unwrap();
            kept.push(".vellus-linked");
        }
        make(".vellus-Left01", long_ago);
        crate::write(&path("a"), b"1").unwrap();
        let names = || {
            let mut names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
            names.sort();
            names
        };
        kept.sort_unstable();
        assert_eq!(names(), kept);
        // Its writer is killed: the system gives the lock back.
        drop(writer);
        crate::writable(&path("a")).unwrap();
        kept.retain(|name| *name != ".vellus-locked");
        assert_eq!(names(), kept);
    }

    #[test]
    fn a_writer_holds_the_lock_of_its_file() {
        let folder = tempfile::tempdir().unwrap();
        crate::write_with(&folder.path().join("a"), |_| {
            let entry = std::fs::read_dir(folder.path()).unwrap().next().unwrap().unwrap();
            assert!(is_temporary(&entry.file_name()));
            assert!(File::options().write(true).open(entry.path()).unwrap().try_lock().is_err());
            Ok(())
        })
        .unwrap();
    }
}
