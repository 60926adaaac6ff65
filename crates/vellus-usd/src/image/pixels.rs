//! Decoded pixels, and the bound on how many there may be.

/// The most pixels of an image. Decoding takes up to twice the memory of the pixels, which have 12 bytes each.
pub(crate) const MOST_PIXELS: usize = 1 << 27;

pub(crate) type Pixels = (usize, usize, Vec<[f32; 3]>);

/// Checks a size that a header claims, before anything of that size is allocated.
pub(crate) fn checked_size(width: usize, height: usize) -> Result<usize, String> {
    match width.checked_mul(height) {
        Some(pixels @ 1..=MOST_PIXELS) => Ok(pixels),
        _ => Err(format!("it claims {width} × {height} pixels: there must be 1 to {MOST_PIXELS}")),
    }
}
