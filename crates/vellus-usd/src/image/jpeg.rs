//! Decodes JPEG: baseline and progressive, of eight bits.

use super::pixels::checked_size;
use super::samples::{Samples, Values};
use crate::error::Invalid;
use std::io::Cursor;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// How many pixels a byte can have: a block of 64 pixels has one bit or more.
const DENSEST: usize = 8 * 64;

/// The longest side that the format allows.
const LONGEST: usize = u16::MAX as usize;

/// Decodes a file, and tells what is damaged if only a part can be decoded.
pub(crate) fn decode(bytes: &[u8]) -> Result<(Samples, Option<String>), Invalid> {
    match attempt(bytes, true) {
        Ok(samples) => Ok((samples, None)),
        Err(Invalid(why)) => {
            attempt(bytes, false).map(|samples| (samples, Some(format!("is damaged, and parts of it are grey: {why}"))))
        }
    }
}

/// Decodes a file. `strict` stops at the first damage; otherwise the rest of the image is grey.
fn attempt(bytes: &[u8], strict: bool) -> Result<Samples, Invalid> {
    let broken = |error: zune_jpeg::errors::DecodeErrors| format!("broken JPEG image: {error}");
    let options = DecoderOptions::default().set_max_width(LONGEST).set_max_height(LONGEST).set_strict_mode(strict);
    let mut decoder = JpegDecoder::new_with_options(Cursor::new(bytes), options);
    decoder.decode_headers().map_err(broken)?;
    let info = decoder.info().ok_or("broken JPEG image: it has no size")?;
    let (width, height) = (usize::from(info.width), usize::from(info.height));
    let pixels = checked_size(width, height)?;
    if pixels / DENSEST > bytes.len() {
        return Err(format!("broken JPEG image: {} bytes cannot hold {width} × {height} pixels", bytes.len()).into());
    }
    let (space, channels) = if info.components == 1 { (ColorSpace::Luma, 1) } else { (ColorSpace::RGB, 3) };
    decoder.set_options(options.jpeg_set_out_colorspace(space));
    let data = decoder.decode().map_err(broken)?;
    if data.len() < pixels * channels {
        return Err("JPEG image of a kind that is not supported: it must be grey, RGB, YCbCr or CMYK".into());
    }
    Ok(Samples { width, height, channels, is_color: channels == 3, says_srgb: false, values: Values::Eight(data) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_file_cannot_claim_a_huge_image() {
        let mut bytes = super::super::tests::GREY_JPEG.to_vec();
        let frame = bytes.windows(2).position(|pair| pair == [0xff, 0xc0]).unwrap();
        bytes[frame + 5..frame + 9].copy_from_slice(&[0x20, 0, 0x20, 0]);
        let error = decode(&bytes).err().unwrap().0;
        assert!(error.contains("cannot hold 8192 × 8192 pixels"), "{error}");
    }
}
