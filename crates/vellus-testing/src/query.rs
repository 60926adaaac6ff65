//! Queries for benchmarks.

use glam::Vec3;
use std::f32::consts::TAU;

/// One query of a model, in the frame of the fibre.
pub struct Query {
    /// ω_o, a unit vector.
    pub wo: Vec3,
    /// ω_i, a unit vector.
    pub wi: Vec3,
    /// The offset of the hit, in [−1, 1).
    pub h: f32,
    /// Uniform numbers in [0, 1) for sampling.
    pub u: [f32; 5],
}

/// Different queries, so that branches and caches behave as in a renderer. Inclinations are within 1.5 radians.
pub fn queries(count: usize) -> Vec<Query> {
    // An R-sequence (Roberts): even coverage without a random generator.
    let unit = |i: usize, k: i32| ((i as f64 + 0.5) * 1.103_0f64.powi(-k)).fract() as f32;
    let direction = |a: f32, b: f32| {
        let (sin, cos) = ((2.0 * a - 1.0) * 1.5).sin_cos();
        let (z, y) = (b * TAU).sin_cos();
        Vec3::new(sin, cos * y, cos * z)
    };
    (0..count)
        .map(|i| Query {
            wo: direction(unit(i, 1), unit(i, 2)),
            wi: direction(unit(i, 3), unit(i, 4)),
            h: 2.0 * unit(i, 5) - 1.0,
            u: [6, 7, 8, 9, 10].map(|k| unit(i, k)),
        })
        .collect()
}
