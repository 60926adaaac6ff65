//! The first check of an integration: a white furnace for one fibre, without geometry.

use std::f32::consts::PI;
use vellus::glam::Vec3;
use vellus::{Bcsdf, Fiber, Species, Window};

fn main() -> Result<(), vellus::Error> {
    print!("{}", table()?);
    Ok(())
}

/// The light that a white fibre returns, for four inclinations: by samples, and by `eval` with its standard error.
pub fn table() -> Result<String, vellus::Error> {
    let white = Fiber::preset(Species::RedFox).without_absorption();
    let bcsdf = Bcsdf::new(&white)?;
    let mut random = Random(7);
    let mut table = String::from("theta_o   sample   eval\n");
    for degrees in [0f32, 30.0, 60.0, 85.0] {
        let theta_o = degrees.to_radians();
        let wo = Vec3::new(theta_o.sin(), theta_o.cos(), 0.0);
        let n = 1_000_000;
        let (mut sampled, mut evaluated, mut squares) = (0.0, 0.0, 0.0);
        for _ in 0..n {
            // Light that arrives evenly over the fibre's width.
            let h = 2.0 * random.next() - 1.0;
            let hit = bcsdf.at(wo, Window::near(h));
            // Directions drawn by the model: the mean of f·cos/pdf.
            let u = std::array::from_fn(|_| random.next());
            sampled += hit.sample(u).map_or(0.0, |s| f64::from(s.weight[0]));
            // Directions drawn evenly over the whole sphere: the mean of f·cos·4π.
            let f = hit.eval(random.direction()).total();
            let x = f64::from(f[0] * 4.0 * PI);
            evaluated += x;
            squares += x * x;
        }
        let n = f64::from(n);
        let (sampled, evaluated) = (sampled / n, evaluated / n);
        let error = ((squares / n - evaluated * evaluated) / n).sqrt();
        table += &format!("{degrees:6.0}°  {sampled:.4}   {evaluated:.4} ± {error:.4}\n");
    }
    Ok(table)
}

/// A small random number generator (SplitMix64).
struct Random(u64);

impl Random {
    /// Uniform in [0, 1).
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }

    /// Uniform over the sphere, with density 1/4π.
    fn direction(&mut self) -> Vec3 {
        let (z, phi) = (2.0 * self.next() - 1.0, 2.0 * PI * self.next());
        let r = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(r * phi.cos(), r * phi.sin(), z)
    }
}
