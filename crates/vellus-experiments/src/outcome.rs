//! What an experiment found, and how it is kept.

use super::Quality;
use crate::output;
use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The file in an experiment's folder that says that it is finished.
const FILE: &str = "result.json";

/// The largest result that is read: 64 MiB. Those of paper quality have less than 1 MiB.
const MOST_BYTES: u64 = 64 << 20;

/// All that an experiment has to show. What it ran with is filled in by the frame.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Outcome {
    /// Its name on the command line.
    pub name: String,
    /// The paper's figure or table: "Fig. 11", "Table 4".
    pub figure: String,
    pub title: String,
    /// What the paper says, in a sentence or two of our own.
    pub paper: String,
    pub pictures: Vec<Picture>,
    pub tables: Vec<Table>,
    pub claims: Vec<Claim>,
    /// Paragraphs that a reader needs to judge the numbers.
    pub notes: Vec<String>,
    /// How long the last run took; what an earlier one left is not in it.
    pub seconds: f64,
    pub quality: Quality,
    /// Of this program.
    pub version: String,
    /// Threads it ran on, and of what processor.
    pub threads: usize,
    pub processor: String,
}

/// A picture in the experiment's folder.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Picture {
    /// What the page shows: a PNG.
    pub file: String,
    /// The same in other formats.
    pub also: Vec<String>,
    pub caption: String,
    /// In one row with the picture before it, all of the row equally wide.
    pub beside: bool,
}

impl Picture {
    /// A picture in a row of its own.
    pub fn new(file: impl Into<String>, caption: impl Into<String>) -> Self {
        Picture { file: file.into(), also: Vec::new(), caption: caption.into(), beside: false }
    }

    /// In the row of the one before.
    pub fn beside(self) -> Self {
        Picture { beside: true, ..self }
    }

    /// Another format of it.
    pub fn also(mut self, file: impl Into<String>) -> Self {
        self.also.push(file.into());
        self
    }
}

/// Numbers; the frame writes them as CSV too.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Table {
    /// The CSV file's name without its end.
    pub name: String,
    pub caption: String,
    pub header: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// An empty one.
    pub fn new(name: &str, caption: impl Into<String>, header: &[&str]) -> Self {
        let header = header.iter().map(|&cell| cell.to_owned()).collect();
        Table { name: name.to_owned(), caption: caption.into(), header, rows: Vec::new() }
    }

    /// A row more: as many cells as the header has.
    pub fn row<T: Into<String>>(&mut self, cells: impl IntoIterator<Item = T>) {
        self.rows.push(cells.into_iter().map(Into::into).collect());
    }
}

/// A statement of the paper, or of ours, beside what was measured.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Claim {
    pub what: String,
    pub expected: String,
    pub measured: String,
    /// The number that decides, where there is one.
    pub value: Option<f64>,
    pub verdict: Verdict,
    /// Why it is not judged; else empty, or a remark.
    pub why: String,
}

/// Whether a claim holds here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Verdict {
    #[serde(rename = "holds")]
    Holds,
    /// Holds, and by more than was claimed.
    #[serde(rename = "better")]
    Better,
    #[serde(rename = "does not hold")]
    DoesNotHold,
    #[serde(rename = "not judged")]
    NotJudged,
    /// Too little work was put in to judge anything.
    #[serde(rename = "not judged at this quality")]
    NotAtThisQuality,
}

impl Verdict {
    /// All, as a summary counts them.
    pub const ALL: [Verdict; 5] =
        [Verdict::Holds, Verdict::Better, Verdict::DoesNotHold, Verdict::NotJudged, Verdict::NotAtThisQuality];

    /// In words.
    pub fn name(self) -> &'static str {
        ["holds", "better", "does not hold", "not judged", "not judged at this quality"][self as usize]
    }

    /// "3 hold", "1 does not hold", with a word for many.
    pub fn count(self, n: usize) -> String {
        let name = match self {
            Verdict::Holds if n != 1 => "hold",
            Verdict::DoesNotHold if n != 1 => "do not hold",
            _ => self.name(),
        };
        format!("{n} {name}")
    }

    /// Holds or not.
    pub fn of(holds: bool) -> Self {
        if holds { Verdict::Holds } else { Verdict::DoesNotHold }
    }

    /// A ratio that should be at least `expected`: better from a tenth more on.
    pub fn at_least(value: f64, expected: f64) -> Self {
        if value >= 1.1 * expected { Verdict::Better } else { Verdict::of(value >= expected) }
    }

    /// A number that should be at most `expected`: better from a tenth less on.
    pub fn at_most(value: f64, expected: f64) -> Self {
        if value <= 0.9 * expected { Verdict::Better } else { Verdict::of(value <= expected) }
    }
}

impl Claim {
    /// A claim that was judged by `value`.
    pub fn new(
        what: impl Into<String>,
        expected: impl Into<String>,
        measured: impl Into<String>,
        value: f64,
        verdict: Verdict,
    ) -> Self {
        let (what, expected, measured) = (what.into(), expected.into(), measured.into());
        Claim { what, expected, measured, value: Some(value), verdict, why: String::new() }
    }

    /// A claim that cannot be judged here, or not at this quality, and why.
    pub fn not_judged(
        what: impl Into<String>,
        expected: impl Into<String>,
        measured: impl Into<String>,
        why: impl Into<String>,
    ) -> Self {
        let (what, expected, measured, why) = (what.into(), expected.into(), measured.into(), why.into());
        Claim { what, expected, measured, value: None, verdict: Verdict::NotJudged, why }
    }

    /// A remark beside the verdict where the claim does not hold.
    pub fn or_because(self, why: &str) -> Self {
        if self.verdict == Verdict::DoesNotHold { self.because(why) } else { self }
    }

    /// A remark beside the verdict.
    pub fn because(self, why: impl Into<String>) -> Self {
        Claim { why: why.into(), ..self }
    }
}

impl Outcome {
    /// Nothing found yet; what the paper says.
    pub fn new(paper: impl Into<String>) -> Self {
        Outcome { paper: paper.into(), ..Outcome::default() }
    }

    /// Takes all verdicts back: at smoke quality nothing is judged.
    pub fn withhold_verdicts(&mut self) {
        for claim in &mut self.claims {
            (claim.verdict, claim.value) = (Verdict::NotAtThisQuality, None);
            claim.why = "A smoke test shows that the experiment runs. It is too short to judge by.".to_owned();
        }
    }

    /// A finished one, if a file there is one.
    pub fn read(folder: &Path) -> Option<Self> {
        serde_json::from_slice(&vellus_io::read_at_most(&folder.join(FILE), MOST_BYTES).ok()?).ok()
    }

    /// Writes its tables, and itself last.
    pub fn write(&self, folder: &Path) -> Result<()> {
        self.check(folder).with_context(|| format!("experiment {}", self.name))?;
        for table in &self.tables {
            let mut csv = csv::Writer::from_writer(Vec::new());
            csv.write_record(&table.header)?;
            table.rows.iter().try_for_each(|row| csv.write_record(row))?;
            output::write(Some(&folder.join(format!("{}.csv", table.name))), &csv.into_inner()?)?;
        }
        output::write(Some(&folder.join(FILE)), &serde_json::to_vec_pretty(self)?)
    }

    /// Nothing is shown that is not there, and no number is missing.
    fn check(&self, folder: &Path) -> Result<()> {
        let pictures = self.pictures.iter().flat_map(|p| std::iter::once(&p.file).chain(&p.also));
        for file in pictures {
            if !folder.join(file).is_file() {
                bail!("{file} was not written");
            }
        }
        for table in &self.tables {
            if table.rows.iter().any(|row| row.len() != table.header.len()) {
                bail!("table {}: a row has other columns than the header", table.name);
            }
            let infinite = |word: &str| word.parse::<f64>().is_ok_and(|x| !x.is_finite());
            if let Some(cell) = table.rows.iter().flatten().find(|cell| cell.split_whitespace().any(infinite)) {
                bail!("table {}: '{cell}' is not finite", table.name);
            }
        }
        for claim in &self.claims {
            if claim.value.is_some_and(|x| !x.is_finite()) {
                bail!("'{}': the number measured is not finite", claim.what);
            }
            if claim.value.is_none() && claim.why.is_empty() {
                bail!("'{}' is not judged, and nothing says why", claim.what);
            }
        }
        Ok(())
    }
}
