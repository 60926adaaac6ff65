//! Queries of the model, from numbers or from CSV files.

use crate::{Error, Result};
use vellus::{Bcsdf, Lobes, Window};
use vellus_io::BoundedLines;
use vellus_models::direction;

/// One query of the model. Angles are in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Query {
    /// Inclination of ω_o, in [−90, 90].
    pub theta_o: f64,
    /// The offset or the window of offsets.
    pub offsets: Offsets,
    /// Inclination of ω_i, in [−90, 90].
    pub theta_i: f64,
    /// Azimuth of ω_i minus that of ω_o, in [−360, 360].
    pub phi: f64,
}

/// The offset at which the ray hits the fibre, or a window of offsets, in [−1, 1].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Offsets {
    /// At one offset.
    Near(f64),
    /// Averaged from one offset to another.
    Range(f64, f64),
}

/// The answer to a query.
#[derive(Clone, Copy, Debug)]
pub struct Answer {
    /// f·cos θ_i of each lobe.
    pub lobes: Lobes,
    /// The sampling density per steradian.
    pub pdf: f32,
}

/// The columns of a window in CSV files. They replace h.
const WINDOW: [&str; 2] = ["h_lo", "h_hi"];

/// Names of the four coordinates, their limits, and the limits in words.
const COORDINATES: [(&str, f64, f64, &str); 4] = [
    ("theta_o", -90.0, 90.0, "must be in [-90, 90] degrees"),
    ("h", -1.0, 1.0, "must be in [-1, 1]"),
    ("theta_i", -90.0, 90.0, "must be in [-90, 90] degrees"),
    ("phi", -360.0, 360.0, "must be in [-360, 360] degrees"),
];

fn wrong<T>(what: String) -> Result<T> {
    Err(Error::Query(what))
}

impl Offsets {
    /// A window from `low` to `high`.
    ///
    /// # Errors
    /// [`Error::Query`] if an end is not in [−1, 1], or if `low` is above `high`.
    pub fn range(low: f64, high: f64) -> Result<Self> {
        for (name, value) in WINDOW.into_iter().zip([low, high]) {
            if !(-1.0..=1.0).contains(&value) {
                return wrong(format!("{name} = {value} is out of range: {name} must be in [-1, 1]"));
            }
        }
        if low > high {
            return wrong(format!("h_lo = {low} is above h_hi = {high}"));
        }
        Ok(Offsets::Range(low, high))
    }

    /// Parses `near`, which means the offset `h`, `far`, which means the whole width, or LO:HI.
    ///
    /// # Errors
    /// [`Error::Query`] for other text, and as [`Offsets::range`].
    pub fn parse(text: &str, h: f64) -> Result<Self> {
        match text {
            "near" => Ok(Offsets::Near(h)),
            "far" => Ok(Offsets::Range(-1.0, 1.0)),
            _ => {
                let Some((low, high)) = text.split_once(':') else {
                    return wrong("expected near, far or LO:HI, such as -0.5:0.25".to_owned());
                };
                Offsets::range(number(low)?, number(high)?)
            }
        }
    }

    /// Reads `far` or `LO:HI` with LO < HI: the ends of a window.
    ///
    /// # Errors
    /// [`Error::Query`] for other text, and as [`Offsets::range`].
    pub fn parse_window(text: &str) -> Result<[f64; 2]> {
        match Offsets::parse(text, 0.0)? {
            Offsets::Range(low, high) if low < high => Ok([low, high]),
            other => wrong(format!("{other} has no width; expected far or LO:HI, such as -0.5:0.25")),
        }
    }

    /// The window as columns of a CSV file: names and values.
    pub fn columns(self) -> Vec<(&'static str, f64)> {
        match self {
            Offsets::Near(h) => vec![("h", h)],
            Offsets::Range(low, high) => vec![(WINDOW[0], low), (WINDOW[1], high)],
        }
    }

    /// The window of the model.
    pub fn window(self) -> Window {
        match self {
            Offsets::Near(h) => Window::near(h as f32),
            Offsets::Range(low, high) => Window::range(low as f32, high as f32),
        }
    }
}

fn number(text: &str) -> Result<f64> {
    text.trim().parse().or_else(|_| wrong(format!("'{text}' is not a number")))
}

impl std::fmt::Display for Offsets {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Offsets::Near(h) => write!(f, "h {h}"),
            Offsets::Range(low, high) => write!(f, "h {low} to {high}"),
        }
    }
}

impl Query {
    /// A query at one offset. The coordinates are θ_o, h, θ_i and φ.
    ///
    /// # Errors
    /// [`Error::Query`] if one of them is out of range.
    pub fn new([theta_o, h, theta_i, phi]: [f64; 4]) -> Result<Self> {
        for (value, (name, lo, hi, range)) in [theta_o, h, theta_i, phi].into_iter().zip(COORDINATES) {
            if !(lo..=hi).contains(&value) {
                return wrong(format!("{name} = {value} is out of range: {name} {range}"));
            }
        }
        Ok(Query { theta_o, offsets: Offsets::Near(h), theta_i, phi })
    }

    /// The same query with other offsets.
    #[must_use]
    pub fn over(self, offsets: Offsets) -> Self {
        Query { offsets, ..self }
    }

    /// Evaluates the model.
    pub fn ask(&self, bcsdf: &Bcsdf) -> Answer {
        let hit = bcsdf.at(direction(self.theta_o, 0.0), self.offsets.window());
        let (lobes, pdf) = hit.eval_pdf(direction(self.theta_i, self.phi));
        Answer { lobes, pdf }
    }

    /// The query as columns of a CSV file: names and values.
    pub fn columns(&self) -> Vec<(&'static str, f64)> {
        let mut all = vec![("theta_o", self.theta_o)];
        all.extend(self.offsets.columns());
        all.extend([("theta_i", self.theta_i), ("phi", self.phi)]);
        all
    }
}

/// The longest line of a file of queries.
const MAX_LINE_BYTES: usize = 1 << 20;

/// Queries in a CSV file, one after the other. The header has theta_o, theta_i, phi, and either h or both h_lo and
/// h_hi, in any order. Lines that start with `#` are comments.
pub struct Queries<R> {
    records: csv::StringRecordsIntoIter<BoundedLines<R>>,
    names: Vec<&'static str>,
    columns: Vec<usize>,
}

impl<R: std::io::Read> Queries<R> {
    /// Reads the header.
    ///
    /// # Errors
    /// [`Error::Query`] or [`Error::Csv`] names the problem.
    pub fn new(reader: R) -> Result<Self> {
        let mut builder = csv::ReaderBuilder::new();
        builder.trim(csv::Trim::All).comment(Some(b'#'));
        let mut csv = builder.from_reader(BoundedLines::new(reader, MAX_LINE_BYTES));
        let (names, columns) = columns(csv.headers()?)?;
        Ok(Queries { records: csv.into_records(), names, columns })
    }

    fn query(&self, record: &csv::StringRecord) -> Result<Query> {
        let mut values = Vec::new();
        for (column, name) in self.columns.iter().zip(&self.names) {
            let cell = record.get(*column).unwrap_or("");
            let wrong_cell = |_| wrong(format!("{name} = '{}' is not a number", shown(cell)));
            values.push(cell.parse::<f64>().or_else(wrong_cell)?);
        }
        match values[..] {
            [theta_o, low, high, theta_i, phi] => {
                let offsets = Offsets::range(low, high)?;
                Ok(Query::new([theta_o, 0.0, theta_i, phi])?.over(offsets))
            }
            _ => Query::new([values[0], values[1], values[2], values[3]]),
        }
    }
}

impl<R: std::io::Read> Iterator for Queries<R> {
    type Item = Result<Query>;

    /// The next query.
    ///
    /// # Errors
    /// [`Error::Query`] or [`Error::Csv`] names the line and the problem.
    fn next(&mut self) -> Option<Result<Query>> {
        let record = match self.records.next()? {
            Ok(record) => record,
            Err(error) => return Some(Err(error.into())),
        };
        let line = record.position().map_or(0, csv::Position::line);
        Some(self.query(&record).map_err(|error| Error::Query(format!("line {line}: {error}"))))
    }
}

/// The names of the coordinates in a header, and their columns.
fn columns(header: &csv::StringRecord) -> Result<(Vec<&'static str>, Vec<usize>)> {
    let known = "theta_o, h, theta_i, phi; or h_lo, h_hi in place of h";
    let position = |name: &str| header.iter().position(|h| h == name);
    let has_window = WINDOW.iter().any(|name| position(name).is_some());
    if has_window && position("h").is_some() {
        return wrong(format!("line 1: both h and h_lo or h_hi in the header ({known})"));
    }
    let names = if has_window {
        ["theta_o", "h_lo", "h_hi", "theta_i", "phi"].to_vec()
    } else {
        COORDINATES.map(|c| c.0).to_vec()
    };
    let mut columns = Vec::new();
    for name in &names {
        match position(name) {
            Some(column) => columns.push(column),
            None => return wrong(format!("line 1: no column '{name}' in the header (needed: {known})")),
        }
    }
    if let Some(unknown) = header.iter().find(|h| !names.contains(h)) {
        return wrong(format!("line 1: unknown column '{}' (known: {known})", shown(unknown)));
    }
    Ok((names, columns))
}

/// A cell in a message. A cell may be as long as a line.
fn shown(cell: &str) -> String {
    vellus_io::excerpt(cell.as_bytes(), 40)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_csv(text: &[u8]) -> Result<Vec<Query>> {
        Queries::new(text)?.collect()
    }

    #[test]
    fn columns_have_any_order() {
        let text = "# a comment\nphi, h, theta_i, theta_o\n180, 0.1, -10, 10\n";
        let expected = Query { theta_o: 10.0, offsets: Offsets::Near(0.1), theta_i: -10.0, phi: 180.0 };
        assert_eq!(read_csv(text.as_bytes()).unwrap(), [expected]);
        let text = "h_hi,h_lo,theta_o,theta_i,phi\n1,-1,10,-10,180\n";
        assert_eq!(read_csv(text.as_bytes()).unwrap(), [expected.over(Offsets::parse("far", 0.0).unwrap())]);
    }

    #[test]
    fn errors_name_the_line_and_the_range() {
        for (text, part) in [
            ("theta_o,h,theta_i,phi\n0,0,0,0\n0,0,x,0\n", "line 3: theta_i = 'x' is not a number"),
            ("theta_o,h,theta_i,phi\n0,2,0,0\n", "line 2: h = 2 is out of range: h must be in [-1, 1]"),
            ("theta_o,h_lo,h_hi,theta_i,phi\n0,1,0,0,0\n", "line 2: h_lo = 1 is above h_hi = 0"),
            ("theta_o,h,h_lo,theta_i,phi\n", "line 1: both h and h_lo"),
            ("theta_o,h,theta_i\n", "line 1: no column 'phi'"),
            ("theta_o,h,theta_i,phi,x\n", "line 1: unknown column 'x'"),
        ] {
            let error = read_csv(text.as_bytes()).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
    }

    #[test]
    fn errors_quote_a_part_of_a_long_cell() {
        let cell = "\0".repeat(100_000);
        for text in [format!("theta_o,h,theta_i,phi\n0,0,0,{cell}\n"), format!("theta_o,h,theta_i,phi,{cell}\n")] {
            let error = read_csv(text.as_bytes()).unwrap_err().to_string();
            assert!(error.chars().count() < 200 && error.contains('…'), "{} bytes", error.len());
        }
    }
}
