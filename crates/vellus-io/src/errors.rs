//! Temporary errors.

use std::io::{self, ErrorKind};

/// Whether the same operation may succeed later: after a full disk, or with too many open files, but not for a missing
/// file.
pub fn may_pass(error: &io::Error) -> bool {
    match error.kind() {
        ErrorKind::StorageFull
        | ErrorKind::QuotaExceeded
        | ErrorKind::OutOfMemory
        | ErrorKind::StaleNetworkFileHandle
        | ErrorKind::TimedOut
        | ErrorKind::BrokenPipe
        // The system cannot create more threads or processes.
        | ErrorKind::WouldBlock => true,
        // The system reports a write beyond `ulimit -f`. The readers of this crate use the same kind for files that are
        // too large.
        ErrorKind::FileTooLarge => error.raw_os_error().is_some(),
        _ => code_may_pass(error),
    }
}

/// Error codes for which the standard library has no kind.
#[cfg(unix)]
fn code_may_pass(error: &io::Error) -> bool {
    use rustix::io::Errno;
    let passing = [Errno::MFILE, Errno::NFILE];
    error.raw_os_error().is_some_and(|code| passing.iter().any(|errno| errno.raw_os_error() == code))
}

#[cfg(not(unix))]
fn code_may_pass(error: &io::Error) -> bool {
    const ERROR_TOO_MANY_OPEN_FILES: i32 = 4;
    error.raw_os_error() == Some(ERROR_TOO_MANY_OPEN_FILES)
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn codes_of_the_system_are_known() {
        // ENFILE, EMFILE, EFBIG, ENOSPC, EDQUOT, ENOMEM, EAGAIN; ENOENT, EIO, EACCES, EISDIR, EINVAL.
        for (codes, passes) in [(&[23, 24, 27, 28, 122, 12, 11][..], true), (&[2, 5, 13, 21, 22], false)] {
            for &code in codes {
                assert_eq!(may_pass(&io::Error::from_raw_os_error(code)), passes, "{code}");
            }
        }
    }
}
