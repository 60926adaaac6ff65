//! Answers to queries of the model.

use super::{Format, align, header, number, row};
use crate::query::{Answer, Query};
use serde_json::{Map, Value, json};
use vellus::Lobe;

/// Queries and their answers. All queries must have the same columns, see [`Query::columns`].
pub fn eval(answers: &[(Query, Answer)], format: Format) -> String {
    match format {
        Format::Table => answers.iter().map(|(q, a)| table(q, a)).collect::<Vec<_>>().join("\n"),
        Format::Csv => csv(answers),
        Format::Jsonl => answers.iter().map(|(q, a)| format!("{}\n", object(q, a))).collect(),
        Format::Json => format!("{}\n", Value::Array(answers.iter().map(|(q, a)| object(q, a)).collect())),
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

fn csv(answers: &[(Query, Answer)]) -> String {
    let names = answers.first().map(|(q, _)| q.columns()).unwrap_or_default();
    let mut header: Vec<String> = names.into_iter().map(|(name, _)| name.to_owned()).collect();
    for key in Lobe::ALL.map(Lobe::key).into_iter().chain(["total"]) {
        header.extend(["r", "g", "b"].map(|c| format!("{key}.{c}")));
    }
    header.push("pdf".to_owned());
    let mut text = header.join(",") + "\n";
    for (q, a) in answers {
        let mut row: Vec<String> = q.columns().into_iter().map(|(_, value)| value.to_string()).collect();
        row.extend(lobes(a).flat_map(|(_, rgb)| rgb.map(|x| x.to_string())));
        row.push(a.pdf.to_string());
        text += &(row.join(",") + "\n");
    }
    text
}
