//! What a picture is made of: sums of samples, exact in any order.
//!
//! A sum is a whole number of 2⁻³²: adding is associative, so that any thread may add any sample, and parts of a picture
//! rendered apart make the same sums to the last bit.

/// One unit of a sum.
const UNIT: f64 = 1.0 / (1u64 << 32) as f64;

/// No sample counts for more: a sum of 65,536 of them still fits.
pub const LARGEST: f32 = 1e4;

/// Layers of a picture, in the order of a pixel's channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layer {
    /// RGB radiance.
    Beauty,
    /// Share of the pixel that anything covers.
    Alpha,
    /// Square of the samples' brightness: the variance is its mean less the square of the mean's.
    Square,
    /// The six lobes of the fibres seen directly, RGB each, in the order of [`vellus::Lobe`]; they sum to the fibres' part of
    /// the beauty.
    Lobes,
    /// Energy that the fibre or surface seen scatters, RGB.
    Albedo,
    /// Shading normal seen, world space.
    Normal,
    /// Tangent of the fibre seen, toward the tip, world space.
    Tangent,
    /// Distance from the eye.
    Depth,
}

impl Layer {
    /// All of them.
    pub const ALL: [Layer; 8] = [
        Layer::Beauty,
        Layer::Alpha,
        Layer::Square,
        Layer::Lobes,
        Layer::Albedo,
        Layer::Normal,
        Layer::Tangent,
        Layer::Depth,
    ];

    /// Number of channels.
    pub fn channels(self) -> usize {
        match self {
            Layer::Lobes => 18,
            Layer::Alpha | Layer::Square | Layer::Depth => 1,
            _ => 3,
        }
    }

    /// Where its channels begin in a pixel.
    pub fn start(self) -> usize {
        Layer::ALL[..self as usize].iter().map(|l| l.channels()).sum()
    }
}

/// Channels of a pixel.
pub const CHANNELS: usize = 33;

/// What one sample adds to its pixel.
pub type Values = [f32; CHANNELS];

/// Sums of all samples so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    width: usize,
    height: usize,
    /// Samples each pixel has.
    samples: u64,
    sums: Vec<i64>,
}

impl Film {
    /// An empty one.
    pub fn new(width: usize, height: usize) -> Self {
        Film { width, height, samples: 0, sums: vec![0; width * height * CHANNELS] }
    }

    /// Pixels a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Samples each pixel has.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// From sums that were kept: `CHANNELS` a pixel, row by row.
    pub(crate) fn from_sums(width: usize, height: usize, samples: u64, sums: Vec<i64>) -> Self {
        assert_eq!(sums.len(), width * height * CHANNELS, "as many sums as the film has");
        Film { width, height, samples, sums }
    }

    /// All sums.
    pub(crate) fn sums(&self) -> &[i64] {
        &self.sums
    }

    /// Notes that every pixel has that many samples more.
    pub(crate) fn advance(&mut self, samples: u64) {
        self.samples += samples;
    }

    /// The sums of all pixels, row by row.
    pub(crate) fn rows_mut(&mut self) -> std::slice::ChunksExactMut<'_, i64> {
        self.sums.chunks_exact_mut(self.width * CHANNELS)
    }

    /// Adds what another film of the same size has seen.
    pub fn merge(&mut self, other: &Film) {
        assert_eq!((self.width, self.height), (other.width, other.height), "films of different size");
        self.samples += other.samples;
        self.sums.iter_mut().zip(&other.sums).for_each(|(a, b)| *a = a.saturating_add(*b));
    }

    /// The mean of one channel.
    pub fn mean(&self, x: usize, y: usize, channel: usize) -> f64 {
        let sum = self.sums[(y * self.width + x) * CHANNELS + channel];
        sum as f64 * UNIT / self.samples.max(1) as f64
    }

    /// Noise of the whole picture: root mean square of the pixels' standard errors over its mean brightness.
    pub fn noise(&self) -> f64 {
        let pixels = || (0..self.width * self.height).map(|i| (i % self.width, i / self.width));
        let brightness = |(x, y): (usize, usize)| (0..3).map(|c| self.mean(x, y, c)).sum::<f64>() / 3.0;
        let n = (self.width * self.height) as f64;
        let mean = pixels().map(brightness).sum::<f64>() / n;
        let square = pixels().map(|(x, y)| self.error(x, y).powi(2)).sum::<f64>() / n;
        if mean > 0.0 { square.sqrt() / mean } else { 0.0 }
    }

    /// Standard error of a pixel's mean brightness.
    pub fn error(&self, x: usize, y: usize) -> f64 {
        let n = self.samples.max(2) as f64;
        let mean = (0..3).map(|c| self.mean(x, y, c)).sum::<f64>() / 3.0;
        let square = self.mean(x, y, Layer::Square.start());
        ((square - mean * mean).max(0.0) / (n - 1.0)).sqrt()
    }
}

/// Adds a sample to a pixel's sums; false, and nothing added, where it is not finite.
pub(crate) fn add(sums: &mut [i64], values: &Values) -> bool {
    if values.iter().any(|v| !v.is_finite()) {
        return false;
    }
    for (sum, &v) in sums.iter_mut().zip(values) {
        *sum = sum.saturating_add((f64::from(v.clamp(-LARGEST, LARGEST)) / UNIT).round() as i64);
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_fit() {
        assert_eq!(Layer::ALL.iter().map(|l| l.channels()).sum::<usize>(), CHANNELS);
        assert_eq!(Layer::Depth.start() + 1, CHANNELS);
    }

    #[test]
    fn sums_do_not_depend_on_order() {
        let values = |i: usize| -> Values {
            std::array::from_fn(|c| (i as f32 * 1.7 + c as f32).sin() * 3f32.powi(i as i32 % 9))
        };
        let mut forward = vec![0; CHANNELS];
        let mut backward = vec![0; CHANNELS];
        (0..100).for_each(|i| assert!(add(&mut forward, &values(i))));
        (0..100).rev().for_each(|i| assert!(add(&mut backward, &values(i))));
        assert_eq!(forward, backward);
        let mut bad = values(3);
        bad[7] = f32::NAN;
        assert!(!add(&mut forward, &bad) && forward == backward);
    }
}
