//! One query of the model, from flags or from a line of CSV.

use anyhow::{Context, Result, bail};
use vellus::{Bcsdf, Lobes, Window};
use vellus_models::direction;

/// θ_o, offsets, θ_i, φ; angles in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Query {
    pub theta_o: f64,
    pub offsets: Offsets,
    pub theta_i: f64,
    pub phi: f64,
}

/// Where the fibre is hit: at one offset, or averaged from one to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Offsets {
    Near(f64),
    Range(f64, f64),
}

/// The columns of a window in CSV files. They replace h.
const WINDOW: [&str; 2] = ["h_lo", "h_hi"];

/// The option `--window`.
#[derive(clap::Args, Clone)]
pub struct WindowArgs {
    /// The offsets that the hit is averaged over: near (only the offset h), far (the whole width) or LO:HI, both in [-1, 1].
    #[arg(long, default_value = "near", allow_hyphen_values = true, value_name = "near|far|LO:HI")]
    pub window: String,
}

impl Offsets {
    /// A window from `low` to `high`, both in [−1, 1].
    pub fn range(low: f64, high: f64) -> Result<Self> {
        for (name, value) in WINDOW.into_iter().zip([low, high]) {
            if !(-1.0..=1.0).contains(&value) {
                bail!("{name} = {value} is out of range: {name} must be in [-1, 1]");
            }
        }
        if low > high {
            bail!("h_lo = {low} is above h_hi = {high}");
        }
        Ok(Offsets::Range(low, high))
    }

    /// `near`, which takes the offset `h`, `far` or LO:HI.
    pub fn parse(text: &str, h: f64) -> Result<Self> {
        match text {
            "near" => Ok(Offsets::Near(h)),
            "far" => Ok(Offsets::Range(-1.0, 1.0)),
            _ => {
                let Some((low, high)) = text.split_once(':') else {
                    bail!("--window {text}: expected near, far or LO:HI, such as -0.5:0.25");
                };
                let number = |x: &str| -> Result<f64> {
                    x.trim().parse().with_context(|| format!("--window {text}: '{x}' is not a number"))
                };
                Offsets::range(number(low)?, number(high)?).with_context(|| format!("--window {text}"))
            }
        }
    }

    /// The names and values of the columns in files.
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

impl std::fmt::Display for Offsets {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Offsets::Near(h) => write!(f, "h {h}"),
            Offsets::Range(low, high) => write!(f, "h {low} to {high}"),
        }
    }
}

/// The answer to a query.
pub struct Answer {
    pub lobes: Lobes,
    pub pdf: f32,
}

/// Names of the four coordinates, their limits, and the limits in words.
const COORDINATES: [(&str, f64, f64, &str); 4] = [
    ("theta_o", -90.0, 90.0, "must be in [-90, 90] degrees"),
    ("h", -1.0, 1.0, "must be in [-1, 1]"),
    ("theta_i", -90.0, 90.0, "must be in [-90, 90] degrees"),
    ("phi", -360.0, 360.0, "must be in [-360, 360] degrees"),
];

impl Query {
    /// A query in the near field. The coordinates are θ_o, h, θ_i and φ.
    pub fn new([theta_o, h, theta_i, phi]: [f64; 4]) -> Result<Self> {
        for (value, (name, lo, hi, range)) in [theta_o, h, theta_i, phi].into_iter().zip(COORDINATES) {
            if !(lo..=hi).contains(&value) {
                bail!("{name} = {value} is out of range: {name} {range}");
            }
        }
        Ok(Query { theta_o, offsets: Offsets::Near(h), theta_i, phi })
    }

    /// The same query over other offsets.
    pub fn over(self, offsets: Offsets) -> Self {
        Query { offsets, ..self }
    }

    /// Evaluates the model.
    pub fn ask(&self, bcsdf: &Bcsdf) -> Answer {
        let hit = bcsdf.at(direction(self.theta_o, 0.0), self.offsets.window());
        let (lobes, pdf) = hit.eval_pdf(direction(self.theta_i, self.phi));
        Answer { lobes, pdf }
    }
}

/// Reads queries from CSV with a header naming theta_o, theta_i, phi, and either h or both h_lo and h_hi, in any
/// order. Errors name the line.
pub fn read_csv(reader: impl std::io::Read) -> Result<Vec<Query>> {
    let mut csv = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(reader);
    let header = csv.headers().context("line 1")?.clone();
    let known = "theta_o, h, theta_i, phi; or h_lo, h_hi in place of h";
    let has = |name: &str| header.iter().position(|h| h == name);
    let windows = WINDOW.iter().any(|name| has(name).is_some());
    if windows && has("h").is_some() {
        bail!("line 1: both h and h_lo or h_hi in the header ({known})");
    }
    let names = if windows {
        ["theta_o", "h_lo", "h_hi", "theta_i", "phi"].to_vec()
    } else {
        COORDINATES.map(|c| c.0).to_vec()
    };
    let columns = names
        .iter()
        .map(|name| has(name).with_context(|| format!("line 1: no column '{name}' in the header (needed: {known})")))
        .collect::<Result<Vec<_>>>()?;
    if let Some(unknown) = header.iter().find(|h| !names.contains(h)) {
        bail!("line 1: unknown column '{unknown}' (known: {known})");
    }
    let mut queries = Vec::new();
    for record in csv.records() {
        let record = record?;
        let line = record.position().map_or(0, csv::Position::line);
        let mut values = Vec::new();
        for (column, name) in columns.iter().zip(&names) {
            let cell = record.get(*column).unwrap_or("");
            values.push(cell.parse().with_context(|| format!("line {line}: {name} = '{cell}' is not a number"))?);
        }
        let query = match values[..] {
            [theta_o, low, high, theta_i, phi] => Offsets::range(low, high)
                .and_then(|offsets| Ok(Query::new([theta_o, 0.0, theta_i, phi])?.over(offsets))),
            _ => Query::new([values[0], values[1], values[2], values[3]]),
        };
        queries.push(query.with_context(|| format!("line {line}"))?);
    }
    if queries.is_empty() {
        bail!("no queries after the header");
    }
    Ok(queries)
}
