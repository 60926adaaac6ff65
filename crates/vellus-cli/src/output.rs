//! Results: to standard output or to files.

use crate::number::one_of;
use crate::say::{self, StandardOutput};
use anyhow::{Context, Result, bail};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use vellus_plot::text::Format;

/// The options of a result.
#[derive(clap::Args)]
pub struct OutputArgs {
    /// Format of the result. jsonl has one JSON object per line.
    #[arg(long, value_parser = one_of::<Format>(Format::NAMES), default_value = "table", value_name = "FORMAT")]
    format: Format,
    /// File to write. Default: standard output.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl OutputArgs {
    /// Checks that the result can be written, before long work begins.
    pub fn check(&self) -> Result<()> {
        self.out.as_deref().map_or(Ok(()), writable)
    }

    /// Writes the result that `fill` writes piece by piece for the format. An error of `fill` leaves a file as it was,
    /// but standard output has what was written before.
    pub fn write_with(&self, fill: impl FnOnce(Format, &mut dyn Write) -> Result<()>) -> Result<()> {
        // Errors of the output are plain; others say where they come from.
        let at = |place: String| {
            move |error: anyhow::Error| if error.is::<std::io::Error>() { error.context(place) } else { error }
        };
        let Some(path) = &self.out else {
            let mut out = BufWriter::new(StandardOutput);
            let filled = fill(self.format, &mut out).and_then(|()| Ok(out.flush()?));
            return filled.map_err(at("cannot write to standard output".to_owned()));
        };
        let mut failure = None;
        let written = vellus_io::write_with(path, |out| {
            fill(self.format, out).map_err(|error| {
                failure = Some(error);
                std::io::ErrorKind::Other.into()
            })
        });
        let result = failure.map_or_else(|| Ok(written?), Err);
        result.map_err(at(format!("cannot write {}", path.display())))
    }

    /// Writes the result that `text` returns for the format.
    pub fn write(&self, text: impl FnOnce(Format) -> String) -> Result<()> {
        write(self.out.as_deref(), text(self.format).as_bytes())
    }
}

/// Writes `bytes` to `path`, or to standard output without one. A regular file is replaced as a whole or not at all:
/// see [`vellus_io::write()`].
pub fn write(path: Option<&Path>, bytes: &[u8]) -> Result<()> {
    let Some(path) = path else {
        return say::standard_output(bytes).context("cannot write to standard output");
    };
    vellus_io::write(path, bytes).with_context(|| format!("cannot write {}", path.display()))
}

/// Checks that a file name has one of the extensions.
pub fn check_extension(path: &Path, extensions: &[&str]) -> Result<()> {
    if !path.extension().is_some_and(|e| extensions.iter().any(|extension| e == *extension)) {
        bail!("{}: the name must end in .{}", path.display(), extensions.join(" or ."));
    }
    Ok(())
}

/// Checks that a file can be written, before long work begins.
pub fn writable(path: &Path) -> Result<()> {
    vellus_io::writable(path).with_context(|| format!("cannot write {}", path.display()))
}

/// A progress bar with the remaining time, on standard error if that is a terminal.
pub fn progress(len: u64, what: &'static str) -> indicatif::ProgressBar {
    bar(len, "{msg} [{bar:32}] {percent}% {elapsed} elapsed, {eta} left").with_message(what)
}

/// A progress bar with another layout.
pub fn bar(len: u64, template: &str) -> indicatif::ProgressBar {
    let style = indicatif::ProgressStyle::with_template(template);
    indicatif::ProgressBar::new(len).with_style(style.unwrap_or_else(|_| indicatif::ProgressStyle::default_bar()))
}
