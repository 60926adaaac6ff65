//! Films: exact sums of samples ([`sums`]).

pub mod attributes;
pub mod checkpoint;
pub mod cryptomatte;
pub mod denoised;
mod exr;
mod layer;
pub mod layout;
mod meter;
pub mod picture;
pub mod png;
mod sums;
pub(crate) mod tiles;
pub mod tone;
mod values;

pub use layer::Layer;
pub(crate) use meter::fibonacci;

use crate::error::Error;
pub(crate) use crate::film::layout::Layout;
use cryptomatte::Count;
use rayon::prelude::*;
use sums::Format;
use tiles::Tiles;

/// The number for a strand in a film. Of two numbers, the larger one is of the strand nearer to the camera.
pub(crate) fn nearest(depth: f32, strand: u32) -> u64 {
    // The bits of positive numbers have the same order as the numbers.
    let near = 0x7fff_ffff - (depth.max(0.0).to_bits() & 0x7fff_ffff);
    u64::from(near) << 32 | u64::from(strand)
}

/// The sums of all samples so far, for each pixel and channel of a picture or a part of it.
///
/// Sums are whole numbers of small units. They do not depend on the order of the samples, so films of sample ranges
/// merge with the same bits as one film. Pixels are counted from the upper left corner.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Width and height of the whole picture, and the area that this film covers: left column, top row, width, height.
    whole: [usize; 2],
    area: [usize; 4],
    layout: Layout,
    /// Samples of each pixel, or the nominal number if there are tiles.
    samples: u64,
    tiles: Option<Tiles>,
    sums: Vec<u32>,
    /// Counts of things, sorted by pixel and thing; none without layers of [`Layer::CRYPTOMATTE`].
    counts: Vec<Count>,
}

impl Film {
    /// An empty film of an `area` of a picture of size `whole`: left column, top row, width and height, in pixels. Use
    /// [`World::layout`](crate::World::layout) for the layout.
    pub fn new(whole: [usize; 2], area: [usize; 4], layout: Layout) -> Self {
        let sums = vec![0; area[2] * area[3] * layout.words()];
        Film { whole, area, layout, samples: 0, tiles: None, sums, counts: Vec::new() }
    }

    /// As [`Film::new`], for a size that somebody chose: [`Film::new`] ends the program if the system has no memory.
    ///
    /// # Errors
    /// [`Error::Memory`] if the system has no memory for the film.
    pub fn try_new(whole: [usize; 2], area: [usize; 4], layout: Layout) -> Result<Self, Error> {
        let [_, _, width, height] = area;
        let numbers = [width, height, layout.bytes_per_pixel()].map(|n| n as u64);
        let bytes = numbers.into_iter().fold(1, u64::saturating_mul);
        if vellus_io::fits_in_memory(bytes) {
            Ok(Film::new(whole, area, layout))
        } else {
            Err(Error::Memory { size: [width, height], bytes })
        }
    }

    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.area[2]
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.area[3]
    }

    /// Width and height of the whole picture.
    pub fn whole(&self) -> [usize; 2] {
        self.whole
    }

    /// The area of the picture that this film covers: left column, top row, width, height.
    pub fn area(&self) -> [usize; 4] {
        self.area
    }

    /// Its layers and channels.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Samples of each pixel. With adaptive sampling, the nominal number: about the mean over the pixels. See
    /// [`Film::samples_of`].
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Sets the sums, row by row.
    pub(crate) fn with_sums(self, samples: u64, sums: Vec<u32>) -> Self {
        assert_eq!(sums.len(), self.sums.len(), "as many sums as the film has");
        Film { samples, sums, ..self }
    }

    /// All sums, row by row.
    pub(crate) fn sums(&self) -> &[u32] {
        &self.sums
    }

    /// Sets the counts of things.
    pub(crate) fn with_counts(self, counts: Vec<Count>) -> Self {
        Film { counts, ..self }
    }

    /// All counts of things.
    pub(crate) fn counts(&self) -> &[Count] {
        &self.counts
    }

    /// Adds counts of things, sorted by pixel and thing.
    pub(crate) fn add_counts(&mut self, counts: &[Count]) {
        cryptomatte::merge(&mut self.counts, counts);
    }

    /// Counts more samples of every pixel.
    pub(crate) fn advance(&mut self, samples: u64) {
        self.samples += samples;
    }

    /// Adds sums of all pixels, row by row.
    pub(crate) fn add_rows(&mut self, rows: impl IndexedParallelIterator<Item = Vec<u32>>) {
        let length = self.width() * self.layout.words();
        let layout = &self.layout;
        self.sums.par_chunks_exact_mut(length).zip(rows).for_each(|(sums, row)| combine(layout, sums, &row));
    }

    /// Adds the samples of another film of the same picture.
    ///
    /// # Panics
    /// Panics unless [`Film::fits`] returns true, and for films with adaptive sampling.
    pub fn merge(&mut self, other: &Film) {
        assert!(self.fits(other), "films of different size or layers");
        assert!(!self.is_adaptive() && !other.is_adaptive(), "films with adaptive sampling");
        self.samples = self.samples.saturating_add(other.samples);
        combine(&self.layout, &mut self.sums, &other.sums);
        self.add_counts(&other.counts);
    }

    /// Whether both films have the same size, area and layers.
    pub fn fits(&self, other: &Film) -> bool {
        (self.whole, self.area, &self.layout) == (other.whole, other.area, &other.layout)
    }

    fn at(&self, x: usize, y: usize) -> &[u32] {
        &self.sums[(y * self.width() + x) * self.layout.words()..][..self.layout.words()]
    }

    /// The mean of one channel of a layer over the samples of a pixel; 0 if the film does not keep the layer.
    pub fn mean(&self, x: usize, y: usize, layer: Layer, channel: usize) -> f64 {
        let sum = self.layout.kept(layer).map_or(0.0, |kept| {
            debug_assert!(channel < kept.width);
            sums::value(&self.at(x, y)[kept.words(channel)], kept.format)
        });
        sum / self.samples_of(x, y).max(1) as f64
    }

    /// The strand nearest to the camera in a pixel, counted from 1. 0 if there is none. See [`Layer::Strand`].
    pub fn strand(&self, x: usize, y: usize) -> u32 {
        self.layout.kept(Layer::Strand).map_or(0, |kept| sums::largest(&self.at(x, y)[kept.words(0)]) as u32)
    }

    /// Mean brightness of a pixel.
    fn brightness(&self, x: usize, y: usize) -> f64 {
        (0..3).map(|c| self.mean(x, y, Layer::Beauty, c)).sum::<f64>() / 3.0
    }

    /// The noise of the picture: the root mean square of the pixels' standard errors, divided by the mean brightness.
    /// The error of the radiance cache is a part of it. `None` with fewer than two samples a pixel, and for a black
    /// picture.
    pub fn noise(&self) -> Option<f64> {
        let n = (self.width() * self.height()) as f64;
        // Sums of rows: the order of additions does not depend on the number of threads.
        let rows: Vec<[f64; 2]> = (0..self.height())
            .into_par_iter()
            .map(|y| {
                (0..self.width()).fold([0.0; 2], |[mean, square], x| {
                    let brightness = self.brightness(x, y);
                    [mean + brightness, square + self.error(x, y).powi(2)]
                })
            })
            .collect();
        let [mean, square] = [0, 1].map(|k| rows.iter().map(|row| row[k]).sum::<f64>() / n);
        (self.samples > 1 && mean > 0.0).then(|| square.sqrt() / mean)
    }

    /// The standard error of a pixel's mean brightness, by its samples and by the radiance cache.
    pub fn error(&self, x: usize, y: usize) -> f64 {
        self.variance_of_samples(x, y).sqrt().hypot(self.mean(x, y, Layer::CacheError, 0))
    }

    /// The variance of a pixel's mean brightness, if the radiance cache had no error.
    pub(crate) fn variance_of_samples(&self, x: usize, y: usize) -> f64 {
        let n = self.samples_of(x, y).max(2) as f64;
        let square = self.mean(x, y, Layer::SecondMoment, 0);
        (square - self.brightness(x, y).powi(2)).max(0.0) / (n - 1.0)
    }

    /// The number of pixels with a sum at the end of its range. They may be too dark in the picture. The range of
    /// beauty and lights ends at 9e18, that of lobes and depth at 5.6e14, that of other layers at 2e9.
    pub fn full_pixels(&self) -> usize {
        let full = |pixel: &[u32]| {
            self.layout
                .all_kept()
                .any(|kept| (0..kept.width).any(|c| sums::is_full(&pixel[kept.words(c)], kept.format)))
        };
        self.sums.par_chunks_exact(self.layout.words()).filter(|pixel| full(pixel)).count()
    }
}

/// Adds the sums of `others` to `sums`.
fn combine(layout: &Layout, sums: &mut [u32], others: &[u32]) {
    let stride = layout.words();
    for (sums, others) in sums.chunks_exact_mut(stride).zip(others.chunks_exact(stride)) {
        for kept in layout.all_kept() {
            for words in (0..kept.width).map(|c| kept.words(c)) {
                sums::combine(&mut sums[words.clone()], kept.format, &others[words]);
            }
        }
    }
}

/// Adds a sample to a pixel's sums. `values` are those of all channels; the sum of [`Layer::SecondMoment`] is computed
/// from the beauty, and [`Layer::Strand`] is `strand`, made by [`nearest`]. If a value is not finite, it adds nothing
/// and returns false.
pub(crate) fn add(layout: &Layout, sums: &mut [u32], values: &[f32], strand: u64) -> bool {
    // The largest magnitude, as bits: SIMD compares eight of them at once.
    let largest = values.iter().fold(0, |largest, v| largest.max(v.to_bits() & 0x7fff_ffff));
    if largest >= f32::INFINITY.to_bits() {
        return false;
    }
    for kept in layout.all_kept() {
        match kept.format {
            Format::Square => sums::add_square(&mut sums[kept.words(0)], &values[..3]),
            Format::Largest => sums::add_largest(&mut sums[kept.words(0)], strand),
            Format::Bounded | Format::Part | Format::Light => {
                let values = &values[kept.channel..][..kept.width];
                // Lobes and tangents are 0 wherever the pixel sees no fibre.
                if values.iter().fold(0, |bits, v| bits | v.to_bits()) != 0 {
                    sums::add_values(&mut sums[kept.all_words()], kept.format, values);
                }
            }
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_do_not_depend_on_order() {
        let layout = Layout::new(&Layer::ALL, &["key".to_owned()]);
        let values = |i: usize| -> Vec<f32> {
            (0..layout.channels()).map(|c| (i as f32 * 1.7 + c as f32).sin() * 3f32.powi(i as i32 % 9)).collect()
        };
        let strand = |i: usize| nearest(1.0 + (i as f32).sin(), i as u32);
        let mut films = [0, 1].map(|_| vec![0; layout.words()]);
        for i in 0..100 {
            assert!(add(&layout, &mut films[0], &values(i), strand(i)));
            assert!(add(&layout, &mut films[1], &values(99 - i), strand(99 - i)));
        }
        assert_eq!(films[0], films[1]);
        // Among whole numbers up to 100, sin is smallest at 11.
        let [forward, backward] = &mut films;
        let kept = layout.kept(Layer::Strand).unwrap();
        assert_eq!(sums::largest(&forward[kept.words(0)]) as u32, 11);
        let mut bad = values(3);
        bad[2] = f32::NAN;
        assert!(!add(&layout, forward, &bad, 0) && forward == backward);
    }

    /// A film of one pixel with samples of these brightnesses.
    fn film(samples: &[f32]) -> Film {
        let layout = Layout::new(&[Layer::Depth], &[]);
        let mut film = Film::new([1, 1], [0, 0, 1, 1], layout.clone());
        let mut sums = vec![0; layout.words()];
        for &x in samples {
            let mut values = vec![0.0; layout.channels()];
            values[..3].fill(x);
            values[layout.start(Layer::Depth).unwrap()] = x;
            assert!(add(&layout, &mut sums, &values, 0));
        }
        film.add_rows(rayon::iter::once(sums));
        film.advance(samples.len() as u64);
        film
    }

    #[test]
    fn noise_does_not_depend_on_the_scale_of_light() {
        let samples: Vec<f32> = (0..64).map(|i| 1.0 + (i as f32 * 2.3).sin()).collect();
        let exact = film(&samples).noise().unwrap();
        for exponent in -12..=12 {
            let scale = 10f32.powi(exponent);
            let scaled: Vec<f32> = samples.iter().map(|x| x * scale).collect();
            let found = film(&scaled);
            // Samples are rounded to single precision. Samples of 1e-12 are rounded to units of 2⁻⁶⁴, with an error of
            // half a unit.
            let noise = found.noise().unwrap();
            assert!((noise / exact - 1.0).abs() < 1e-5, "{scale}: {noise} {exact}");
            assert!((found.mean(0, 0, Layer::Beauty, 0) / f64::from(scale) - 1.0).abs() < 0.1);
            if exponent >= -6 {
                let depth = found.mean(0, 0, Layer::Depth, 0);
                assert!((depth / found.mean(0, 0, Layer::Beauty, 0) - 1.0).abs() < 1e-6, "{scale}: {depth}");
            }
            assert_eq!(found.full_pixels(), 0);
        }
    }

    #[test]
    fn noise_of_one_sample_and_of_black_is_unknown() {
        assert_eq!(film(&[1.0]).noise(), None);
        assert_eq!(film(&[0.0, 0.0]).noise(), None);
        // Equal samples have no variance, however small they are: only the squares are rounded to double precision.
        assert!(film(&[1e-9, 1e-9]).noise().is_some_and(|noise| noise < 1e-7));
    }

    #[test]
    fn pixels_beyond_the_range_are_counted() {
        assert_eq!(film(&[1e18; 2]).full_pixels(), 1);
        assert_eq!(film(&[1e14; 2]).full_pixels(), 0);
    }
}
