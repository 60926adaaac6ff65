//! Values of single queries, for programs in JavaScript.

use crate::request::Request;
use serde::Deserialize;
use serde_json::{Value, json};
use vellus::Window;
use vellus::glam::Vec3;

/// The most queries of one request.
const MOST: usize = 100_000;

/// How far the length of a direction may be from 1.
const UNIT: f32 = 1e-3;

/// The answer to `values`: f cos θᵢ of all lobes, RGB, and the density of each query.
pub fn values(request: &Request) -> Result<Value, String> {
    let bcsdf = request.bcsdf()?;
    let queries = request.field("queries").ok_or("queries is missing")?;
    let queries = Vec::<[f32; 8]>::deserialize(queries).map_err(|e| format!("queries: {e}"))?;
    if queries.len() > MOST {
        return Err(format!("queries has {} rows: it must have at most {MOST}", queries.len()));
    }
    let mut values = Vec::with_capacity(queries.len());
    let mut densities = Vec::with_capacity(queries.len());
    for (i, [low, high, wo @ .., x, y, z]) in queries.into_iter().enumerate() {
        if !(-1.0 <= low && low <= high && high <= 1.0) {
            return Err(format!("queries[{i}]: the window [{low}, {high}] must be in [-1, 1]"));
        }
        let (wo, wi) = (Vec3::from_array(wo), Vec3::new(x, y, z));
        for (name, w) in [("wo", wo), ("wi", wi)] {
            if !(1.0 - UNIT..1.0 + UNIT).contains(&w.length()) {
                return Err(format!("queries[{i}]: {name} has the length {}: it must be a unit vector", w.length()));
            }
        }
        let window = if low == high { Window::near(low) } else { Window::range(low, high) };
        let (f, pdf) = bcsdf.with_hit(wo, window, |hit| hit.eval_pdf(wi));
        values.push(f.total());
        densities.push(pdf);
    }
    Ok(json!({ "values": values, "pdf": densities }))
}
