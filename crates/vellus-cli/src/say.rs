//! Output to the terminal. Unlike the macros of the standard library, these never panic.

use std::collections::BTreeSet;
use std::fmt::Arguments;
use std::io::{Error, ErrorKind, Result, Write};
use std::sync::{Mutex, OnceLock, PoisonError};

/// The first error of writing to standard output.
static FAILURE: OnceLock<Error> = OnceLock::new();

/// Writes a line to standard output. If that fails, the work continues, and the program ends with an error, see
/// [`check`]. A closed pipe is not an error, because its reader has quit.
macro_rules! say {
    ($($arguments:tt)*) => { $crate::say::line(format_args!($($arguments)*)) };
}

/// Writes a line to standard error. Errors are ignored, because they cannot be reported anywhere.
macro_rules! note {
    ($($arguments:tt)*) => { $crate::say::error_line(format_args!($($arguments)*)) };
}

pub(crate) use {note, say};

/// Implements [`say!`].
pub fn line(text: Arguments) {
    if let Err(error) = standard_output(format!("{text}\n").as_bytes()) {
        FAILURE.set(error).ok();
    }
}

/// Implements [`note!`].
pub fn error_line(text: Arguments) {
    std::io::stderr().write_all(format!("{}\n", message(&text.to_string())).as_bytes()).ok();
}

/// The longest message, in characters. Messages quote names and lines of files, which may be very long.
pub const LONGEST: usize = 1000;

/// A text for the terminal.
pub fn message(text: &str) -> String {
    let mut message = vellus_io::visible(text);
    if let Some((end, _)) = message.char_indices().nth(LONGEST) {
        message.replace_range(end.., " …");
    }
    message
}

/// Writes a line to standard error, unless the program has written it before.
pub fn note_once(text: String) {
    static WRITTEN: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    let is_new = |text: &str| WRITTEN.lock().unwrap_or_else(PoisonError::into_inner).insert(text.to_owned());
    if is_new(&text) {
        error_line(format_args!("{text}"));
    }
}

/// The error of a processor without an instruction set. Only the standard library, which is compiled for all
/// processors, may run here: formatting would be compiled for this one.
pub fn without_instructions(missing: &str) {
    let mut error = std::io::stderr();
    for part in [
        "error: this program needs a processor with ",
        missing,
        ", and this one has none: take the archive whose name ends in -baseline, or compile with \
         RUSTFLAGS=\"-C target-cpu=x86-64\"\n",
    ] {
        error.write_all(part.as_bytes()).ok();
    }
}

/// Writes to standard output and flushes it. A closed pipe is not an error.
pub fn standard_output(bytes: &[u8]) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(bytes).and_then(|()| out.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        result => result,
    }
}

/// Standard output as a writer. A closed pipe is not an error.
pub struct StandardOutput;

impl Write for StandardOutput {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        standard_output(bytes).map(|()| bytes.len())
    }

    fn flush(&mut self) -> Result<()> {
        Ok(())
    }
}

/// Checks that all lines were written to standard output.
///
/// # Errors
/// The first error of writing to it.
pub fn check() -> Result<()> {
    FAILURE
        .get()
        .map_or(Ok(()), |error| Err(error.raw_os_error().map_or(error.kind().into(), Error::from_raw_os_error)))
}
