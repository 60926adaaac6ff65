//! Decoded pixels, and the limit of their number.

use crate::error::Invalid;
use vellus_scene as scene;

/// The largest number of pixels. A pixel has 12 bytes at most, and decoding needs up to twice the memory of the pixels.
pub(super) const MAX_PIXELS: usize = 1 << 27;

/// A decoded image.
#[derive(Debug, PartialEq)]
pub(crate) struct Pixels {
    /// Pixels per row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Linear RGB, row by row from the top.
    pub rgb: scene::Pixels,
}

/// Checks the size in a header before memory is allocated for it. Returns the number of pixels.
pub(crate) fn checked_size(width: usize, height: usize) -> Result<usize, Invalid> {
    match width.checked_mul(height) {
        Some(pixels @ 1..=MAX_PIXELS) => Ok(pixels),
        _ => Err(format!("it claims {width} × {height} pixels: the number must be in [1, {MAX_PIXELS}]").into()),
    }
}
