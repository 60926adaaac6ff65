//! Exit codes and error messages.

use crate::say;
use std::io;

/// Bad input or wrong usage.
pub const BAD_INPUT: u8 = 2;
/// A temporary failure: the same command may succeed later. `EX_TEMPFAIL` in sysexits.h.
pub const MAY_PASS: u8 = 75;

/// The exit codes, for `--help`.
pub const HELP: &str = "Exit codes: 0 success; 2 bad input or wrong usage; 75 temporary failure, such as a full disk \
                        or too many open files; 130, 143 and 129 stopped by SIGINT (Ctrl-C), SIGTERM or SIGHUP.";

/// The error of work that a signal stopped.
#[derive(Debug)]
pub struct Interrupted {
    /// The number of the signal.
    pub signal: i32,
    /// The results that were kept, their place, and how to continue.
    pub kept: String,
}

impl std::fmt::Display for Interrupted {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "interrupted: {}", self.kept)
    }
}

impl std::error::Error for Interrupted {}

/// The exit code and the message of an error.
pub fn report(error: &anyhow::Error) -> (u8, String) {
    if let Some(interrupted) = error.chain().find_map(|cause| cause.downcast_ref::<Interrupted>()) {
        return (u8::try_from(128 + interrupted.signal).unwrap_or(u8::MAX), interrupted.to_string());
    }
    let io =
        |cause: &(dyn std::error::Error + 'static)| cause.downcast_ref::<io::Error>().is_some_and(vellus_io::may_pass);
    let code = if error.chain().any(io) { MAY_PASS } else { BAD_INPUT };
    (code, say::message(&format!("error: {error:#}")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::{Context, anyhow};
    use std::io::ErrorKind;

    #[test]
    fn messages_have_an_end() {
        let (_, message) = report(&anyhow!("é".repeat(100_000)));
        assert_eq!(message.chars().count(), say::LONGEST + 2);
        // Escapes are longer than the characters that they replace.
        let (_, message) = report(&anyhow!("\0".repeat(100_000)));
        assert_eq!(message.chars().count(), say::LONGEST + 2);
    }

    #[test]
    fn codes_follow_the_cause_through_all_contexts() {
        let code = |error: anyhow::Error| report(&error).0;
        assert_eq!(code(anyhow!("--spp 0 is out of range")), BAD_INPUT);
        assert_eq!(code(io::Error::from(ErrorKind::NotFound).into()), BAD_INPUT);
        assert_eq!(code(io::Error::new(ErrorKind::FileTooLarge, "it has 9 bytes or more").into()), BAD_INPUT);
        assert_eq!(code(io::Error::from(ErrorKind::StorageFull).into()), MAY_PASS);
        let usd = vellus_usd::Error::Write { file: "a".into(), source: ErrorKind::QuotaExceeded.into() };
        assert_eq!(code(anyhow::Error::from(usd).context("frame 3")), MAY_PASS);
        let interrupted: anyhow::Result<()> = Err(Interrupted { signal: 15, kept: "all is in a.film".into() }.into());
        let error = interrupted.context("frame 3").unwrap_err();
        assert_eq!(report(&error), (143, "interrupted: all is in a.film".to_owned()));
    }
}
