//! Answers to queries of the model.

use super::{Format, align, header, number, row};
use crate::query::{Answer, Query};
use serde_json::{Map, Value, json};
use std::io::{Result, Write};
use vellus::Lobe;

/// Writes queries and their answers one after the other. All queries must have the same columns, see
/// [`Query::columns`].
pub struct Answers<'a> {
    out: &'a mut dyn Write,
    format: Format,
    is_first: bool,
}

impl<'a> Answers<'a> {
    /// Begins without answers.
    pub fn new(out: &'a mut dyn Write, format: Format) -> Self {
        Answers { out, format, is_first: true }
    }

    /// Writes an answer.
    ///
    /// # Errors
    /// Those of the output.
    pub fn add(&mut self, query: &Query, answer: &Answer) -> Result<()> {
        let is_first = std::mem::replace(&mut self.is_first, false);
        match self.format {
            Format::Table => write!(self.out, "{}{}", if is_first { "" } else { "\n" }, table(query, answer)),
            Format::Csv if is_first => write!(self.out, "{}{}", header_of(query), csv(query, answer)),
            Format::Csv => write!(self.out, "{}", csv(query, answer)),
            Format::Jsonl => writeln!(self.out, "{}", object(query, answer)),
            Format::Json => write!(self.out, "{}{}", if is_first { '[' } else { ',' }, object(query, answer)),
        }
    }

    /// Ends the text.
    ///
    /// # Errors
    /// Those of the output.
    pub fn finish(self) -> Result<()> {
        match (self.format, self.is_first) {
            (Format::Json, true) => writeln!(self.out, "[]"),
            (Format::Json, false) => writeln!(self.out, "]"),
            _ => Ok(()),
        }
    }
}

/// The lobes and their sum, with names.
fn lobes(answer: &Answer) -> impl Iterator<Item = (&'static str, [f32; 3])> {
    Lobe::ALL.map(Lobe::key).into_iter().zip(answer.lobes.0).chain([("total", answer.lobes.total())])
}

fn table(query: &Query, answer: &Answer) -> String {
    let mut rows = vec![header(["f·cos θ_i", "red", "green", "blue"])];
    rows.extend(lobes(answer).map(|(name, rgb)| row(name, rgb.map(f64::from))));
    let Query { theta_o, offsets, theta_i, phi } = query;
    let pdf = number(answer.pdf.into());
    format!("θ_o {theta_o}°, {offsets}, θ_i {theta_i}°, φ {phi}°: pdf {pdf} per steradian\n{}", align(&rows))
}

/// The f64 with the same decimal digits as an f32.
fn plain(x: f32) -> Value {
    x.to_string().parse::<f64>().map_or(Value::Null, Value::from)
}

fn object(query: &Query, answer: &Answer) -> Value {
    let mut object: Map<_, _> = query.columns().into_iter().map(|(name, x)| (name.to_owned(), json!(x))).collect();
    object.extend(lobes(answer).map(|(name, rgb)| (name.to_owned(), Value::Array(rgb.map(plain).to_vec()))));
    object.insert("pdf".to_owned(), plain(answer.pdf));
    Value::Object(object)
}

fn header_of(query: &Query) -> String {
    let mut header: Vec<String> = query.columns().into_iter().map(|(name, _)| name.to_owned()).collect();
    for key in Lobe::ALL.map(Lobe::key).into_iter().chain(["total"]) {
        header.extend(["r", "g", "b"].map(|c| format!("{key}.{c}")));
    }
    header.push("pdf".to_owned());
    header.join(",") + "\n"
}

fn csv(query: &Query, answer: &Answer) -> String {
    let mut row: Vec<String> = query.columns().into_iter().map(|(_, value)| value.to_string()).collect();
    row.extend(lobes(answer).flat_map(|(_, rgb)| rgb.map(|x| x.to_string())));
    row.push(answer.pdf.to_string());
    row.join(",") + "\n"
}
