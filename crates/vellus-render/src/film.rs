//! What a picture is made of: sums of samples, exact in any order.
//!
//! A sum is a whole number of 2⁻³²: adding is associative, so that any thread may add any sample, and parts of a picture
//! rendered apart make the same sums to the last bit.

use crate::layout::Layout;

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
    /// Share of the pixel that fibres cover.
    Fibers,
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
    /// Texture coordinates at the root of the fibre seen.
    RootUv,
    /// Pixels that what is seen moves right and up while the shutter is open.
    Motion,
    /// The beauty's part that came from each group of lights, RGB each; they sum to the beauty.
    Lights,
    /// Number of the strand seen nearest to the eye, counted from 1 over all strands of the scene; 0 is none. It is no mean:
    /// averaged ids would be those of other strands.
    Strand,
}

impl Layer {
    /// All of them.
    pub const ALL: [Layer; 13] = [
        Layer::Beauty,
        Layer::Alpha,
        Layer::Square,
        Layer::Fibers,
        Layer::Lobes,
        Layer::Albedo,
        Layer::Normal,
        Layer::Tangent,
        Layer::Depth,
        Layer::RootUv,
        Layer::Motion,
        Layer::Lights,
        Layer::Strand,
    ];

    /// Number of channels, without those of the light groups, of which each scene has its own.
    pub fn channels(self) -> usize {
        match self {
            Layer::Lights => 0,
            Layer::Lobes => 18,
            Layer::Alpha | Layer::Square | Layer::Fibers | Layer::Depth | Layer::Strand => 1,
            Layer::RootUv | Layer::Motion => 2,
            _ => 3,
        }
    }

    /// Is it kept whether asked for or not?
    pub(crate) fn always(self) -> bool {
        matches!(self, Layer::Beauty | Layer::Alpha | Layer::Square | Layer::Fibers)
    }
}

/// A strand as a film keeps it: of two, the larger number is the one nearer to the eye.
pub(crate) fn nearest(depth: f32, strand: u32) -> i64 {
    // The bits of positive numbers are ordered as they are.
    let near = 0x7fff_ffff - (depth.max(0.0).to_bits() & 0x7fff_ffff);
    i64::from(near) << 32 | i64::from(strand)
}

/// Sums of all samples so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Size of the whole picture, and the part of it that this is: left column, top row, width, height.
    whole: [usize; 2],
    area: [usize; 4],
    layout: Layout,
    /// Samples each pixel has.
    samples: u64,
    sums: Vec<i64>,
}

impl Film {
    /// An empty one of an `area` (left column, top row, width, height) of a picture.
    pub fn new(whole: [usize; 2], area: [usize; 4], layout: Layout) -> Self {
        let sums = vec![0; area[2] * area[3] * layout.channels()];
        Film { whole, area, layout, samples: 0, sums }
    }

    /// Pixels a row.
    pub fn width(&self) -> usize {
        self.area[2]
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.area[3]
    }

    /// Size of the whole picture.
    pub fn whole(&self) -> [usize; 2] {
        self.whole
    }

    /// The part of it that this is: left column, top row, width, height.
    pub fn area(&self) -> [usize; 4] {
        self.area
    }

    /// Which layers it has.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Samples each pixel has.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// With sums that were kept, row by row.
    pub(crate) fn with_sums(self, samples: u64, sums: Vec<i64>) -> Self {
        assert_eq!(sums.len(), self.sums.len(), "as many sums as the film has");
        Film { samples, sums, ..self }
    }

    /// All sums.
    pub(crate) fn sums(&self) -> &[i64] {
        &self.sums
    }

    /// Notes that every pixel has that many samples more.
    pub(crate) fn advance(&mut self, samples: u64) {
        self.samples += samples;
    }

    /// Adds the sums of all pixels, row by row.
    pub(crate) fn add_rows(&mut self, rows: impl Iterator<Item = Vec<i64>>) {
        let length = self.width() * self.layout.channels();
        for (sums, row) in self.sums.chunks_exact_mut(length).zip(rows) {
            combine(&self.layout, sums, &row);
        }
    }

    /// Adds what another film of the same size and layers has seen.
    pub fn merge(&mut self, other: &Film) {
        assert!(self.fits(other), "films of different size or layers");
        self.samples = self.samples.saturating_add(other.samples);
        combine(&self.layout, &mut self.sums, &other.sums);
    }

    /// Are they of the same size and layers?
    pub fn fits(&self, other: &Film) -> bool {
        (self.whole, self.area, &self.layout) == (other.whole, other.area, &other.layout)
    }

    fn at(&self, x: usize, y: usize) -> &[i64] {
        &self.sums[(y * self.width() + x) * self.layout.channels()..][..self.layout.channels()]
    }

    /// The mean of one channel of a layer; 0 where the layer is not kept.
    pub fn mean(&self, x: usize, y: usize, layer: Layer, channel: usize) -> f64 {
        let sum = self.layout.start(layer).map_or(0, |start| self.at(x, y)[start + channel]);
        sum as f64 * UNIT / self.samples.max(1) as f64
    }

    /// The strand nearest to the eye that the pixel saw: see [`Layer::Strand`].
    pub fn strand(&self, x: usize, y: usize) -> u32 {
        self.layout.start(Layer::Strand).map_or(0, |start| self.at(x, y)[start] as u32)
    }

    /// Mean brightness of a pixel.
    fn brightness(&self, x: usize, y: usize) -> f64 {
        (0..3).map(|c| self.mean(x, y, Layer::Beauty, c)).sum::<f64>() / 3.0
    }

    /// Noise of the whole picture: root mean square of the pixels' standard errors over its mean brightness.
    pub fn noise(&self) -> f64 {
        let pixels = || (0..self.width() * self.height()).map(|i| (i % self.width(), i / self.width()));
        let n = (self.width() * self.height()) as f64;
        let mean = pixels().map(|(x, y)| self.brightness(x, y)).sum::<f64>() / n;
        let square = pixels().map(|(x, y)| self.error(x, y).powi(2)).sum::<f64>() / n;
        if mean > 0.0 { square.sqrt() / mean } else { 0.0 }
    }

    /// Standard error of a pixel's mean brightness.
    pub fn error(&self, x: usize, y: usize) -> f64 {
        let n = self.samples.max(2) as f64;
        let square = self.mean(x, y, Layer::Square, 0);
        ((square - self.brightness(x, y).powi(2)).max(0.0) / (n - 1.0)).sqrt()
    }
}

/// Adds pixels' sums to others.
fn combine(layout: &Layout, sums: &mut [i64], others: &[i64]) {
    let channels = layout.channels();
    for (sums, others) in sums.chunks_exact_mut(channels).zip(others.chunks_exact(channels)) {
        let (sums, nearest) = sums.split_at_mut(layout.sums());
        sums.iter_mut().zip(others).for_each(|(a, b)| *a = a.saturating_add(*b));
        nearest.iter_mut().zip(&others[layout.sums()..]).for_each(|(a, b)| *a = (*a).max(*b));
    }
}

/// Adds a sample to a pixel's sums, and the strand it saw, as [`nearest`] has it; false, and nothing added, where it is
/// not finite.
pub(crate) fn add(sums: &mut [i64], values: &[f32], strand: i64) -> bool {
    if values.iter().any(|v| !v.is_finite()) {
        return false;
    }
    let (sums, nearest) = sums.split_at_mut(values.len());
    for (sum, &v) in sums.iter_mut().zip(values) {
        *sum = sum.saturating_add((f64::from(v.clamp(-LARGEST, LARGEST)) / UNIT).round() as i64);
    }
    nearest.iter_mut().for_each(|n| *n = (*n).max(strand));
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_do_not_depend_on_order() {
        const N: usize = 5;
        let values = |i: usize| -> [f32; N] {
            std::array::from_fn(|c| (i as f32 * 1.7 + c as f32).sin() * 3f32.powi(i as i32 % 9))
        };
        let strand = |i: usize| nearest(1.0 + (i as f32).sin(), i as u32);
        let (mut forward, mut backward) = ([0; N + 1], [0; N + 1]);
        (0..100).for_each(|i| assert!(add(&mut forward, &values(i), strand(i))));
        (0..100).rev().for_each(|i| assert!(add(&mut backward, &values(i), strand(i))));
        assert_eq!(forward, backward);
        // sin is smallest at 11 among whole numbers up to 100.
        assert_eq!(forward[N] as u32, 11);
        let mut bad = values(3);
        bad[2] = f32::NAN;
        assert!(!add(&mut forward, &bad, 0) && forward == backward);
    }
}
