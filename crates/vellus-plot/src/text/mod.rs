//! Results as text: tables for people, CSV and JSON for programs.

mod energy;
mod eval;
mod fiber;
mod medulla;
mod reference;

pub use energy::{ChannelEnergy, Energy, channel_energies, energy};
pub use eval::Answers;
pub use fiber::{parameters, presets};
pub use medulla::{profile_errors, table_errors, table_info};
pub use reference::{Reference, reference};

use std::str::FromStr;

/// The format of a result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// Aligned columns, for people.
    #[default]
    Table,
    /// Comma-separated values with a header.
    Csv,
    /// One JSON value.
    Json,
    /// One JSON object per line.
    Jsonl,
}

impl Format {
    /// The names of all formats.
    pub const NAMES: [&str; 4] = ["table", "csv", "json", "jsonl"];
}

impl FromStr for Format {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let all = [Format::Table, Format::Csv, Format::Json, Format::Jsonl];
        let known = Format::NAMES.iter().position(|n| *n == name).map(|i| all[i]);
        known.ok_or_else(|| format!("expected {}", Format::NAMES.join(", ")))
    }
}

/// A row of cells: a name and numbers.
fn row(name: impl Into<String>, numbers: impl IntoIterator<Item = f64>) -> Vec<String> {
    std::iter::once(name.into()).chain(numbers.into_iter().map(number)).collect()
}

/// A row of names.
fn header<const N: usize>(names: [&str; N]) -> Vec<String> {
    names.map(str::to_owned).to_vec()
}

/// Aligns columns: the first one to the left, the others to the right, as wide as their widest cell.
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

/// A number with six significant digits.
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
