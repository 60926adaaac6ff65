//! Resolves the path of an output. Symbolic links are followed here, because a rename would replace them.

use crate::confined;
use crate::write::folder;
use std::io::{Error, ErrorKind, Result};
use std::path::{Path, PathBuf};

/// The largest number of links in a chain, as on Linux.
const MAX_LINKS: usize = 40;

/// The target of an output.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// An existing or new regular file.
    File(PathBuf),
    /// A device, a pipe or a socket.
    Direct(PathBuf),
    /// A file descriptor of this or another process, by its path in `/proc` or `/dev/fd`.
    Descriptor(PathBuf),
    /// File descriptor 1 of this process.
    StandardOutput,
    /// File descriptor 2 of this process.
    StandardError,
}

/// Resolves a path. Follows symbolic links.
pub(crate) fn target(path: &Path) -> Result<Target> {
    confined::check(path)?;
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
    Err(Error::new(ErrorKind::InvalidInput, format!("it is a chain of more than {MAX_LINKS} symbolic links")))
}

/// The file descriptor of a path such as `/proc/self/fd/1`. Such a path looks like a link, but its target cannot be
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
