//! Energies of the lobes: in closed form, and integrated.

use super::{Format, align, header, row};
use crate::query::Query;
use rayon::prelude::*;
use serde_json::{Map, Value, json};
use vellus::{Bcsdf, Fiber, Hit, Lobe};
use vellus_models::direction;

/// Energies of the six lobes of one hit, RGB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Energy {
    /// Energies in closed form.
    pub closed_form: [[f64; 3]; 6],
    /// The sum of the energies in closed form.
    pub closed_form_total: [f64; 3],
    /// Energies as integrals of f·cos θ_i over the sphere.
    pub integral: [[f64; 3]; 6],
}

impl Energy {
    /// Computes the energies of `fiber` for ω_o and the offsets of `query`.
    ///
    /// # Errors
    /// [`vellus::Error`] if a parameter is out of range.
    pub fn new(fiber: &Fiber, query: &Query) -> Result<Self, vellus::Error> {
        let bcsdf = Bcsdf::new(fiber)?;
        let hit = bcsdf.at(direction(query.theta_o, 0.0), query.offsets.window());
        let closed = hit.energy();
        Ok(Energy {
            closed_form: closed.0.map(|rgb| rgb.map(f64::from)),
            closed_form_total: closed.total().map(f64::from),
            integral: integrate(&hit, fiber),
        })
    }
}

/// The energies of the lobes and their sums.
pub fn energy(query: &Query, energy: &Energy, format: Format) -> String {
    let integral_total = [0, 1, 2].map(|c| energy.integral.iter().map(|lobe| lobe[c]).sum::<f64>());
    let lines: Vec<(&str, [f64; 3], [f64; 3])> = Lobe::ALL
        .iter()
        .map(|&lobe| (lobe.key(), energy.closed_form[lobe as usize], energy.integral[lobe as usize]))
        .chain([("total", energy.closed_form_total, integral_total)])
        .collect();
    match format {
        Format::Table => {
            let mut rows = vec![header(["", "A red", "green", "blue", "∫ red", "green", "blue"])];
            rows.extend(lines.iter().map(|(key, a, b)| row(*key, a.iter().chain(b).copied())));
            format!(
                "θ_o {}°, {}: energy in closed form (A) and integral of f·cos θ_i over the sphere (∫)\n{}",
                query.theta_o,
                query.offsets,
                align(&rows)
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
            let lobes: Map<_, _> =
                lines.iter().map(|(key, a, b)| ((*key).to_owned(), json!({"closed_form": a, "integral": b}))).collect();
            let mut object = Map::from_iter([("theta_o".to_owned(), json!(query.theta_o))]);
            object.extend(query.offsets.columns().into_iter().map(|(name, value)| (name.to_owned(), json!(value))));
            object.insert("lobes".to_owned(), lobes.into());
            format!("{}\n", Value::Object(object))
        }
    }
}

/// The integral of each lobe of `eval` over the sphere, by the midpoint rule. Each standard deviation of the narrowest
/// lobe has three points in each angle. The error of a Gaussian is then below 1e-15. That of the tables, which have a
/// resolution of half a degree, is below 1e-4.
fn integrate(hit: &Hit, fiber: &Fiber) -> [[f64; 3]; 6] {
    let steps = |range: f64, width: f32| ((3.0 * range / f64::from(width)).ceil() as usize).clamp(720, 12_000);
    let n_theta = steps(180.0, 0.5 * fiber.beta_m.to_degrees());
    let n_phi = steps(360.0, fiber.beta_n.to_degrees());
    // Rows are added in order, so the result does not depend on the number of threads.
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
