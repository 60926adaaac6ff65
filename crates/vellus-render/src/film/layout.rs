//! Which layers a film keeps, and where they are in a pixel.

use crate::film::Layer;
use crate::film::cryptomatte::Thing;
use crate::film::sums::Format;
use std::ops::Range;

/// A layer that a film keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Kept {
    /// The format of its sums.
    pub format: Format,
    /// Its first channel, number of channels, and first word in a pixel.
    pub channel: usize,
    pub width: usize,
    pub word: usize,
}

impl Kept {
    /// The words of one of its channels within a pixel.
    pub fn words(&self, channel: usize) -> Range<usize> {
        let start = self.word + channel * self.format.words();
        start..start + self.format.words()
    }

    /// The words of all its channels within a pixel.
    pub fn all_words(&self) -> Range<usize> {
        self.word..self.word + self.width * self.format.words()
    }
}

/// The layers and channels of a film. Every film keeps beauty, alpha, the second moment and the fibres' coverage:
/// noise, PNG files and the means of other layers are computed from them.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    kept: [Option<Kept>; Layer::ALL.len()],
    groups: Vec<String>,
    things: Vec<Thing>,
    channels: usize,
    words: usize,
}

impl Layout {
    /// The layout of these layers. `groups` are the names of the light groups, for [`Layer::Lights`].
    pub fn new(layers: &[Layer], groups: &[String]) -> Self {
        let groups = if layers.contains(&Layer::Lights) { groups.to_vec() } else { Vec::new() };
        let mut layout = Layout { kept: [None; Layer::ALL.len()], groups, things: Vec::new(), channels: 0, words: 0 };
        for layer in Layer::ALL {
            if layer.always() || layers.contains(&layer) {
                let (format, width) = (Format::of(layer), layout.width(layer));
                let kept = Kept { format, channel: layout.channels, width, word: layout.words };
                layout.kept[layer as usize] = Some(kept);
                layout.channels += width;
                layout.words += width * format.words();
            }
        }
        layout
    }

    /// The same layout with the names for [`Layer::CRYPTOMATTE`]. They are only kept with one of these layers.
    pub fn with_things(mut self, things: &[Thing]) -> Self {
        self.things = if self.has_counts() { things.to_vec() } else { Vec::new() };
        self
    }

    /// Whether the film counts the things of each pixel.
    pub(crate) fn has_counts(&self) -> bool {
        Layer::CRYPTOMATTE.into_iter().any(|layer| self.has(layer))
    }

    /// What camera rays can hit, if the film keeps a layer of [`Layer::CRYPTOMATTE`].
    pub fn things(&self) -> &[Thing] {
        &self.things
    }

    /// The number of channels of a layer.
    fn width(&self, layer: Layer) -> usize {
        if layer == Layer::Lights { 3 * self.groups.len() } else { layer.channels() }
    }

    /// A layer, if the film keeps it.
    pub(crate) fn kept(&self, layer: Layer) -> Option<&Kept> {
        self.kept[layer as usize].as_ref()
    }

    /// All layers of the film, in the order of their words.
    pub(crate) fn all_kept(&self) -> impl Iterator<Item = &Kept> {
        self.kept.iter().flatten()
    }

    /// The first channel of a layer; `None` if the film does not keep it.
    pub fn start(&self, layer: Layer) -> Option<usize> {
        self.kept(layer).map(|kept| kept.channel)
    }

    /// The channels of a layer; `None` if the film does not keep it.
    pub fn range(&self, layer: Layer) -> Option<Range<usize>> {
        self.kept(layer).map(|kept| kept.channel..kept.channel + kept.width)
    }

    /// Whether the film keeps a layer.
    pub fn has(&self, layer: Layer) -> bool {
        self.kept(layer).is_some()
    }

    /// Names of the light groups, if the film keeps [`Layer::Lights`].
    pub fn groups(&self) -> &[String] {
        &self.groups
    }

    /// The number of all channels.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Number of 32-bit words per pixel.
    pub(crate) fn words(&self) -> usize {
        self.words
    }

    /// Bytes of a film for each pixel. With a layer of [`Layer::CRYPTOMATTE`], each thing in a pixel takes 12 bytes
    /// more.
    pub fn bytes_per_pixel(&self) -> usize {
        4 * self.words
    }

    /// The layers as bits, in the order of [`Layer::ALL`].
    pub(crate) fn bits(&self) -> u32 {
        (0..Layer::ALL.len()).filter(|&i| self.kept[i].is_some()).map(|i| 1 << i).sum()
    }

    /// The layout of [`Layout::bits`] and the names of the light groups.
    pub(crate) fn from_bits(bits: u32, groups: &[String]) -> Self {
        let layers: Vec<Layer> = Layer::ALL.into_iter().filter(|&l| bits >> l as usize & 1 == 1).collect();
        Layout::new(&layers, groups)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_chosen_layers_are_kept() {
        let groups = ["key".to_owned(), "rim".to_owned()];
        let all = Layout::new(&Layer::ALL, &groups);
        assert_eq!(all.channels(), Layer::ALL.iter().map(|l| l.channels()).sum::<usize>() + 6);
        assert_eq!(all.range(Layer::Lights).map(|r| r.len()), Some(6));
        let few = Layout::new(&[Layer::Depth], &groups);
        assert_eq!((few.channels(), few.start(Layer::Depth), few.start(Layer::Lobes)), (7, Some(6), None));
        assert!(few.groups().is_empty());
        for layout in [all, few] {
            assert_eq!(Layout::from_bits(layout.bits(), &groups), layout);
        }
    }

    #[test]
    fn a_channel_takes_at_most_twelve_bytes_on_average() {
        // `vellus render` keeps all layers but motion and lights.
        let usual: Vec<Layer> =
            Layer::ALL.into_iter().filter(|layer| !matches!(layer, Layer::Motion | Layer::Lights)).collect();
        let layout = Layout::new(&usual, &[]);
        assert!(layout.bytes_per_pixel() <= 12 * layout.channels(), "{}", layout.bytes_per_pixel());
    }
}
