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

/// Processor time of all threads since the program began, where the system tells it.
pub fn cpu_time() -> Option<std::time::Duration> {
    #[cfg(unix)]
    return rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime).try_into().ok();
    #[cfg(not(unix))]
    None
}

/// Columns aligned to their widest cell, numbers to the right.
pub fn align(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns)
        .map(|c| rows.iter().filter_map(|r| r.get(c)).map(|s| s.chars().count()).max().unwrap_or(0))
        .collect();
    let mut text = String::new();
    for row in rows {
        let mut line = String::new();
        for (c, cell) in row.iter().enumerate() {
            let padding = " ".repeat(widths[c] - cell.chars().count());
            if c == 0 {
                line += &format!("{cell}{padding}");
            } else {
                line += &format!("  {padding}{cell}");
            }
        }
        text += line.trim_end();
        text.push('\n');
    }
    text
}

/// Six significant digits, for tables.
pub fn number(x: f64) -> String {
    if x == 0.0 {
        "0".to_owned()
    } else if (1e-4..1e5).contains(&x.abs()) {
        let digits = (5 - x.abs().log10().floor() as i32).clamp(0, 9) as usize;
        format!("{x:.digits$}")
    } else {
        format!("{x:.4e}")
    }
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
