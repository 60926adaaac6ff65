//! Random search, and climbs from the best points.

use crate::space::{DIMENSIONS, Point};

/// A small random number generator (SplitMix64).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Random(seed)
    }

    /// Uniform in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Normal, by Box and Muller.
    fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.uniform()).ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }

    pub fn point(&mut self) -> Point {
        std::array::from_fn(|_| self.uniform())
    }
}

/// Climbs from `start` in `steps` steps: random moves of about a third of the coordinates. Their length grows after a
/// success and shrinks after a failure (a (1 + 1) evolution strategy).
pub fn climb(start: Point, value: f64, steps: usize, random: &mut Random, f: impl Fn(&Point) -> f64) -> (Point, f64) {
    let (mut best, mut most, mut length) = (start, value, 0.1f64);
    for _ in 0..steps {
        let mut next = best;
        let certain = (random.uniform() * DIMENSIONS as f64) as usize;
        for (k, x) in next.iter_mut().enumerate() {
            if k == certain || random.uniform() < 0.3 {
                // Moves out of the cube are reflected.
                let moved = (*x + length * random.normal()).abs() % 2.0;
                *x = if moved > 1.0 { 2.0 - moved } else { moved };
            }
        }
        let value = f(&next);
        if value > most {
            (best, most, length) = (next, value, (length * 1.5).min(0.5));
        } else {
            length = (length * 0.94).max(1e-3);
        }
    }
    (best, most)
}

/// Mean, 95th and 99th percentile, and largest.
pub fn distribution(values: &[f64]) -> [f64; 4] {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |share: f64| sorted[((share * sorted.len() as f64).ceil() as usize).clamp(1, sorted.len()) - 1];
    [values.iter().sum::<f64>() / values.len() as f64, at(0.95), at(0.99), at(1.0)]
}
