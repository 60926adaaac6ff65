//! Where results go: a terminal or a file, never half a file.

use crate::say;
use anyhow::{Context, Result, bail};
use std::path::{Path, PathBuf};

/// How a table of results is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// Aligned columns for people.
    Table,
    /// Comma-separated values with a header.
    Csv,
    /// One JSON object.
    Json,
    /// One JSON object a line.
    Jsonl,
}

/// In what form a result goes where.
#[derive(clap::Args)]
pub struct OutputArgs {
    /// How to write the result.
    #[arg(long, value_enum, default_value_t = Format::Table)]
    pub format: Format,
    /// Write to a file instead of standard output.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl OutputArgs {
    /// Checks that it can be written, before long work begins.
    pub fn check(&self) -> Result<()> {
        self.out.as_deref().map_or(Ok(()), writable)
    }

    /// Writes it there.
    pub fn write(&self, bytes: &[u8]) -> Result<()> {
        write(self.out.as_deref(), bytes)
    }
}

pub use vellus_experiments::cpu_time;
pub use vellus_io::folder;
pub use vellus_plot::text::{align, number};

/// Writes `bytes` to `path`, or to standard output without one. A regular file is replaced as a whole or not at all:
/// see [`vellus_io::write()`].
pub fn write(path: Option<&Path>, bytes: &[u8]) -> Result<()> {
    let Some(path) = path else {
        return say::standard_output(bytes).context("cannot write to standard output");
    };
    vellus_io::write(path, bytes).with_context(|| format!("cannot write {}", path.display()))
}

/// Refuses a file whose name does not end in one of some extensions.
pub fn check_extension(path: &Path, extensions: &[&str]) -> Result<()> {
    if !path.extension().is_some_and(|e| extensions.iter().any(|extension| e == *extension)) {
        bail!("{}: the name must end in .{}", path.display(), extensions.join(" or ."));
    }
    Ok(())
}

/// Checks that a file can be written there, before long work begins.
pub fn writable(path: &Path) -> Result<()> {
    vellus_io::writable(path).with_context(|| format!("cannot write {}", path.display()))
}

/// A bar for long work with rate and remaining time; nothing where standard error is not a terminal.
pub fn progress(len: u64, what: &'static str) -> indicatif::ProgressBar {
    bar(len, "{msg} [{bar:32}] {percent}% {elapsed} elapsed, {eta} left").with_message(what)
}

/// The same for work that tells by itself how much is left.
pub fn bar(len: u64, template: &str) -> indicatif::ProgressBar {
    let style = indicatif::ProgressStyle::with_template(template);
    indicatif::ProgressBar::new(len).with_style(style.unwrap_or_else(|_| indicatif::ProgressStyle::default_bar()))
}
