//! Energies of the lobes: in closed form, and integrated.

use super::{Format, align, header, row};
use crate::query::Query;
use rayon::prelude::*;
use serde_json::{Map, Value, json};
use vellus::{Bcsdf, Fiber, Hit, Lobe};
use vellus_fit::Absorption;
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

/// Energies of the six lobes of one hit in one of any number of channels.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelEnergy {
    /// The channel and its absorption.
    pub absorption: Absorption,
    /// Energies in closed form, and their sum.
    pub closed_form: [f64; 7],
    /// Energies as integrals of f·cos θ_i over the sphere, and their sum.
    pub integral: [f64; 7],
}

impl ChannelEnergy {
    /// Computes the energies of `fiber` with each of the absorptions, for ω_o and the offsets of `query`.
    ///
    /// # Errors
    /// [`vellus::Error`] if a parameter is out of range.
    pub fn all(fiber: &Fiber, absorptions: &[Absorption], query: &Query) -> Result<Vec<Self>, vellus::Error> {
        let of = |absorption: &Absorption| {
            let energy = Energy::new(&absorption.apply(fiber), query)?;
            let with_sum =
                |lobes: &[[f64; 3]; 6], sum: f64| std::array::from_fn(|i| lobes.get(i).map_or(sum, |lobe| lobe[0]));
            let closed_form = with_sum(&energy.closed_form, energy.closed_form_total[0]);
            let integral = with_sum(&energy.integral, energy.integral.iter().map(|lobe| lobe[0]).sum());
            Ok(ChannelEnergy { absorption: absorption.clone(), closed_form, integral })
        };
        absorptions.iter().map(of).collect()
    }
}

/// The energies of the lobes and their sums, with a row for each channel. A table only has the sum of the integrals.
pub fn channel_energies(query: &Query, channels: &[ChannelEnergy], format: Format) -> String {
    let keys: Vec<&str> = Lobe::ALL.iter().map(|lobe| lobe.key()).chain(["total"]).collect();
    let numbers = |a: &Absorption| [a.sigma_ca, a.sigma_ma].map(f64::from);
    match format {
        Format::Table => {
            let mut head = header(["channel", "sigma_ca", "sigma_ma"]);
            head.extend(keys.iter().map(|key| format!("A {key}")).chain(["∫ total".to_owned()]));
            let line = |c: &ChannelEnergy| {
                let values = c.closed_form.iter().chain(&c.integral[6..]).copied();
                row(c.absorption.channel.clone(), numbers(&c.absorption).into_iter().chain(values))
            };
            let rows: Vec<Vec<String>> = std::iter::once(head).chain(channels.iter().map(line)).collect();
            titled(query, &rows)
        }
        Format::Csv => {
            let columns = |what: &str| keys.iter().map(|key| format!(",{what}.{key}")).collect::<String>();
            let mut text = format!("channel,sigma_ca,sigma_ma{}{}\n", columns("A"), columns("integral"));
            for ChannelEnergy { absorption: a, closed_form, integral } in channels {
                let values: Vec<String> = closed_form.iter().chain(integral).map(f64::to_string).collect();
                text += &format!("{},{},{},{}\n", a.channel, a.sigma_ca, a.sigma_ma, values.join(","));
            }
            text
        }
        Format::Json | Format::Jsonl => {
            let channel = |ChannelEnergy { absorption: a, closed_form, integral }: &ChannelEnergy| {
                let lobe = |(i, key): (usize, &&str)| {
                    ((*key).to_owned(), json!({"closed_form": closed_form[i], "integral": integral[i]}))
                };
                let lobes: Map<_, _> = keys.iter().enumerate().map(lobe).collect();
                json!({"channel": a.channel, "sigma_ca": a.sigma_ca, "sigma_ma": a.sigma_ma, "lobes": lobes})
            };
            let mut object = place(query);
            object.insert("channels".to_owned(), channels.iter().map(channel).collect());
            format!("{}\n", Value::Object(object))
        }
    }
}

/// The rows of a table below its title.
fn titled(query: &Query, rows: &[Vec<String>]) -> String {
    let Query { theta_o, offsets, .. } = query;
    let what = "energy in closed form (A) and integral of f·cos θ_i over the sphere (∫)";
    format!("θ_o {theta_o}°, {offsets}: {what}\n{}", align(rows))
}

/// The inclination and the offsets of a query.
fn place(query: &Query) -> Map<String, Value> {
    let mut object = Map::from_iter([("theta_o".to_owned(), json!(query.theta_o))]);
    object.extend(query.offsets.columns().into_iter().map(|(name, value)| (name.to_owned(), json!(value))));
    object
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
            titled(query, &rows)
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
            let mut object = place(query);
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
