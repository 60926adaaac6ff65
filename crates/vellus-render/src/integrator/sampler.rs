//! Well-distributed random numbers: Owen-scrambled Sobol' points, padded four dimensions at a time (Burley 2020,
//! Practical Hash-based Owen Scrambling; crate sobol_burley).
//!
//! They depend only on the pixel, the index of the sample and the seed. Any thread may compute any sample.

/// The numbers of one sample of one pixel.
#[derive(Clone, Debug)]
pub struct Sampler {
    index: u32,
    seed: u32,
    set: u32,
}

fn hash(mut x: u32) -> u32 {
    // The hash lowbias32 by Chris Wellons.
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

impl Sampler {
    /// The numbers of sample `index` of a pixel. The scrambling changes every 65536 samples.
    pub fn new(pixel: [u32; 2], index: u64, seed: u32) -> Self {
        let block = (index >> 16) as u32;
        let seed = hash(pixel[0] ^ hash(pixel[1] ^ hash(seed ^ hash(block))));
        Sampler { index: (index & 0xffff) as u32, seed, set: 0 }
    }

    /// The next four numbers, in [0, 1).
    #[inline]
    pub fn next(&mut self) -> [f32; 4] {
        let set = self.set;
        self.set += 1;
        // Each set has its own scrambling: sets are padded, instead of one sequence of hundreds of dimensions.
        sobol_burley::sample_4d(self.index, 0, hash(self.seed ^ set.wrapping_mul(0x9e37_79b9)))
    }

    /// A number in [0, 1) that uses no dimension, for decisions that need no stratification.
    #[inline]
    pub fn chance(&self) -> f32 {
        (hash(self.seed ^ hash(self.index ^ self.set.wrapping_mul(0x85eb_ca6b))) >> 8) as f32 / (1u32 << 24) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In every dimension, 256 samples have one number in each of 256 equal intervals, for every set and pixel.
    #[test]
    fn samples_are_stratified() {
        for pixel in [[0, 0], [31, 7]] {
            for set in 0..40 {
                let mut filled = [[false; 256]; 4];
                for index in 0..256 {
                    let mut sampler = Sampler::new(pixel, index, 5);
                    (0..set).for_each(|_| {
                        sampler.next();
                    });
                    let u = sampler.next();
                    (0..4).for_each(|k| filled[k][(u[k] * 256.0) as usize] = true);
                }
                assert!(filled.iter().flatten().all(|&f| f), "{pixel:?} {set}");
            }
        }
        let first = |pixel, index| Sampler::new(pixel, index, 5).next();
        assert!(first([0, 0], 0) != first([0, 1], 0) && first([0, 0], 0) != first([0, 0], 1 << 16));
    }

    /// Chances are uniform in [0, 1) and independent of the next number: the counts of 64 cells of both are within five
    /// standard deviations.
    #[test]
    fn chances_are_independent() {
        let mut cells = [0f64; 64];
        let count = 64.0 * 1000.0;
        for i in 0..count as u64 {
            let mut sampler = Sampler::new([i as u32 % 97, 3], i / 97, 1);
            sampler.next();
            let chance = sampler.chance();
            cells[(chance * 8.0) as usize * 8 + (sampler.next()[0] * 8.0) as usize] += 1.0;
        }
        assert!(cells.iter().all(|n| (n - 1000.0).abs() < 5.0 * 1000f64.sqrt()), "{cells:?}");
    }
}
