//! What OpenEXR and PNG files of a picture have in common.

use super::exr::exr_notes;
use super::png::png_notes;
use crate::error::Error;

/// The type of the samples of a colour in an OpenEXR file. Distances, coordinates and variances are always `f32`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PixelType {
    /// 16 bits a channel. A layer whose values 16 bits cannot hold is stored in 32 bits.
    #[default]
    Half,
    /// 32 bits a channel.
    Float,
}

/// The note with the digest of a picture's pixels, in the files of [`Film::to_exr`](crate::Film::to_exr) and
/// [`Film::to_png`](crate::Film::to_png).
pub const PIXELS_NOTE: &str = "vellus_pixels";

/// Names and values of text attributes in a picture file.
pub type Notes = Vec<(String, String)>;

/// Checks the bytes of a file of [`Film::to_exr`](crate::Film::to_exr) or [`Film::to_png`](crate::Film::to_png), and
/// returns its notes.
///
/// # Errors
/// [`Error::Malformed`] if the file cannot be decoded, has no digest of its pixels, or has another one.
pub fn check_picture(bytes: &[u8]) -> Result<Notes, Error> {
    let read = if bytes.starts_with(b"\x89PNG") { png_notes(bytes) } else { exr_notes(bytes) };
    let (notes, digest) = read.map_err(Error::Malformed)?;
    match notes.iter().find(|(name, _)| name == PIXELS_NOTE) {
        None => Err(Error::Malformed("it carries no digest of its pixels".to_owned())),
        Some((_, expected)) if *expected == digest.to_string() => Ok(notes),
        Some(_) => Err(Error::Malformed("it is damaged: the digest of its pixels does not match".to_owned())),
    }
}

/// The largest ratio of decoded bytes to bytes of a file. Both formats compress with Deflate: a match of 258 bytes
/// takes at least two bits, so the ratio is at most 258 · 8 / 2.
const MOST_DEFLATED: u128 = 1032;

/// Checks the size in the header of a file of `file` bytes before the decoder allocates `decoded` bytes for its pixels.
/// A damaged header may claim any size, and a failed allocation ends the process.
pub(super) fn check_claim(decoded: u128, file: usize) -> Result<(), String> {
    if decoded > MOST_DEFLATED * file as u128 {
        return Err(format!("it claims {decoded} bytes of pixels: a file of {file} bytes has fewer"));
    }
    let room = usize::try_from(decoded).is_ok_and(|bytes| Vec::<u8>::new().try_reserve_exact(bytes).is_ok());
    if room { Ok(()) } else { Err(format!("it claims {decoded} bytes of pixels: the memory is too small")) }
}
