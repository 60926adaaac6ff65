//! Decodes TIFF: grey or RGB, with or without alpha, as whole numbers of 8, 16 or 32 bits or as floats.

use super::pixels::{MAX_PIXELS, checked_size};
use super::samples::{Samples, Values};
use crate::error::Invalid;
use std::io::Cursor;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::{ColorType, TiffError};

/// The most bytes of decoded samples: four floats in each pixel.
const MAX_BYTES: usize = 16 * MAX_PIXELS;

/// Decodes the first image of a file.
pub(crate) fn decode(bytes: &[u8]) -> Result<Samples, Invalid> {
    let broken = |error: TiffError| match error {
        TiffError::UnsupportedError(what) => format!("TIFF image of a kind that is not supported: {what}"),
        error => format!("broken TIFF image: {error}"),
    };
    let mut limits = Limits::default();
    limits.decoding_buffer_size = MAX_BYTES;
    // A table of a file is not larger than the file.
    limits.ifd_value_size = bytes.len();
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(broken)?.with_limits(limits);
    let (width, height) = decoder.dimensions().map_err(broken)?;
    let (width, height) = (width as usize, height as usize);
    let pixels = checked_size(width, height)?;
    let color = decoder.colortype().map_err(broken)?;
    let is_color = match color {
        ColorType::RGB(_) | ColorType::RGBA(_) => true,
        // Grey with further samples has several bands.
        ColorType::Gray(_) | ColorType::GrayA(_) | ColorType::Multiband { .. } => false,
        other => return Err(format!("TIFF image with the colours {other:?}: they must be grey or RGB").into()),
    };
    if color.bit_depth() < 8 {
        return Err(format!("TIFF image with {} bits for each sample: at least 8 are needed", color.bit_depth()).into());
    }
    let mut data = DecodingResult::U8(Vec::new());
    let planes = decoder.read_image_to_buffer(&mut data).map_err(broken)?.planes;
    let values = match data {
        DecodingResult::U8(data) => Values::Eight(interleaved(data, planes)),
        DecodingResult::U16(data) => Values::Sixteen(interleaved(data, planes)),
        DecodingResult::U32(data) => {
            let part = |x: u32| (f64::from(x) / f64::from(u32::MAX)) as f32;
            Values::Float(interleaved(data, planes).into_iter().map(part).collect())
        }
        DecodingResult::F16(data) => Values::Float(interleaved(data, planes).into_iter().map(f32::from).collect()),
        DecodingResult::F32(data) => Values::Float(interleaved(data, planes)),
        _ => return Err("TIFF image with signed or 64-bit samples, which are not supported".into()),
    };
    let channels = usize::from(color.num_samples());
    if values.len() < pixels * channels {
        return Err(format!("TIFF image of {channels} samples for each pixel: it has more than 2 GiB").into());
    }
    Ok(Samples { width, height, channels, is_color, says_srgb: false, values })
}

/// The samples pixel by pixel, of planes that a file stores one after the other.
fn interleaved<T: Copy>(data: Vec<T>, planes: usize) -> Vec<T> {
    let size = data.len() / planes.max(1);
    if planes <= 1 {
        data
    } else {
        (0..size).flat_map(|i| (0..planes).map(move |p| p * size + i)).map(|i| data[i]).collect()
    }
}
