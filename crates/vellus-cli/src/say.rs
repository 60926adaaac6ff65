//! Lines for the user. The macros of the standard library panic where these cannot be written.

use std::fmt::Arguments;
use std::io::{Error, ErrorKind, Result, Write};
use std::sync::OnceLock;

/// Why a line could not be written to standard output: the first reason.
static FAILURE: OnceLock<Error> = OnceLock::new();

/// Writes a line to standard output. Where that fails the work continues, and the program ends with an error: see
/// [`check`]. A closed pipe is no failure: the reader wants no more.
macro_rules! say {
    ($($arguments:tt)*) => { $crate::say::line(format_args!($($arguments)*)) };
}

/// Writes a line to standard error. Nobody is told where that fails, for nobody listens.
macro_rules! note {
    ($($arguments:tt)*) => { $crate::say::error_line(format_args!($($arguments)*)) };
}

pub(crate) use {note, say};

/// What [`say!`] does.
pub fn line(text: Arguments) {
    if let Err(error) = standard_output(format!("{text}\n").as_bytes()) {
        FAILURE.set(error).ok();
    }
}

/// What [`note!`] does.
pub fn error_line(text: Arguments) {
    std::io::stderr().write_all(format!("{text}\n").as_bytes()).ok();
}

/// Writes to standard output now, without a buffer that could lose it in the end. A closed pipe is no failure.
pub fn standard_output(bytes: &[u8]) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(bytes).and_then(|()| out.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        result => result,
    }
}

/// Was every line written that should be?
///
/// # Errors
/// Why the first one that was not could not be written.
pub fn check() -> std::result::Result<(), &'static Error> {
    FAILURE.get().map_or(Ok(()), Err)
}
