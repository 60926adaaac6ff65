//! Random choices that depend only on a seed.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::ops::Range;

/// A source of random choices.
pub struct Dice(Xoshiro256PlusPlus);

impl Dice {
    /// The choices of one case of one attack.
    pub fn new(seed: u64, attack: &str, case: u64) -> Self {
        // FNV-1a: each attack and each case has its own sequence.
        let bytes = attack.bytes().chain(seed.to_le_bytes()).chain(case.to_le_bytes());
        let hash = bytes.fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
        });
        Dice(Xoshiro256PlusPlus::seed_from_u64(hash))
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0.random_range(0.0..1.0)
    }

    /// Uniform in [lo, hi).
    pub fn within(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    /// A whole number from a non-empty range.
    pub fn number(&mut self, range: Range<usize>) -> usize {
        self.0.random_range(range)
    }

    /// True with this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// One of several values. The slice must not be empty.
    pub fn pick<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        &of[self.number(0..of.len())]
    }

    /// A random byte.
    pub fn byte(&mut self) -> u8 {
        self.number(0..256) as u8
    }

    /// Shuffles a slice.
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.number(0..i + 1));
        }
    }
}
