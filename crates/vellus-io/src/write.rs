//! Safe writing: a file is replaced completely or not at all.

use crate::confined;
use crate::leftover;
use crate::target::{Target, target};
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Error, ErrorKind, Result, Write};
use std::path::Path;
use tempfile::NamedTempFile;

/// Number of bytes that [`writable`] writes to test whether the disk is full.
const PROBE_BYTES: usize = 4096;

/// Writes a file.
///
/// A regular or new file is written under a temporary name in the same folder, synchronised with the disk and renamed.
/// A failure leaves the previous file. Missing folders are created. Symbolic links are followed and stay. The target of
/// a dangling link is created. A device, a pipe or a file descriptor such as `/dev/stdout` is written directly.
///
/// A program that is killed meanwhile leaves its temporary file, `.vellus-` and six letters. Later calls for the same
/// folder remove it once it is ten minutes old.
///
/// An existing file keeps its mode, and its owner and group if the system permits that. It loses access control lists
/// and other hard links. The mode of a new file follows the umask.
///
/// # Errors
/// Errors of the operating system. [`ErrorKind::IsADirectory`] for a folder. [`ErrorKind::PermissionDenied`] for an
/// existing file that is read-only, even if its folder is writable.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    write_with(path, |out| out.write_all(bytes))
}

/// As [`write()`], for content that `fill` writes piece by piece.
///
/// # Errors
/// As [`write()`], and the errors of `fill`.
pub fn write_with(path: &Path, fill: impl FnOnce(&mut dyn Write) -> Result<()>) -> Result<()> {
    let buffered = |out: &mut dyn Write| {
        let mut out = BufWriter::new(out);
        fill(&mut out)?;
        out.flush()
    };
    match target(path)? {
        Target::File(path) => replace(&path, buffered),
        Target::Direct(path) => buffered(&mut OpenOptions::new().write(true).open(path)?),
        // The process that opened the descriptor may have written to it before.
        Target::Descriptor(path) => buffered(&mut OpenOptions::new().append(true).open(path)?),
        // These share their file position with other output of the program.
        Target::StandardOutput => buffered(&mut std::io::stdout().lock()),
        Target::StandardError => buffered(&mut std::io::stderr().lock()),
    }
}

/// Opens a file to append to it. Missing folders are created.
///
/// # Errors
/// Errors of the operating system.
pub fn append(path: &Path) -> Result<File> {
    confined::check(path)?;
    std::fs::create_dir_all(folder(path))?;
    OpenOptions::new().create(true).append(true).open(path)
}

/// Checks that [`write()`] can write to a path. Call it before long work. Creates the folder of the file. Writes
/// nothing to devices and pipes.
///
/// # Errors
/// As [`write()`].
pub fn writable(path: &Path) -> Result<()> {
    let Target::File(path) = target(path)? else { return Ok(()) };
    let mut file = temporary(&path, existing(&path)?.as_ref())?;
    file.as_file_mut().write_all(&[0; PROBE_BYTES])?;
    file.as_file().sync_all()
}

/// The folder of a file. It is `.` for a path without a folder.
pub fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

fn replace(path: &Path, fill: impl FnOnce(&mut dyn Write) -> Result<()>) -> Result<()> {
    let old = existing(path)?;
    let mut file = temporary(path, old.as_ref())?;
    fill(file.as_file_mut())?;
    if let Some(old) = old {
        keep_attributes(file.as_file(), &old)?;
    }
    // Some file systems report a full disk only here. The old file must still exist then.
    file.as_file().sync_all()?;
    file.persist(path).map_err(|error| error.error)?;
    Ok(())
}

/// The metadata of the existing file, if any. Returns an error if it must not be replaced.
fn existing(path: &Path) -> Result<Option<std::fs::Metadata>> {
    let metadata = match std::fs::metadata(path) {
        Ok(metadata) => metadata,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error),
    };
    if metadata.permissions().readonly() {
        return Err(Error::new(
            ErrorKind::PermissionDenied,
            "it is read-only: change its mode, or choose another name",
        ));
    }
    // Replacing a file only needs write permission for its folder. Require it for the file too.
    OpenOptions::new().write(true).open(path)?;
    Ok(Some(metadata))
}

/// A temporary file in the folder of `path`. If there is an old file, which may be private, the temporary file is
/// private until it has the attributes of the old one.
fn temporary(path: &Path, old: Option<&std::fs::Metadata>) -> Result<NamedTempFile> {
    let folder = folder(path);
    std::fs::create_dir_all(folder)?;
    let mut code = None;
    let open = |path: &Path| {
        let mut options = OpenOptions::new();
        options.write(true).create_new(true);
        #[cfg(unix)]
        if old.is_some() {
            std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        }
        options.open(path).inspect_err(|error| code = error.raw_os_error())
    };
    let file = tempfile::Builder::new().prefix(leftover::PREFIX).make_in(folder, open);
    // Returns the error of the operating system without the temporary name.
    let file = file.map_err(|error| code.map_or(error, Error::from_raw_os_error))?;
    // Not all file systems have locks.
    file.as_file().try_lock().ok();
    leftover::remove(folder, file.as_file());
    Ok(file)
}

#[cfg(unix)]
fn keep_attributes(file: &File, old: &std::fs::Metadata) -> Result<()> {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, fchown};
    let new = file.metadata()?;
    if (new.uid(), new.gid()) != (old.uid(), old.gid()) {
        // Only a privileged user can change the owner. Others may still change the group.
        fchown(file, Some(old.uid()), Some(old.gid())).or_else(|_| fchown(file, None, Some(old.gid()))).ok();
    }
    // After the change of owner, because that resets bits of the mode.
    file.set_permissions(std::fs::Permissions::from_mode(old.mode() & 0o777))
}

#[cfg(not(unix))]
fn keep_attributes(_file: &File, _old: &std::fs::Metadata) -> Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names of all files in a folder.
    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_is_replaced_as_a_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/folder/a");
        writable(&path).unwrap();
        assert!(!path.exists());
        write(&path, b"one").unwrap();
        let failure = write_with(&path, |out| {
            out.write_all(b"two")?;
            Err(ErrorKind::StorageFull.into())
        });
        assert_eq!(failure.unwrap_err().kind(), ErrorKind::StorageFull);
        assert_eq!(std::fs::read(&path).unwrap(), b"one");
        write(&path, b"three").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"three");
        assert_eq!(names(path.parent().unwrap()), ["a"], "no temporary file is left");
    }

    #[test]
    fn folders_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        for path in [folder.path().to_owned(), folder.path().join("new/"), folder.path().join("..")] {
            for result in [writable(&path), write(&path, b"1")] {
                assert_eq!(result.unwrap_err().kind(), ErrorKind::IsADirectory, "{}", path.display());
            }
        }
        assert!(names(folder.path()).is_empty());
    }

    #[cfg(unix)]
    mod unix {
        use super::*;
        use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt, symlink};

        fn mode(path: &Path) -> u32 {
            path.metadata().unwrap().mode() & 0o7777
        }

        #[test]
        fn a_new_file_follows_the_umask_and_an_old_one_keeps_its_mode() {
            let folder = tempfile::tempdir().unwrap();
            let [ours, other] = ["ours", "other"].map(|name| folder.path().join(name));
            write(&ours, b"1").unwrap();
            File::create(&other).unwrap();
            assert_eq!(mode(&ours), mode(&other));
            for bits in [0o600, 0o664, 0o777, 0o200] {
                std::fs::set_permissions(&ours, std::fs::Permissions::from_mode(bits)).unwrap();
                write(&ours, b"2").unwrap();
                assert_eq!(mode(&ours), bits, "{bits:o}");
            }
        }

        #[test]
        fn a_read_only_file_is_refused_and_stays() {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("a");
            write(&path, b"1").unwrap();
            std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o400)).unwrap();
            for result in [writable(&path), write(&path, b"2")] {
                let error = result.unwrap_err();
                assert!(error.kind() == ErrorKind::PermissionDenied && error.to_string().contains("read-only"));
            }
            assert_eq!((std::fs::read(&path).unwrap(), mode(&path)), (b"1".to_vec(), 0o400));
        }

        #[test]
        fn links_stay_and_their_targets_are_written() {
            let folder = tempfile::tempdir().unwrap();
            let at = |name: &str| folder.path().join(name);
            std::fs::create_dir(at("real")).unwrap();
            std::fs::write(at("real/a"), b"1").unwrap();
            // Relative and absolute, and a chain of them.
            symlink("real/a", at("relative")).unwrap();
            symlink(at("relative"), at("chain")).unwrap();
            symlink("real/new", at("dangling")).unwrap();
            for (link, file) in [("relative", "real/a"), ("chain", "real/a"), ("dangling", "real/new")] {
                writable(&at(link)).unwrap();
                write(&at(link), link.as_bytes()).unwrap();
                assert!(at(link).symlink_metadata().unwrap().is_symlink(), "{link}");
                assert!(at(file).symlink_metadata().unwrap().is_file(), "{file}");
                assert_eq!(std::fs::read(at(file)).unwrap(), link.as_bytes());
            }
            symlink("round", at("round")).unwrap();
            assert!(write(&at("round"), b"1").unwrap_err().to_string().contains("symbolic links"));
        }

        #[test]
        fn pipes_are_written_to_and_stay() {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("pipe");
            assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
            // A probe must not wait for a reader.
            writable(&path).unwrap();
            let reader = std::thread::spawn({
                let path = path.clone();
                move || std::fs::read(path).unwrap()
            });
            write(&path, b"through").unwrap();
            assert_eq!(reader.join().unwrap(), b"through");
            assert!(path.symlink_metadata().unwrap().file_type().is_fifo());
        }

        #[cfg(target_os = "linux")]
        #[test]
        fn devices_are_written_to_and_stay() {
            let folder = tempfile::tempdir().unwrap();
            let link = folder.path().join("link");
            symlink("/dev/full", &link).unwrap();
            for path in [Path::new("/dev/full"), &link] {
                assert_eq!(write(path, b"1").unwrap_err().kind(), ErrorKind::StorageFull, "{}", path.display());
            }
            write(Path::new("/dev/null"), b"1").unwrap();
            for device in ["/dev/full", "/dev/null"] {
                assert!(Path::new(device).symlink_metadata().unwrap().file_type().is_char_device());
            }
        }

        #[cfg(target_os = "linux")]
        #[test]
        fn descriptors_are_appended_to() {
            use std::os::fd::AsRawFd;
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("a");
            let mut file = File::create(&path).unwrap();
            file.write_all(b"before ").unwrap();
            for name in [format!("/dev/fd/{}", file.as_raw_fd()), format!("/proc/self/fd/{}", file.as_raw_fd())] {
                writable(Path::new(&name)).unwrap();
                write(Path::new(&name), b"after ").unwrap();
            }
            assert_eq!(std::fs::read(&path).unwrap(), b"before after after ");
            assert_eq!(names(folder.path()), ["a"]);
            for (name, expected) in [("/dev/stdout", Target::StandardOutput), ("/dev/stderr", Target::StandardError)] {
                assert_eq!(target(Path::new(name)).unwrap(), expected);
            }
        }
    }
}
