//! `vellus eval`: f·cos θ_i of each lobe, and the sampling density.

use crate::fiber_args::FiberArgs;
use crate::output::{self, Format};
use crate::query::{Answer, Offsets, Query, WindowArgs, read_csv};
use anyhow::{Context, Result};
use serde_json::{Map, Value, json};
use std::path::PathBuf;
use vellus::{Bcsdf, Lobe};

/// The options of `vellus eval`.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    fiber: FiberArgs,
    /// Inclination of ω_o (toward the camera), degrees from the normal plane.
    #[arg(long, default_value_t = 20.0, allow_negative_numbers = true, value_name = "DEG")]
    theta_o: f64,
    /// Offset of the hit over the width of the fibre, in [-1, 1].
    #[arg(long, default_value_t = 0.3, allow_negative_numbers = true)]
    h: f64,
    #[command(flatten)]
    window: WindowArgs,
    /// Inclination of ω_i (toward the light), degrees.
    #[arg(long, default_value_t = -15.0, allow_negative_numbers = true, value_name = "DEG")]
    theta_i: f64,
    /// Azimuth of ω_i from ω_o, degrees.
    #[arg(long, default_value_t = 150.0, allow_negative_numbers = true, value_name = "DEG")]
    phi: f64,
    /// CSV of queries with a header theta_o,h,theta_i,phi (degrees), or with h_lo,h_hi in place of h for a window; or
    /// - for standard input.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["theta_o", "h", "window", "theta_i", "phi"])]
    queries: Option<PathBuf>,
    #[command(flatten)]
    output: output::OutputArgs,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<()> {
    let fiber = args.fiber.load()?;
    args.output.check()?;
    let bcsdf = Bcsdf::new(&fiber)?;
    let queries = match &args.queries {
        None => {
            let offsets = Offsets::parse(&args.window.window, args.h)?;
            vec![Query::new([args.theta_o, args.h, args.theta_i, args.phi])?.over(offsets)]
        }
        Some(path) if path.as_os_str() == "-" => read_csv(std::io::stdin().lock()).context("standard input")?,
        Some(path) => {
            let place = || format!("{}", path.display());
            read_csv(vellus_io::open(path).with_context(place)?).with_context(place)?
        }
    };
    let answers: Vec<(Query, Answer)> = queries.into_iter().map(|q| (q, q.ask(&bcsdf))).collect();
    let text = match args.output.format {
        Format::Table => answers.iter().map(|(q, a)| table(q, a)).collect::<Vec<_>>().join("\n"),
        Format::Csv => csv(&answers)?,
        Format::Jsonl => answers.iter().map(|(q, a)| format!("{}\n", object(q, a))).collect(),
        Format::Json => format!("{}\n", Value::Array(answers.iter().map(|(q, a)| object(q, a)).collect())),
    };
    args.output.write(text.as_bytes())
}

/// A query and its answer as a table.
pub fn table(query: &Query, answer: &Answer) -> String {
    let mut rows = vec![["f·cos θ_i", "red", "green", "blue"].map(str::to_owned).to_vec()];
    let row = |name: &str, rgb: [f32; 3]| {
        [name.to_owned()].into_iter().chain(rgb.map(|x| output::number(x.into()))).collect::<Vec<_>>()
    };
    rows.extend(Lobe::ALL.iter().map(|&lobe| row(lobe.key(), answer.lobes.0[lobe as usize])));
    rows.push(row("total", answer.lobes.total()));
    format!(
        "θ_o {}°, {}, θ_i {}°, φ {}°: pdf {} per steradian\n{}",
        query.theta_o,
        query.offsets,
        query.theta_i,
        query.phi,
        output::number(answer.pdf.into()),
        output::align(&rows)
    )
}

/// The f64 that prints as the f32 does.
fn plain(x: f32) -> Value {
    x.to_string().parse::<f64>().map_or(Value::Null, Value::from)
}

/// The names and values of the coordinates of a query, as in files.
fn coordinates(query: &Query) -> Vec<(&'static str, f64)> {
    let mut all = vec![("theta_o", query.theta_o)];
    all.extend(query.offsets.columns());
    all.extend([("theta_i", query.theta_i), ("phi", query.phi)]);
    all
}

fn object(query: &Query, answer: &Answer) -> Value {
    let mut object = Map::new();
    for (name, value) in coordinates(query) {
        object.insert(name.to_owned(), json!(value));
    }
    let rgb = |c: [f32; 3]| Value::Array(c.map(plain).to_vec());
    for lobe in Lobe::ALL {
        object.insert(lobe.key().to_owned(), rgb(answer.lobes.0[lobe as usize]));
    }
    object.insert("total".to_owned(), rgb(answer.lobes.total()));
    object.insert("pdf".to_owned(), plain(answer.pdf));
    Value::Object(object)
}

fn csv(answers: &[(Query, Answer)]) -> Result<String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    // All queries have the same coordinates: they come from one header or from one set of flags.
    let names = answers.first().map(|(q, _)| coordinates(q)).unwrap_or_default();
    let mut header: Vec<String> = names.into_iter().map(|(name, _)| name.to_owned()).collect();
    for key in Lobe::ALL.map(Lobe::key).into_iter().chain(["total"]) {
        header.extend(["r", "g", "b"].map(|c| format!("{key}.{c}")));
    }
    header.push("pdf".to_owned());
    writer.write_record(&header)?;
    for (q, a) in answers {
        let mut row: Vec<String> = coordinates(q).into_iter().map(|(_, value)| value.to_string()).collect();
        row.extend(a.lobes.0.iter().chain([&a.lobes.total()]).flatten().map(f32::to_string));
        row.push(a.pdf.to_string());
        writer.write_record(&row)?;
    }
    Ok(String::from_utf8(writer.into_inner()?)?)
}
