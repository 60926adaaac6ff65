//! Bounded reading of files, for all formats.

use crate::confined;
use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// The largest regular file that [`read()`] reads, in bytes: 16 GiB.
pub const MAX_FILE_BYTES: u64 = 16 << 30;

/// The largest number of bytes that are read from a pipe or a socket: 1 GiB.
pub const MAX_STREAM_BYTES: u64 = 1 << 30;

/// Reads a whole file of at most [`MAX_FILE_BYTES`], or a pipe of at most [`MAX_STREAM_BYTES`].
///
/// # Errors
/// Errors of the operating system. [`ErrorKind::InvalidInput`] for folders and devices, because `/dev/zero` never ends.
/// [`ErrorKind::FileTooLarge`] if a limit is exceeded.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    read_at_most(path, MAX_FILE_BYTES)
}

/// As [`read()`], with a limit of `max` bytes. For pipes the limit is the smaller of `max` and [`MAX_STREAM_BYTES`].
///
/// # Errors
/// As [`read()`].
pub fn read_at_most(path: &Path, max: u64) -> Result<Vec<u8>> {
    let file = open(path)?;
    let metadata = file.metadata()?;
    let is_file = metadata.is_file();
    let max = if is_file { max } else { max.min(MAX_STREAM_BYTES) };
    if is_file && metadata.len() > max {
        return Err(too_large(metadata.len(), max));
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(if is_file { metadata.len() as usize } else { 0 }).map_err(|_| {
        Error::new(ErrorKind::OutOfMemory, format!("not enough memory for its {} bytes", metadata.len()))
    })?;
    // The length may be wrong: files can grow, and files in /proc report a length of 0.
    file.take(max + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > max {
        return Err(too_large(bytes.len() as u64, max));
    }
    Ok(bytes)
}

/// Opens a regular file, a pipe or a socket.
///
/// # Errors
/// Errors of the operating system, and [`ErrorKind::InvalidInput`] for folders and devices.
pub fn open(path: &Path) -> Result<File> {
    confined::check(path)?;
    // Checked before the file is opened, because opening some devices has side effects.
    check_kind(&std::fs::metadata(path)?)?;
    let file = File::open(path)?;
    check_kind(&file.metadata()?)?;
    Ok(file)
}

/// Opens a regular file, for formats that are read more than once: a pipe can be read only once, and opening it again
/// would wait for another writer.
///
/// # Errors
/// As [`open()`], and [`ErrorKind::InvalidInput`] for pipes and sockets.
pub fn open_file(path: &Path) -> Result<File> {
    confined::check(path)?;
    let metadata = std::fs::metadata(path)?;
    check_kind(&metadata)?;
    if !metadata.is_file() {
        let what = "it is a pipe or a socket, but this format is read more than once: a regular file is expected";
        return Err(Error::new(ErrorKind::InvalidInput, what));
    }
    File::open(path)
}

/// Text without the byte order mark that some editors put at the beginning of a file.
pub fn unmarked(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

/// Reads a UTF-8 text file of at most `max` bytes, without a byte order mark.
///
/// # Errors
/// As [`read()`], and [`ErrorKind::InvalidData`] with the offset of the first byte that is not UTF-8.
pub fn read_to_string(path: &Path, max: u64) -> Result<String> {
    let text = String::from_utf8(read_at_most(path, max)?).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        Error::new(ErrorKind::InvalidData, format!("it is not UTF-8 text (byte {at})"))
    })?;
    Ok(if unmarked(&text).len() < text.len() { unmarked(&text).to_owned() } else { text })
}

/// The beginning of `bytes` as text for messages: at most `characters` characters, followed by `…` if there are more.
/// Control characters are replaced.
pub fn excerpt(bytes: &[u8], characters: usize) -> String {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(4 * characters + 4)]);
    let mut rest = text.chars();
    let mut shown: String =
        rest.by_ref().take(characters).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    if rest.next().is_some() || bytes.len() > 4 * characters + 4 {
        shown.push('…');
    }
    shown
}

/// Returns an error for folders and devices.
fn check_kind(metadata: &std::fs::Metadata) -> Result<()> {
    let kind = metadata.file_type();
    if kind.is_dir() {
        return Err(Error::new(ErrorKind::InvalidInput, "it is a folder: a file is expected"));
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_char_device() || kind.is_block_device() {
            return Err(Error::new(ErrorKind::InvalidInput, "it is a device: a regular file or a pipe is expected"));
        }
    }
    Ok(())
}

fn too_large(length: u64, max: u64) -> Error {
    Error::new(ErrorKind::FileTooLarge, format!("it has {length} bytes or more: at most {max} are read"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_up_to_the_limit_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, b"1234").unwrap();
        assert_eq!(read_at_most(&path, 4).unwrap(), b"1234");
        assert_eq!(read_at_most(&path, 3).unwrap_err().kind(), ErrorKind::FileTooLarge);
        assert_eq!(read(folder.path()).unwrap_err().kind(), ErrorKind::InvalidInput);
        std::fs::write(&path, b"12\xff").unwrap();
        assert!(read_to_string(&path, 9).unwrap_err().to_string().contains("byte 2"));
        std::fs::write(&path, "\u{feff}a\u{feff}").unwrap();
        assert_eq!(read_to_string(&path, 9).unwrap(), "a\u{feff}");
    }

    #[test]
    fn excerpts_are_short_and_printable() {
        assert_eq!(excerpt(b"f 1 2", 40), "f 1 2");
        assert_eq!(excerpt(b"abcdef\x1b[2J", 3), "abc…");
        assert_eq!(excerpt(b"\x1b[2J\xff\0", 40), "\u{fffd}[2J\u{fffd}\u{fffd}");
        assert_eq!(excerpt(&[b'a'; 1 << 20], 2), "aa…");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn devices_are_refused_and_pipes_are_bounded() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("groom.hair");
        for device in ["/dev/zero", "/dev/urandom", "/dev/null"] {
            std::fs::remove_file(&link).ok();
            std::os::unix::fs::symlink(device, &link).unwrap();
            assert_eq!(read(&link).unwrap_err().kind(), ErrorKind::InvalidInput, "{device}");
        }
        let (reader, mut writer) = std::io::pipe().unwrap();
        std::io::Write::write_all(&mut writer, b"12345").unwrap();
        drop(writer);
        let path = format!("/proc/self/fd/{}", std::os::fd::AsRawFd::as_raw_fd(&reader));
        assert_eq!(open_file(Path::new(&path)).unwrap_err().kind(), ErrorKind::InvalidInput);
        assert_eq!(read_at_most(Path::new(&path), 4).unwrap_err().kind(), ErrorKind::FileTooLarge);
    }
}
