//! The outcome of an experiment, and its files.

use crate::Quality;
use crate::context::write;
use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The file of the outcome. It is written last: an experiment that has it is finished.
const FILE: &str = "result.json";

/// The largest result that is read: 64 MiB. Results of paper quality have less than 1 MiB.
const MOST_BYTES: u64 = 64 << 20;

/// The results of an experiment. [`run`](crate::run) fills in the time, the version and the machine.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Outcome {
    /// Its name on the command line.
    pub name: String,
    /// The paper's figure or table: "Fig. 11", "Table 4".
    pub figure: String,
    /// What it shows.
    pub title: String,
    /// What the paper states, in our words.
    pub paper: String,
    /// Pairs of pictures to compare.
    pub sliders: Vec<Slider>,
    /// Its other pictures.
    pub pictures: Vec<Picture>,
    /// Its tables.
    pub tables: Vec<Table>,
    /// The claims, and what was measured.
    pub claims: Vec<Claim>,
    /// Paragraphs that a reader needs to judge the numbers.
    pub notes: Vec<String>,
    /// Duration of the last run, without the time of earlier, interrupted runs.
    pub seconds: f64,
    /// The amount of work.
    pub quality: Quality,
    /// The version of this crate.
    pub version: String,
    /// Threads that it ran on.
    pub threads: usize,
    /// The name of the processor.
    pub processor: String,
}

/// A picture in the experiment's folder.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Picture {
    /// The PNG that the page shows.
    pub file: String,
    /// Files with the same picture in other formats.
    pub also: Vec<String>,
    /// The text below it.
    pub caption: String,
    /// Whether it is in the same row as the picture before it. Pictures of a row have the same width.
    pub beside: bool,
}

impl Picture {
    /// A picture in a row of its own.
    pub fn new(file: impl Into<String>, caption: impl Into<String>) -> Self {
        Picture { file: file.into(), also: Vec::new(), caption: caption.into(), beside: false }
    }

    /// Puts the picture into the row of the picture before it.
    pub fn beside(self) -> Self {
        Picture { beside: true, ..self }
    }

    /// Adds a file with the same picture in another format.
    pub fn also(mut self, file: impl Into<String>) -> Self {
        self.also.push(file.into());
        self
    }
}

/// Two pictures of the same view, one on top of the other, with a divider that the reader moves.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Slider {
    /// The text below it.
    pub caption: String,
    /// Width and height of the pictures in pixels.
    pub size: [usize; 2],
    /// The left and the right picture.
    pub sides: [Side; 2],
    /// Pictures of the difference.
    pub maps: Vec<Side>,
    /// Left, top, width and height of the enlarged part, in pixels.
    pub zoom: [usize; 4],
}

/// A picture of a [`Slider`].
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Side {
    /// The PNG of the whole picture.
    pub file: String,
    /// The PNG of the enlarged part.
    pub zoom: String,
    /// What it shows.
    pub label: String,
}

/// A table. It is also written as CSV.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Table {
    /// The name of the CSV file, without `.csv`.
    pub name: String,
    /// The text above it.
    pub caption: String,
    /// Names of the columns.
    pub header: Vec<String>,
    /// Rows, with one cell for each column.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows.
    pub fn new(name: &str, caption: impl Into<String>, header: &[&str]) -> Self {
        let header = header.iter().map(|&cell| cell.to_owned()).collect();
        Table { name: name.to_owned(), caption: caption.into(), header, rows: Vec::new() }
    }

    /// Adds a row: one cell for each column.
    pub fn row<T: Into<String>>(&mut self, cells: impl IntoIterator<Item = T>) {
        self.rows.push(cells.into_iter().map(Into::into).collect());
    }
}

/// A claim of the paper, or our own, and what was measured.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Claim {
    /// The claim: one sentence.
    pub what: String,
    /// What the paper claims, or [`NOTHING`].
    pub paper: String,
    /// What we claim, or our bound for a word of the paper, or [`NOTHING`].
    pub ours: String,
    /// The number that was measured, with its unit.
    pub measured: String,
    /// Other numbers, or empty.
    pub more: String,
    /// The number that decides, if there is one.
    pub value: Option<f64>,
    /// Whether the claim holds.
    pub verdict: Verdict,
    /// Why the claim is not judged. Otherwise a remark, or empty.
    pub why: String,
}

/// Stands for a claim that is not made.
pub const NOTHING: &str = "–";

/// Whether a claim holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Verdict {
    /// It holds.
    #[serde(rename = "holds")]
    Holds,
    /// It holds, and the measured value is better than the claimed one.
    #[serde(rename = "better")]
    Better,
    /// It does not hold.
    #[serde(rename = "does not hold")]
    DoesNotHold,
    /// It compares with a program that we do not have, and does not hold for our optimised version of it.
    #[serde(rename = "not reproduced with our optimised baseline")]
    NotReproduced,
    /// It cannot be judged. [`Claim::why`] is the reason.
    #[serde(rename = "not judged")]
    NotJudged,
    /// Smoke quality is too low to judge claims.
    #[serde(rename = "not judged at smoke quality")]
    NotAtSmokeQuality,
}

impl Verdict {
    /// All verdicts, in the order of summaries.
    pub const ALL: [Verdict; 6] = [
        Verdict::Holds,
        Verdict::Better,
        Verdict::DoesNotHold,
        Verdict::NotReproduced,
        Verdict::NotJudged,
        Verdict::NotAtSmokeQuality,
    ];

    /// The verdict in words.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Holds => "holds",
            Verdict::Better => "better",
            Verdict::DoesNotHold => "does not hold",
            Verdict::NotReproduced => "not reproduced with our optimised baseline",
            Verdict::NotJudged => "not judged",
            Verdict::NotAtSmokeQuality => "not judged at smoke quality",
        }
    }

    /// A count in words: "3 hold", "1 does not hold".
    pub fn count(self, n: usize) -> String {
        let name = match self {
            Verdict::Holds if n != 1 => "hold",
            Verdict::DoesNotHold if n != 1 => "do not hold",
            _ => self.name(),
        };
        format!("{n} {name}")
    }

    /// `Holds` or `DoesNotHold`.
    pub fn of(holds: bool) -> Self {
        if holds { Verdict::Holds } else { Verdict::DoesNotHold }
    }

    /// For a ratio that should be at least `expected`. It is better if it is at least a tenth larger.
    pub fn at_least(value: f64, expected: f64) -> Self {
        if value >= 1.1 * expected { Verdict::Better } else { Verdict::of(value >= expected) }
    }

    /// For a number that should be at most `expected`. It is better if it is at least a tenth smaller.
    pub fn at_most(value: f64, expected: f64) -> Self {
        if value <= 0.9 * expected { Verdict::Better } else { Verdict::of(value <= expected) }
    }

    /// The verdict on a claim about the paper's program of the model of 2015, measured with our optimised version.
    pub fn beside_our_baseline(self) -> Self {
        if self == Verdict::DoesNotHold { Verdict::NotReproduced } else { self }
    }
}

impl Claim {
    /// A claim that `value` decides. `measured` is the same number for readers.
    pub fn new(what: impl Into<String>, measured: impl Into<String>, value: f64, verdict: Verdict) -> Self {
        Claim { value: Some(value), verdict, ..Claim::not_judged(what, measured, "") }
    }

    /// A claim that cannot be judged here, or not at this quality, and why.
    pub fn not_judged(what: impl Into<String>, measured: impl Into<String>, why: impl Into<String>) -> Self {
        let (what, measured, why) = (what.into(), measured.into(), why.into());
        let (paper, ours) = (NOTHING.to_owned(), NOTHING.to_owned());
        Claim { what, paper, ours, measured, more: String::new(), value: None, verdict: Verdict::NotJudged, why }
    }

    /// Adds what the paper claims.
    pub fn paper(self, paper: impl Into<String>) -> Self {
        Claim { paper: paper.into(), ..self }
    }

    /// Adds what we claim, or our bound for a word of the paper.
    pub fn ours(self, ours: impl Into<String>) -> Self {
        Claim { ours: ours.into(), ..self }
    }

    /// Adds other numbers.
    pub fn more(self, more: impl Into<String>) -> Self {
        Claim { more: more.into(), ..self }
    }

    /// Adds a remark if the claim does not hold, or is not reproduced.
    pub fn or_because(self, why: &str) -> Self {
        if matches!(self.verdict, Verdict::DoesNotHold | Verdict::NotReproduced) { self.because(why) } else { self }
    }

    /// Adds a remark.
    pub fn because(self, why: impl Into<String>) -> Self {
        Claim { why: why.into(), ..self }
    }
}

impl Outcome {
    /// An outcome without results; `paper` is what the paper states.
    pub fn new(paper: impl Into<String>) -> Self {
        Outcome { paper: paper.into(), ..Outcome::default() }
    }

    /// Removes all verdicts, because nothing is judged at smoke quality.
    pub fn withhold_verdicts(&mut self) {
        for claim in &mut self.claims {
            (claim.verdict, claim.value) = (Verdict::NotAtSmokeQuality, None);
            claim.why = "A smoke test shows that the experiment runs. It is too short to judge by.".to_owned();
        }
    }

    /// How many claims hold, and how long the experiment took.
    pub fn summary(&self) -> String {
        let count = |verdict: Verdict| self.claims.iter().filter(|c| c.verdict == verdict).count();
        let counts = Verdict::ALL.into_iter().map(|v| (v, count(v))).filter(|(_, n)| *n > 0);
        let mut parts: Vec<String> = counts.map(|(verdict, n)| verdict.count(n)).collect();
        parts.push(format!("{:.1} s", self.seconds));
        parts.join(", ")
    }

    /// Reads a finished outcome, if there is one.
    pub fn read(folder: &Path) -> Option<Self> {
        serde_json::from_slice(&vellus_io::read_at_most(&folder.join(FILE), MOST_BYTES).ok()?).ok()
    }

    /// Writes the tables, then the outcome.
    pub fn write(&self, folder: &Path) -> Result<()> {
        self.check(folder).with_context(|| format!("experiment {}", self.name))?;
        for table in &self.tables {
            let mut csv = csv::Writer::from_writer(Vec::new());
            csv.write_record(&table.header)?;
            table.rows.iter().try_for_each(|row| csv.write_record(row))?;
            write(&folder.join(format!("{}.csv", table.name)), &csv.into_inner()?)?;
        }
        write(&folder.join(FILE), &serde_json::to_vec_pretty(self)?)
    }

    /// Checks that all pictures exist and all numbers are finite.
    fn check(&self, folder: &Path) -> Result<()> {
        let pictures = self.pictures.iter().flat_map(|p| std::iter::once(&p.file).chain(&p.also));
        let sides = self.sliders.iter().flat_map(|s| s.sides.iter().chain(&s.maps));
        for file in pictures.chain(sides.flat_map(|side| [&side.file, &side.zoom])) {
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
                bail!("'{}' is not judged, and gives no reason", claim.what);
            }
        }
        Ok(())
    }
}
