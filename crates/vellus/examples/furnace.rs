//! A white furnace: a fibre without absorption, lit evenly from all directions, returns all light.
//!
//! `cargo run --release -p vellus --example furnace` prints the energy of each species, by uniform sampling of the
//! sphere and by the model's own sampling.

use std::f32::consts::TAU;
use vellus::glam::Vec3;
use vellus::{Bcsdf, Error, Fiber, Species, Window};

/// Samples along each axis of a grid of random numbers.
const N: usize = 48;

/// Number `k` of sample `i` in [0, 1), by an additive recurrence. Its numbers are more even than random ones.
fn uniform(i: usize, k: i32) -> f32 {
    ((i as f64 + 0.5) * 1.103_f64.powi(-k)).fract() as f32
}

/// The energy, estimated with uniform directions and with the model's sampling.
fn furnace(fiber: &Fiber, window: Window) -> Result<[f32; 2], Error> {
    let bcsdf = Bcsdf::new(&fiber.without_absorption())?;
    let wo = Vec3::new(0.3, 0.8, 0.5).normalize();
    let hit = bcsdf.at(wo, window);
    let n = N * N * N;
    let mut energy = [0.0f64; 2];
    for i in 0..n {
        let x = 2.0 * uniform(i, 1) - 1.0;
        let (sin, cos) = (TAU * uniform(i, 2)).sin_cos();
        let r = (1.0 - x * x).max(0.0).sqrt();
        // Uniform over the sphere: 4π times the mean of f·cos θᵢ.
        energy[0] += f64::from(hit.eval(Vec3::new(x, r * cos, r * sin)).total()[1] * 2.0 * TAU);
        let sample = hit.sample([1, 2, 3, 4, 5].map(|k| uniform(i, k)));
        energy[1] += sample.map_or(0.0, |sample| f64::from(sample.weight[1]));
    }
    Ok(energy.map(|e| (e / n as f64) as f32))
}

fn main() -> Result<(), Error> {
    println!("{:<10} {:>9} {:>9} {:>9} {:>9}", "species", "near", "sampled", "far", "sampled");
    for species in Species::ALL {
        let fiber = Fiber::preset(species);
        let [near, near_sampled] = furnace(&fiber, Window::near(0.3))?;
        let [far, far_sampled] = furnace(&fiber, Window::far())?;
        println!("{:<10} {near:>9.4} {near_sampled:>9.4} {far:>9.4} {far_sampled:>9.4}", species.name());
    }
    Ok(())
}

#[test]
fn the_furnace_is_white() {
    for window in [Window::near(0.3), Window::far()] {
        let [even, sampled] = furnace(&Fiber::preset(Species::RedFox), window).unwrap();
        // The variance of 4π f is below 4π times the peak of f, 3.3 per steradian: the standard error is below 2 %.
        assert!((even - 1.0).abs() < 0.06 && (sampled - 1.0).abs() < 1e-3, "{window:?}: {even} {sampled}");
    }
}
