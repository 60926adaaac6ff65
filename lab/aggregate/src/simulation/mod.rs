//! Simulations: the disc behind the table of this crate, and explicit bunches of fibres to compare aggregates with.
//!
//! All random numbers are seeded, and sums have a fixed order, so results do not depend on threads.

mod disc;
mod fibers;
mod profile;

pub use disc::{Disc, build, tabulated};
pub use fibers::{Collision, Fibers, Places, Scattered};
pub use profile::{CELLS, Profile};

use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// A random generator with the same numbers on every platform.
struct Random(Xoshiro256PlusPlus);

impl Random {
    /// The generator of one stream of a seed.
    fn new(seed: u64, stream: u64) -> Self {
        let mixed = Xoshiro256PlusPlus::seed_from_u64(seed).next_u64();
        Random(Xoshiro256PlusPlus::seed_from_u64(mixed ^ stream.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
    }

    /// A number in [0, 1).
    fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A standard normal deviate (Box and Muller 1958).
    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * libm::log(1.0 - self.uniform())).sqrt();
        radius * libm::cos(std::f64::consts::TAU * self.uniform())
    }
}
