//! Shared test code: directions, a random number generator, random fibres, statistical tests, queries for benchmarks,
//! programs that a test starts, and what a test needs from the machine.
//!
//! Only integration tests, benchmarks, examples and `vellus-torture` can use this crate. A unit test inside `vellus`
//! would see two copies of `vellus`: the one under test and the one that this crate depends on.

mod documents;
pub mod generated;
mod need;
pub mod numbers;
pub mod program;
mod query;
pub mod significance;
pub mod sphere;
mod tfx;
mod tier;
pub mod vectors;

use glam::Vec3;
pub use need::{KINDS, blender, need, succeeds};
pub use query::{Query, queries};
pub use tfx::{small_tfx, tfx};
pub use tier::effort;
pub use vellus::direction;
use vellus::{Fiber, Hit, ScatterExit, TableData, Tables};

/// The tables that `vellus` contains, in the form that the double-precision references take.
pub fn table_data() -> &'static TableData {
    static DATA: std::sync::OnceLock<TableData> = std::sync::OnceLock::new();
    DATA.get_or_init(|| TableData::from_bytes(Tables::SHIPPED).expect("the tables in vellus are valid"))
}

/// A fibre with every parameter non-zero, including α and colour.
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
        exit: ScatterExit::default(),
        medulla_pigment: 0.3,
        wet: 0.0,
        aspect_ratio: 1.0,
        medulla_air: 0.0,
        reflectance: None,
    }
}

/// The inclination and the azimuth of a direction, radians: the inverse of [`direction`].
pub fn angles(direction: Vec3) -> [f64; 2] {
    let [x, y, z] = direction.to_array().map(f64::from);
    [x.atan2(y.hypot(z)), z.atan2(y)]
}

/// A small deterministic random number generator (SplitMix64). The number is its seed.
pub struct Uniform(pub u64);

impl Uniform {
    /// The next number, uniform in [0, 1).
    #[expect(clippy::should_implement_trait, reason = "a generator never ends, so `Option` would only be noise")]
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Single-precision numbers in [0, 1), for a sampler.
    pub fn numbers<const N: usize>(&mut self) -> [f32; N] {
        // Rounding to f32 can give 1, which is outside a sampler's range.
        std::array::from_fn(|_| (self.next() as f32).min(1.0 - f32::EPSILON / 2.0))
    }

    /// A direction for query number `k` of a hit. Half of the directions are where the fibre scatters most light, the
    /// other half anywhere.
    pub fn outgoing(&mut self, hit: &Hit<'_>, k: usize) -> Vec3 {
        if k.is_multiple_of(2) {
            hit.sample(self.numbers()).expect("the fibre scatters light").wi
        } else {
            direction(self.within(-1.55, 1.55), self.within(-3.1, 3.1))
        }
    }

    /// The next number, uniform in [lo, hi).
    pub fn within(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.next()
    }

    /// A random fibre, with the default exit or another one.
    pub fn any_fiber(&mut self) -> Fiber {
        let exit = ScatterExit::ALL[usize::from(self.next() < 0.5)];
        self.fiber().with_exit(exit)
    }

    /// A random round fibre with the default exit. Each parameter varies over most of its valid range. A quarter of the
    /// fibres have air in the medulla.
    pub fn fiber(&mut self) -> Fiber {
        let air = Uniform(!self.0).next();
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
            exit: ScatterExit::default(),
            medulla_pigment: 0.3,
            wet: 0.0,
            aspect_ratio: 1.0,
            medulla_air: (1.0 - 4.0 * air).max(0.0) as f32,
            reflectance: None,
        }
    }
}
