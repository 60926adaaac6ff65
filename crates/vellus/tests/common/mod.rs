//! What the tests share: directions, a generator, a fibre with every parameter non-zero.
#![allow(dead_code, reason = "each test file uses its own part")]

pub mod sphere;

use glam::Vec3;
use vellus::{Fiber, TableData, Tables};

/// The shipped tables, as the f64 oracle wants them.
pub fn table_data() -> &'static TableData {
    static DATA: std::sync::OnceLock<TableData> = std::sync::OnceLock::new();
    DATA.get_or_init(|| TableData::from_bytes(Tables::SHIPPED).unwrap())
}

/// Unit vector at inclination `theta` and azimuth `phi`, radians.
pub fn direction(theta: f64, phi: f64) -> Vec3 {
    Vec3::new(theta.sin() as f32, (theta.cos() * phi.cos()) as f32, (theta.cos() * phi.sin()) as f32)
}

/// A fibre with every parameter non-zero, tilt and colour included.
pub fn full_fiber() -> Fiber {
    Fiber {
        eta: 1.55,
        kappa: 0.7,
        alpha: 3f32.to_radians(),
        beta_m: 8f32.to_radians(),
        beta_n: 11f32.to_radians(),
        sigma_ca: [0.1, 0.3, 0.6],
        sigma_ms: 1.8,
        sigma_ma: [0.05, 0.1, 0.2],
        g: 0.4,
        layers: 0.7,
    }
}

/// A small deterministic generator (SplitMix64), uniform in [0, 1).
pub struct Uniform(pub u64);

impl Uniform {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// What a sampler takes.
    pub fn numbers<const N: usize>(&mut self) -> [f32; N] {
        // Rounding to f32 may give 1, which a sampler must never see.
        std::array::from_fn(|_| (self.next() as f32).min(1.0 - f32::EPSILON / 2.0))
    }

    pub fn within(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.next()
    }

    /// A fibre drawn from the whole valid space, edges included now and then.
    pub fn fiber(&mut self) -> Fiber {
        let mut colour = |scale: f64| -> [f32; 3] { std::array::from_fn(|_| (scale * self.next().powi(3)) as f32) };
        let (sigma_ca, sigma_ma) = (colour(5.0), colour(5.0));
        Fiber {
            eta: self.within(1.02, 2.5) as f32,
            kappa: self.within(0.0, 0.98) as f32,
            alpha: (self.within(-20.0, 20.0) as f32).to_radians(),
            beta_m: (0.5 * 120f64.powf(self.next()) as f32).to_radians(),
            beta_n: (0.5 * 120f64.powf(self.next()) as f32).to_radians(),
            sigma_ca,
            sigma_ms: (20.0 * self.next().powi(2)) as f32,
            sigma_ma,
            g: self.within(0.0, 0.95) as f32,
            layers: self.within(0.05, 3.0) as f32,
        }
    }
}
