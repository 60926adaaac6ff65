//! The share of the light that each lobe carries.

use crate::lobes::by_lobe;
use crate::request::Request;
use serde_json::{Value, json};
use vellus::{Lobes, Window};

/// The answer to `energy`: the energy of each lobe at even offsets from −1 to 1, its mean over the width, and the total
/// of each channel. The rest up to 1 is absorbed.
pub fn energy(request: &Request) -> Result<Value, String> {
    let (bcsdf, wo) = (request.bcsdf()?, request.wo()?);
    let samples = request.count("samples", 101, [2, 401])?;
    let h: Vec<f64> = (0..samples).map(|i| 2.0 * f64::from(i) / f64::from(samples - 1) - 1.0).collect();
    let values: Vec<Lobes> = h.iter().map(|&h| bcsdf.at(wo, Window::near(h as f32)).energy()).collect();
    let mean = bcsdf.at(wo, Window::far()).energy();
    Ok(json!({ "h": h, "lobes": by_lobe(&values), "mean": mean.0, "total": mean.total() }))
}
