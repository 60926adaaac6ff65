//! Which layers a film keeps, and where each is in a pixel.

use crate::film::Layer;
use std::ops::Range;

/// Where the channels of each kept layer are. Beauty, alpha, square and fibers are always kept: noise, PNG and the means of other
/// layers are made of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    starts: [Option<usize>; Layer::ALL.len()],
    groups: Vec<String>,
    sums: usize,
}

impl Layout {
    /// Of these layers; `groups` are the names of the light groups, if [`Layer::Lights`] is one of them.
    pub fn new(layers: &[Layer], groups: &[String]) -> Self {
        let groups = if layers.contains(&Layer::Lights) { groups.to_vec() } else { Vec::new() };
        let mut layout = Layout { starts: [None; Layer::ALL.len()], groups, sums: 0 };
        for layer in Layer::ALL {
            if layer.always() || layers.contains(&layer) {
                layout.starts[layer as usize] = Some(layout.sums);
                layout.sums += layout.width(layer);
            }
        }
        // The id is no sum, and comes last.
        layout.sums -= usize::from(layout.has(Layer::Strand));
        layout
    }

    /// Channels of a layer.
    fn width(&self, layer: Layer) -> usize {
        if layer == Layer::Lights { 3 * self.groups.len() } else { layer.channels() }
    }

    /// Where a layer's channels begin; `None` where it is not kept.
    pub fn start(&self, layer: Layer) -> Option<usize> {
        self.starts[layer as usize]
    }

    /// Where a layer's channels are; `None` where it is not kept.
    pub fn range(&self, layer: Layer) -> Option<Range<usize>> {
        self.start(layer).map(|start| start..start + self.width(layer))
    }

    /// Is it kept?
    pub fn has(&self, layer: Layer) -> bool {
        self.start(layer).is_some()
    }

    /// Names of the light groups that are kept.
    pub fn groups(&self) -> &[String] {
        &self.groups
    }

    /// Channels that are sums: the first ones.
    pub fn sums(&self) -> usize {
        self.sums
    }

    /// All channels.
    pub fn channels(&self) -> usize {
        self.sums + usize::from(self.has(Layer::Strand))
    }

    /// The layers as bits, in the order of [`Layer::ALL`].
    pub(crate) fn bits(&self) -> u32 {
        (0..Layer::ALL.len()).filter(|&i| self.starts[i].is_some()).map(|i| 1 << i).sum()
    }

    /// From [`Layout::bits`] and the names of groups.
    pub(crate) fn from_bits(bits: u32, groups: &[String]) -> Self {
        let layers: Vec<Layer> = Layer::ALL.into_iter().filter(|&l| bits >> l as usize & 1 == 1).collect();
        Layout::new(&layers, groups)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_asked_for_is_kept() {
        let groups = ["key".to_owned(), "rim".to_owned()];
        let all = Layout::new(&Layer::ALL, &groups);
        assert_eq!(all.channels(), Layer::ALL.iter().map(|l| l.channels()).sum::<usize>() + 6);
        assert_eq!((all.sums() + 1, all.start(Layer::Strand)), (all.channels(), Some(all.sums())));
        assert_eq!(all.range(Layer::Lights).map(|r| r.len()), Some(6));
        let few = Layout::new(&[Layer::Depth], &groups);
        assert_eq!((few.channels(), few.start(Layer::Depth), few.start(Layer::Lobes)), (7, Some(6), None));
        assert!(few.groups().is_empty());
        for layout in [all, few] {
            assert_eq!(Layout::from_bits(layout.bits(), &groups), layout);
        }
    }
}
