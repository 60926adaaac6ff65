//! Decodes PNG.

use super::pixels::checked_size;
use super::samples::{Samples, Values};
use crate::error::Invalid;
use std::io::Cursor;

/// Decodes a file.
pub(crate) fn decode(bytes: &[u8]) -> Result<Samples, Invalid> {
    let broken = |error: png::DecodingError| format!("broken PNG: {error}");
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(broken)?;
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    checked_size(width, height)?;
    let (color, depth) = reader.output_color_type();
    let says_srgb = reader.info().srgb.is_some();
    let mut data = vec![0; reader.output_buffer_size().ok_or("broken PNG: too large")?];
    reader.next_frame(&mut data).map_err(broken)?;
    let values = if depth == png::BitDepth::Sixteen {
        Values::Sixteen(data.as_chunks::<2>().0.iter().map(|&pair| u16::from_be_bytes(pair)).collect())
    } else {
        Values::Eight(data)
    };
    let channels = color.samples();
    Ok(Samples { width, height, channels, is_color: channels >= 3, says_srgb, values })
}
