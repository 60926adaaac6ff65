//! Energies of a model's lobes over a fibre's width.

use crate::direction;
use std::f64::consts::PI;
use vellus::{Model, Scattering, Window, WindowSupport};

/// Midpoints of the average over the width.
const OFFSETS: i32 = 20_000;

/// Energies of a model's six lobes, RGB, for ω_o at `theta_o` degrees. They are for the offset `h` in [−1, 1], or
/// averaged over the whole width if it is `None`.
///
/// A model of the far field has the same energies at every offset.
pub fn energies(model: &impl Model, theta_o: f64, h: Option<f64>) -> [[f64; 3]; 6] {
    let offsets: Vec<f64> = match h {
        Some(h) => vec![h],
        None if model.field() == WindowSupport::Far => vec![0.0],
        // Midpoints in asin h, which are dense at the edge, where Fresnel reflection rises.
        None => (0..OFFSETS).map(|i| ((f64::from(i) + 0.5) / f64::from(OFFSETS) - 0.5) * PI).collect(),
    };
    let (mut sum, mut total) = ([[0.0; 3]; 6], 0.0);
    for &x in &offsets {
        let (h, weight) = if offsets.len() == 1 { (x, 1.0) } else { (x.sin(), x.cos()) };
        let energy = model.at(direction(theta_o, 0.0), Window::near(h as f32)).energy();
        for (s, e) in sum.iter_mut().flatten().zip(energy.0.iter().flatten()) {
            *s += weight * f64::from(*e);
        }
        total += weight;
    }
    sum.map(|lobe| lobe.map(|x| x / total))
}
