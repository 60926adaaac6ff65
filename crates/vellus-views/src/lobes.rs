//! The light that leaves a fibre, by direction.

use crate::request::Request;
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};
use vellus::{Lobes, direction};

/// The fewest azimuths of an integral over φ: the tables of the medulla are smooth over 2°.
const AZIMUTHS: f64 = 180.0;

/// Six lists of RGB values, one for each lobe, from values of all lobes.
pub fn by_lobe(values: &[Lobes]) -> Vec<Vec<[f32; 3]>> {
    (0..6).map(|lobe| values.iter().map(|value| value.0[lobe]).collect()).collect()
}

/// The answer to `polar`: N(φ) of each lobe, per radian, at even azimuths from 0°.
pub fn polar(request: &Request) -> Result<Value, String> {
    let (bcsdf, wo, window) = (request.bcsdf()?, request.wo()?, request.window()?);
    let samples = request.count("samples", 360, [8, 720])?;
    let phi: Vec<f64> = (0..samples).map(|i| 360.0 * f64::from(i) / f64::from(samples)).collect();
    let values: Vec<Lobes> = bcsdf.with_hit(wo, window, |hit| {
        // The model's azimuths lie in (−π, π].
        let wrapped = |phi: f64| if phi > 180.0 { phi - 360.0 } else { phi };
        phi.iter().map(|&phi| hit.azimuthal(wrapped(phi).to_radians() as f32)).collect()
    });
    Ok(json!({ "phi": phi, "lobes": by_lobe(&values) }))
}

/// The answer to `longitudinal`: f cos θᵢ integrated over all azimuths, per radian of θᵢ, at even inclinations.
///
/// The solid angle is cos θᵢ dθᵢ dφ, so that the integral over θᵢ is the energy of the lobe.
pub fn longitudinal(request: &Request) -> Result<Value, String> {
    let (bcsdf, wo, window) = (request.bcsdf()?, request.wo()?, request.window()?);
    let samples = request.count("samples", 181, [8, 720])?;
    // At one azimuth in a standard deviation, the sum of a Gaussian has the relative error 2 exp(−2π²) = 5e-9.
    let beta_n = f64::from(bcsdf.fiber().in_air().beta_n);
    let azimuths = (TAU / beta_n).max(AZIMUTHS).ceil() as u32;
    let theta: Vec<f64> = (0..samples).map(|i| ((f64::from(i) + 0.5) / f64::from(samples) - 0.5) * 180.0).collect();
    let values: Vec<Lobes> = bcsdf.with_hit(wo, window, |hit| {
        let at = |theta: f64| {
            let mut sum = Lobes::default();
            let weight = (theta.cos() * TAU / f64::from(azimuths)) as f32;
            for i in 0..azimuths {
                let phi = TAU * (f64::from(i) + 0.5) / f64::from(azimuths) - PI;
                let value = hit.eval(direction(theta, phi));
                for (sum, value) in sum.0.iter_mut().flatten().zip(value.0.iter().flatten()) {
                    *sum += value * weight;
                }
            }
            sum
        };
        theta.iter().map(|theta| at(theta.to_radians())).collect()
    });
    Ok(json!({ "theta_i": theta, "lobes": by_lobe(&values) }))
}

/// The answer to `profile`: f cos θᵢ of all lobes at the middles of cells, row by row from θᵢ = −90°, φ from 0°.
pub fn profile(request: &Request) -> Result<Value, String> {
    let (bcsdf, wo, window) = (request.bcsdf()?, request.wo()?, request.window()?);
    let rows = request.count("rows", 45, [2, 180])?;
    let columns = request.count("columns", 90, [2, 360])?;
    let values: Vec<[f32; 3]> = bcsdf.with_hit(wo, window, |hit| {
        let cells = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
        cells
            .map(|(row, column)| {
                let theta = ((f64::from(row) + 0.5) / f64::from(rows) - 0.5) * PI;
                let phi = (f64::from(column) + 0.5) / f64::from(columns) * TAU;
                hit.eval(direction(theta, phi)).total()
            })
            .collect()
    });
    Ok(json!({ "rows": rows, "columns": columns, "values": values }))
}
