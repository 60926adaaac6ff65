//! Samples as a file stores them, and their conversion to linear RGB.

use super::Encoding;
use super::pixels::Pixels;
use crate::color::ColorSpace;
use glam::DVec3;
use std::sync::Arc;
use vellus_scene as scene;

/// The samples of an image, row by row from the top.
pub(crate) struct Samples {
    pub width: usize,
    pub height: usize,
    /// Samples per pixel.
    pub channels: usize,
    /// Whether the first three samples are red, green and blue. Otherwise the first is grey. Others are ignored.
    pub is_color: bool,
    /// Whether the file says that it is sRGB.
    pub says_srgb: bool,
    pub values: Values,
}

/// The numbers of an image. Whole ones are parts of the largest whole number.
pub(crate) enum Values {
    Eight(Vec<u8>),
    Sixteen(Vec<u16>),
    Float(Vec<f32>),
}

impl Values {
    /// The number of samples.
    pub fn len(&self) -> usize {
        match self {
            Values::Eight(data) => data.len(),
            Values::Sixteen(data) => data.len(),
            Values::Float(data) => data.len(),
        }
    }
}

impl Samples {
    /// Pixels in linear Rec. 709.
    pub fn pixels(self, encoding: Encoding) -> Pixels {
        let Samples { width, height, channels, is_color, says_srgb, values } = self;
        let is_srgb = says_srgb || is_color && matches!(values, Values::Eight(_));
        let space = match encoding {
            Encoding::Space(space) => space,
            Encoding::Auto if is_srgb => ColorSpace::SRGB,
            Encoding::Auto | Encoding::Alpha | Encoding::Profile(_) => ColorSpace::LINEAR,
        };
        // Which sample of a pixel becomes red, green and blue.
        let all = match (encoding, is_color) {
            (Encoding::Alpha, _) if channels == 1 || channels == 3 => {
                let pixel = scene::Pixels::from(vec![[1.0; 3]]);
                return Pixels { width: 1, height: 1, rgb: pixel };
            }
            (Encoding::Alpha, _) => [channels - 1; 3],
            (_, true) => [0, 1, 2],
            (_, false) => [0; 3],
        };
        let entry = |i: usize, most: u32| space.decode(i as f64 / f64::from(most)) as f32;
        let size = (width * height, channels, all);
        let rgb = match values {
            Values::Eight(mut data) => {
                data.truncate(width * height * channels);
                let table = std::array::from_fn(|i| entry(i, u8::MAX.into()));
                scene::Pixels::Bytes {
                    bytes: data.into(),
                    stride: channels,
                    channels: all,
                    tables: Arc::new([table; 3]),
                }
            }
            Values::Sixteen(data) => {
                let table: Vec<f32> = (0..=usize::from(u16::MAX)).map(|i| entry(i, u16::MAX.into())).collect();
                gather(&data, size, |x| table[usize::from(x)])
            }
            Values::Float(data) if space == ColorSpace::LINEAR => gather(&data, size, |x| x),
            Values::Float(data) => gather(&data, size, |x| space.decode(x.into()) as f32),
        };
        let mut pixels = Pixels { width, height, rgb };
        if let Some(matrix) = space.to_rec709() {
            let convert = |pixel: [f32; 3]| (matrix * DVec3::from(pixel.map(f64::from))).as_vec3().into();
            pixels.rgb.map(convert);
        }
        pixels
    }
}

/// Three samples of each pixel.
fn gather<T: Copy>(
    data: &[T],
    (count, channels, all): (usize, usize, [usize; 3]),
    value: impl Fn(T) -> f32,
) -> scene::Pixels {
    data.chunks_exact(channels).take(count).map(|pixel| all.map(|channel| value(pixel[channel]))).collect()
}
