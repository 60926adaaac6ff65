//! Folders that somebody else may have filled, such as the folder of a plan in an archive. A link in such a folder
//! could lead a result to any file of the user, and a pipe could block for ever.

use std::io::{Error, ErrorKind, Result};
use std::path::{Path, PathBuf};
use std::sync::{PoisonError, RwLock};

static CONFINED: RwLock<Vec<PathBuf>> = RwLock::new(Vec::new());

/// From now on, this crate refuses to read or write what is a symbolic link or no regular file, at `path` and below it.
/// This holds for all functions with a path, and for all threads. The path itself need not exist.
///
/// It protects from what lies in a folder, not from somebody who changes the folder at the same time.
///
/// # Errors
/// An error of the operating system, if there is no current folder.
pub fn confine(path: &Path) -> Result<()> {
    let path = std::path::absolute(path)?;
    let mut confined = CONFINED.write().unwrap_or_else(PoisonError::into_inner);
    if !confined.contains(&path) {
        confined.push(path);
    }
    Ok(())
}

/// Checks a path that is about to be opened.
pub(crate) fn check(path: &Path) -> Result<()> {
    let confined = CONFINED.read().unwrap_or_else(PoisonError::into_inner);
    if confined.is_empty() {
        return Ok(());
    }
    let path = std::path::absolute(path)?;
    for root in confined.iter().filter(|root| path.starts_with(root)) {
        let depth = path.components().count() - root.components().count();
        let parts: Vec<&Path> = path.ancestors().take(depth + 1).collect();
        for part in parts.into_iter().rev() {
            let kind = match std::fs::symlink_metadata(part) {
                Ok(metadata) => metadata.file_type(),
                Err(error) if error.kind() == ErrorKind::NotFound => break,
                Err(error) => return Err(error),
            };
            let expected = if part == path { kind.is_file() || kind.is_dir() } else { kind.is_dir() };
            if !expected {
                let what = if kind.is_symlink() { "a symbolic link" } else { "no regular file or folder" };
                let what = format!("{} is {what}: it is not used, because others may have made it", part.display());
                return Err(Error::new(ErrorKind::InvalidInput, what));
            }
        }
    }
    Ok(())
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn links_and_pipes_below_a_confined_path_are_refused_for_reading_and_writing() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir_all(at("plan/films/deep")).unwrap();
        std::fs::write(at("secret"), b"1").unwrap();
        symlink("../../secret", at("plan/films/file")).unwrap();
        symlink("../..", at("plan/films/up")).unwrap();
        symlink("../../new", at("plan/films/dangling")).unwrap();
        symlink("../secret", at("plan/other")).unwrap();
        symlink("plan", at("name")).unwrap();
        assert!(std::process::Command::new("mkfifo").arg(at("plan/films/pipe")).status().unwrap().success());
        confine(&at("plan/films")).unwrap();
        for name in ["file", "up/secret", "up/new", "dangling", "pipe", "deep/../file"] {
            let path = at("plan/films").join(name);
            let results = [
                crate::read(&path).err(),
                crate::open_file(&path).err(),
                crate::write(&path, b"2").err(),
                crate::writable(&path).err(),
                crate::append(&path).err(),
            ];
            for error in results {
                assert_eq!(error.map(|error| error.kind()), Some(ErrorKind::InvalidInput), "{name}");
            }
        }
        assert_eq!(std::fs::read(at("secret")).unwrap(), b"1");
        assert!(!at("new").exists());
        // Regular files, what is beside the folder, and links above it.
        crate::write(&at("plan/films/deep/a"), b"2").unwrap();
        crate::write(&at("plan/films/new/a"), b"2").unwrap();
        std::io::Write::write_all(&mut crate::append(&at("plan/films/new/a")).unwrap(), b"3").unwrap();
        assert_eq!(crate::read(&at("name/films/new/a")).unwrap(), b"23");
        assert_eq!(crate::read(&at("plan/other")).unwrap(), b"1");
    }
}
