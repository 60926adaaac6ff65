//! Layers of a film as plain numbers.

use crate::film::{Film, Layer};
use rayon::prelude::{IntoParallelIterator, ParallelIterator};

impl Film {
    /// The values of a layer, as in an OpenEXR file: all channels of a pixel side by side, row by row. Albedo, normal,
    /// depth and motion are means over the covered part of the pixel, tangent and root coordinates over the part that
    /// fibres cover. [`Layer::SecondMoment`] is the variance of the pixel's mean brightness. Layers of
    /// [`Layer::CRYPTOMATTE`] have pairs of an id, as the bits of a number, and its coverage.
    ///
    /// `None` if the film does not keep the layer, and for [`Layer::Strand`]: see [`Film::strand`].
    pub fn values(&self, layer: Layer) -> Option<Vec<f32>> {
        if !self.layout().has(layer) || layer == Layer::Strand {
            return None;
        }
        let (width, count) = (self.width(), self.width() * self.height());
        if Layer::CRYPTOMATTE.contains(&layer) {
            let channels = self.cryptomatte(layer);
            return Some((0..count).flat_map(|i| channels.iter().map(move |channel| channel[i])).collect());
        }
        let channels = self.layout().range(layer)?.len();
        let pixel = |i: usize| (0..channels).map(move |k| self.value(i % width, i / width, layer, k));
        Some((0..count).into_par_iter().flat_map_iter(pixel).collect())
    }
}
