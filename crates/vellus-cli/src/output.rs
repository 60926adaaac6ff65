//! Results: to standard output or to files.

use crate::number::one_of;
use crate::say;
use anyhow::{Context, Result, bail};
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
