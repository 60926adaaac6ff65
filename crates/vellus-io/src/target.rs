//! What a path of an output means: links are followed here, for the operating system would replace them.

use crate::write::folder;
use std::io::{Error, ErrorKind, Result};
use std::path::{Path, PathBuf};

/// Links that are followed: as many as Linux follows.
const MAX_LINKS: usize = 40;

/// Where output goes.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// A regular file that is there, or a new one.
    File(PathBuf),
    /// A device, a pipe or a socket.
    Direct(PathBuf),
    /// A descriptor of this or another process, by its name in `/proc` or `/dev/fd`.
    Descriptor(PathBuf),
    /// Descriptor 1 of this process.
    StandardOutput,
    /// Descriptor 2 of this process.
    StandardError,
}

/// Follows symbolic links to their end.
pub(crate) fn target(path: &Path) -> Result<Target> {
    let names_folder = path.as_os_str().as_encoded_bytes().last().is_some_and(|&b| std::path::is_separator(b.into()));
    if names_folder || path.file_name().is_none() {
        return Err(Error::new(ErrorKind::IsADirectory, "it is the name of a folder"));
    }
    let mut path = path.to_owned();
    for _ in 0..MAX_LINKS {
        if let Some(descriptor) = descriptor(&path) {
            return Ok(descriptor);
        }
        let kind = match std::fs::symlink_metadata(&path) {
            Ok(metadata) => metadata.file_type(),
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Target::File(path)),
            Err(error) => return Err(error),
        };
        if kind.is_dir() {
            return Err(Error::new(ErrorKind::IsADirectory, "it is a folder"));
        } else if !kind.is_symlink() {
            return Ok(if kind.is_file() { Target::File(path) } else { Target::Direct(path) });
        }
        path = folder(&path).join(std::fs::read_link(&path)?);
    }
    Err(Error::new(ErrorKind::InvalidInput, format!("more than {MAX_LINKS} symbolic links follow each other")))
}

/// The open descriptor that a path such as `/proc/self/fd/1` names. What it seems to link to is no path that could be
/// replaced.
fn descriptor(path: &Path) -> Option<Target> {
    if !cfg!(unix) {
        return None;
    }
    let number: u32 = path.file_name()?.to_str()?.parse().ok()?;
    let folder = folder(path).canonicalize().ok()?;
    let own = folder == Path::new("/dev/fd") || folder.starts_with(Path::new("/proc/self").canonicalize().ok()?);
    let is_one = own || folder.starts_with("/proc");
    if !is_one || folder.file_name()? != "fd" {
        return None;
    }
    Some(match number {
        1 if own => Target::StandardOutput,
        2 if own => Target::StandardError,
        _ => Target::Descriptor(path.to_owned()),
    })
}
