//! `vellus energy`: the energy of each lobe, in closed form and as an integral.

use crate::fiber_args::Incidence;
use crate::output::{self, Format};
use crate::query::{Offsets, Query, WindowArgs};
use anyhow::Result;
use rayon::prelude::*;
use serde_json::json;
use vellus::{Bcsdf, Fiber, Hit, Lobe};
use vellus_models::direction;

/// The options of `vellus energy`.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    incidence: Incidence,
    /// Offset of the hit over the width of the fibre, in [-1, 1].
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    h: f64,
    #[command(flatten)]
    window: WindowArgs,
    #[command(flatten)]
    output: output::OutputArgs,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<()> {
    let fiber = args.incidence.fiber.load()?;
    let offsets = Offsets::parse(&args.window.window, args.h)?;
    let query = Query::new([args.incidence.theta_o, args.h, 0.0, 0.0])?.over(offsets);
    args.output.check()?;
    let bcsdf = Bcsdf::new(&fiber)?;
    let hit = bcsdf.at(direction(query.theta_o, 0.0), offsets.window());
    let closed = hit.energy();
    let integral = integrate(&hit, &fiber);
    let closed_total = closed.total().map(f64::from);
    let integral_total = [0, 1, 2].map(|c| integral.iter().map(|lobe| lobe[c]).sum::<f64>());
    let lines: Vec<(&str, [f64; 3], [f64; 3])> = Lobe::ALL
        .iter()
        .map(|&lobe| (lobe.key(), closed.0[lobe as usize].map(f64::from), integral[lobe as usize]))
        .chain([("total", closed_total, integral_total)])
        .collect();
    let text = match args.output.format {
        Format::Table => {
            let header = ["", "A red", "green", "blue", "∫ red", "green", "blue"];
            let mut rows = vec![header.map(str::to_owned).to_vec()];
            for (key, a, b) in &lines {
                rows.push(
                    [(*key).to_owned()].into_iter().chain(a.iter().chain(b).map(|&x| output::number(x))).collect(),
                );
            }
            format!(
                "θ_o {}°, {}: energy in closed form (A) and integral of f·cos θ_i over the sphere (∫)\n{}",
                query.theta_o,
                query.offsets,
                output::align(&rows)
            )
        }
        Format::Csv => {
            let mut text = "lobe,A.r,A.g,A.b,integral.r,integral.g,integral.b\n".to_owned();
            for (key, a, b) in &lines {
                let values: Vec<String> = a.iter().chain(b).map(f64::to_string).collect();
                text += &format!("{key},{}\n", values.join(","));
            }
            text
        }
        Format::Json | Format::Jsonl => {
            let lobes: serde_json::Map<_, _> =
                lines.iter().map(|(key, a, b)| ((*key).to_owned(), json!({"closed_form": a, "integral": b}))).collect();
            let mut object = serde_json::Map::from_iter([("theta_o".to_owned(), json!(query.theta_o))]);
            object.extend(offsets.columns().into_iter().map(|(name, value)| (name.to_owned(), json!(value))));
            object.insert("lobes".to_owned(), lobes.into());
            format!("{}\n", serde_json::Value::Object(object))
        }
    };
    args.output.write(text.as_bytes())
}

/// Integral of each lobe of `eval` over the sphere: midpoints, three a standard deviation of the narrowest
/// lobe in each angle, with which the error of a Gaussian is below 1e-15 and that of the tables, of
/// half a degree resolution, below 1e-4.
pub fn integrate(hit: &Hit, fiber: &Fiber) -> [[f64; 3]; 6] {
    let steps = |range: f64, width: f32| ((3.0 * range / f64::from(width)).ceil() as usize).clamp(720, 12_000);
    let n_theta = steps(180.0, 0.5 * fiber.beta_m.to_degrees());
    let n_phi = steps(360.0, fiber.beta_n.to_degrees());
    // Rows are added up in their order: the result does not depend on the number of threads.
    let rows: Vec<[[f64; 3]; 6]> = (0..n_theta)
        .into_par_iter()
        .map(|i| {
            let theta = ((i as f64 + 0.5) / n_theta as f64 - 0.5) * 180.0;
            let mut row = [[0.0; 3]; 6];
            for j in 0..n_phi {
                let lobes = hit.eval(direction(theta, (j as f64 + 0.5) / n_phi as f64 * 360.0));
                for (sum, value) in row.iter_mut().flatten().zip(lobes.0.iter().flatten()) {
                    *sum += f64::from(*value);
                }
            }
            let weight =
                theta.to_radians().cos() * std::f64::consts::PI / n_theta as f64 * std::f64::consts::TAU / n_phi as f64;
            row.map(|lobe| lobe.map(|x| x * weight))
        })
        .collect();
    let mut total = [[0.0; 3]; 6];
    for row in rows {
        for (sum, value) in total.iter_mut().flatten().zip(row.iter().flatten()) {
            *sum += value;
        }
    }
    total
}
