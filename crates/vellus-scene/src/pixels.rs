//! The pixels of an image: colours, or the bytes of a file with a table of what they mean.

use std::sync::Arc;

/// What each byte of each channel stands for, in linear light.
pub type Tables = [[f32; 256]; 3];

/// The pixels of an image in linear RGB, row by row from the top.
///
/// Images of eight bits stay as they are: a texture of 2048 × 2048 pixels needs 12 MB, or 4 MB if it is grey, and not
/// 50 MB.
#[derive(Clone, Debug)]
pub enum Pixels {
    /// Red, green and blue.
    Colors(Vec<[f32; 3]>),
    /// Bytes, which copies share.
    Bytes {
        /// `stride` bytes for each pixel.
        bytes: Arc<[u8]>,
        /// Bytes per pixel, at least 1.
        stride: usize,
        /// Which byte of a pixel is red, green and blue; each is below `stride`.
        channels: [usize; 3],
        /// What bytes stand for.
        tables: Arc<Tables>,
    },
}

impl Pixels {
    /// The number of pixels.
    pub fn len(&self) -> usize {
        match self {
            Pixels::Colors(colors) => colors.len(),
            Pixels::Bytes { bytes, stride, .. } => bytes.len() / (*stride).max(1),
        }
    }

    /// Whether there is no pixel.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The memory of the pixels, in bytes.
    pub fn size(&self) -> usize {
        match self {
            Pixels::Colors(colors) => size_of_val(&colors[..]),
            Pixels::Bytes { bytes, .. } => bytes.len(),
        }
    }

    /// The colour of a pixel.
    ///
    /// # Panics
    /// If there is no such pixel.
    #[inline]
    pub fn get(&self, i: usize) -> [f32; 3] {
        match self {
            Pixels::Colors(colors) => colors[i],
            Pixels::Bytes { bytes, stride, channels, tables } => {
                let pixel = &bytes[i * stride..(i + 1) * stride];
                std::array::from_fn(|c| tables[c][usize::from(pixel[channels[c]])])
            }
        }
    }

    /// All colours.
    pub fn iter(&self) -> impl Iterator<Item = [f32; 3]> + '_ {
        (0..self.len()).map(|i| self.get(i))
    }

    /// The mean colour; NaN without pixels.
    pub fn mean(&self) -> [f64; 3] {
        let count = self.len() as f64;
        let Pixels::Bytes { bytes, stride, channels, tables } = self else {
            let sum = self.iter().fold([0.0; 3], |sum, p| std::array::from_fn(|c| sum[c] + f64::from(p[c])));
            return sum.map(|x| x / count);
        };
        let mut counts = vec![[0usize; 256]; *stride];
        for pixel in bytes.chunks_exact(*stride) {
            pixel.iter().zip(&mut counts).for_each(|(&byte, counts)| counts[usize::from(byte)] += 1);
        }
        std::array::from_fn(|c| {
            let terms = counts[channels[c]].iter().zip(&tables[c]).filter(|(count, _)| **count > 0);
            terms.map(|(&count, &x)| count as f64 * f64::from(x)).sum::<f64>() / count
        })
    }

    /// Replaces each colour.
    pub fn map(&mut self, f: impl Fn([f32; 3]) -> [f32; 3]) {
        match self {
            Pixels::Colors(colors) => colors.iter_mut().for_each(|color| *color = f(*color)),
            Pixels::Bytes { .. } => *self = Pixels::Colors(self.iter().map(f).collect()),
        }
    }

    /// Replaces the channels of each colour, which have the indices 0 to 2. Bytes stay bytes.
    pub fn map_each(&mut self, f: impl Fn(usize, f32) -> f32) {
        match self {
            Pixels::Colors(colors) => {
                colors.iter_mut().for_each(|color| *color = std::array::from_fn(|c| f(c, color[c])));
            }
            Pixels::Bytes { tables, .. } => {
                *tables = Arc::new(std::array::from_fn(|c| tables[c].map(|x| f(c, x))));
            }
        }
    }

    /// Makes all channels equal to one of them, from 0 to 2.
    pub fn spread(&mut self, channel: usize) {
        match self {
            Pixels::Colors(colors) => colors.iter_mut().for_each(|color| *color = [color[channel]; 3]),
            Pixels::Bytes { channels, tables, .. } => {
                *channels = [channels[channel]; 3];
                *tables = Arc::new([tables[channel]; 3]);
            }
        }
    }

    /// The first pixel that has a channel for which this holds.
    pub(crate) fn position(&self, holds: impl Fn(f32) -> bool) -> Option<usize> {
        // Most tables have no such entry.
        if let Pixels::Bytes { tables, .. } = self
            && !tables.iter().flatten().any(|&x| holds(x))
        {
            return None;
        }
        self.iter().position(|color| color.iter().any(|&x| holds(x)))
    }
}

impl From<Vec<[f32; 3]>> for Pixels {
    fn from(colors: Vec<[f32; 3]>) -> Self {
        Pixels::Colors(colors)
    }
}

impl FromIterator<[f32; 3]> for Pixels {
    fn from_iter<I: IntoIterator<Item = [f32; 3]>>(colors: I) -> Self {
        Pixels::Colors(colors.into_iter().collect())
    }
}

/// Equal colours, however they are stored.
impl PartialEq for Pixels {
    fn eq(&self, other: &Self) -> bool {
        if let (
            Pixels::Bytes { bytes, channels, tables, .. },
            Pixels::Bytes { bytes: same, channels: known, tables: equal, .. },
        ) = (self, other)
            && Arc::ptr_eq(bytes, same)
            && (channels, tables) == (known, equal)
        {
            return true;
        }
        self.len() == other.len() && self.iter().eq(other.iter())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_the_colours_that_their_tables_say() {
        let table: [f32; 256] = std::array::from_fn(|i| i as f32 / 255.0);
        let tables = [table, table, table.map(|x| x * x)];
        let bytes = Pixels::Bytes {
            bytes: [51u8, 102, 204, 9, 0, 255, 51, 9].into(),
            stride: 4,
            channels: [0, 1, 2],
            tables: Arc::new(tables),
        };
        let colors = Pixels::from(vec![[0.2, 0.4, 0.8 * 0.8], [0.0, 1.0, 0.2 * 0.2]]);
        assert_eq!((bytes.len(), bytes.size(), &bytes), (2, 8, &colors));
        for c in 0..3 {
            assert!((bytes.mean()[c] - colors.mean()[c]).abs() < 1e-9);
        }
        let both = |change: fn(&mut Pixels)| {
            [bytes.clone(), colors.clone()].map(|mut pixels| {
                change(&mut pixels);
                pixels
            })
        };
        for change in [
            |pixels: &mut Pixels| pixels.spread(2),
            |pixels: &mut Pixels| pixels.map_each(|c, x| x * c as f32),
            |pixels: &mut Pixels| pixels.map(|[r, g, b]| [b, r, g + b]),
        ] {
            let [a, b] = both(change);
            assert_eq!(a, b);
        }
        assert_eq!(bytes.position(|x| x == 1.0), Some(1));
    }
}
