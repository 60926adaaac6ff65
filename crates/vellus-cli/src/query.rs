//! One query of the model, from flags or from a line of CSV.

use anyhow::{Context, Result, bail};
use glam::Vec3;
use vellus::{Bcsdf, Lobes, Window};

/// θ_o, h, θ_i, φ; angles in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Query {
    pub theta_o: f64,
    pub h: f64,
    pub theta_i: f64,
    pub phi: f64,
}

/// What the model says.
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
    /// Checks the ranges.
    pub fn new([theta_o, h, theta_i, phi]: [f64; 4]) -> Result<Self> {
        for (value, (name, lo, hi, range)) in [theta_o, h, theta_i, phi].into_iter().zip(COORDINATES) {
            if !(lo..=hi).contains(&value) {
                bail!("{name} = {value} is out of range: {name} {range}");
            }
        }
        Ok(Query { theta_o, h, theta_i, phi })
    }

    /// Evaluates it.
    pub fn ask(&self, bcsdf: &Bcsdf) -> Answer {
        let hit = bcsdf.at(direction(self.theta_o, 0.0), Window::near(self.h as f32));
        let (lobes, pdf) = hit.eval_pdf(direction(self.theta_i, self.phi));
        Answer { lobes, pdf }
    }
}

/// Unit vector at θ and φ in degrees.
pub fn direction(theta: f64, phi: f64) -> Vec3 {
    let ((st, ct), (sp, cp)) = (theta.to_radians().sin_cos(), phi.to_radians().sin_cos());
    Vec3::new(st as f32, (ct * cp) as f32, (ct * sp) as f32)
}

/// Reads queries from CSV with a header naming theta_o, h, theta_i, phi in any order. Errors name the line.
pub fn read_csv(reader: impl std::io::Read) -> Result<Vec<Query>> {
    let mut csv = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(reader);
    let header = csv.headers().context("line 1")?.clone();
    let mut columns = [0; 4];
    for (column, (name, ..)) in columns.iter_mut().zip(COORDINATES) {
        match header.iter().position(|h| h == name) {
            Some(position) => *column = position,
            None => {
                bail!("line 1: no column '{name}' in the header (needed: theta_o, h, theta_i, phi)")
            }
        }
    }
    if let Some(unknown) = header.iter().find(|h| COORDINATES.iter().all(|(name, ..)| name != h)) {
        bail!("line 1: unknown column '{unknown}' (known: theta_o, h, theta_i, phi)");
    }
    let mut queries = Vec::new();
    for record in csv.records() {
        let record = record?;
        let line = record.position().map_or(0, csv::Position::line);
        let mut values = [0.0; 4];
        for ((value, column), (name, ..)) in values.iter_mut().zip(columns).zip(COORDINATES) {
            let cell = record.get(column).unwrap_or("");
            *value = cell.parse().with_context(|| format!("line {line}: {name} = '{cell}' is not a number"))?;
        }
        queries.push(Query::new(values).with_context(|| format!("line {line}"))?);
    }
    if queries.is_empty() {
        bail!("no queries after the header");
    }
    Ok(queries)
}
