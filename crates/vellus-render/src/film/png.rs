//! Films as PNG files.

use super::picture::{Notes, PIXELS_NOTE, check_claim};
use super::tone::Display;
use crate::error::Error;
use crate::film::{Film, Layer};
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use std::io::Cursor;
use vellus_io::Digest;

impl Film {
    /// The means of the three channels of a layer, pixel by pixel and row by row. `None` if the film does not keep the
    /// layer, or the layer does not have three channels.
    pub fn rgb(&self, layer: Layer) -> Option<Vec<f32>> {
        let kept = self.layout().range(layer).is_some_and(|range| range.len() == 3);
        let places =
            || (0..self.height()).flat_map(|y| (0..self.width()).flat_map(move |x| [0, 1, 2].map(|c| (x, y, c))));
        kept.then(|| places().map(|(x, y, c)| self.mean(x, y, layer, c) as f32).collect())
    }

    /// The beauty as eight-bit sRGB, three bytes a pixel, row by row.
    pub fn to_srgb(&self, display: Display) -> Vec<u8> {
        self.layer_to_srgb(Layer::Beauty, 0, display)
    }

    fn layer_to_srgb(&self, layer: Layer, first: usize, display: Display) -> Vec<u8> {
        self.encoded(display, |x, y, c| self.mean(x, y, layer, first + c))
    }

    /// A denoised beauty, three values a pixel, as eight-bit sRGB.
    pub fn denoised_to_srgb(&self, denoised: &[f32], display: Display) -> Vec<u8> {
        self.encoded(display, |x, y, c| f64::from(denoised[3 * (y * self.width() + x) + c]))
    }

    fn encoded(&self, display: Display, value: impl Fn(usize, usize, usize) -> f64 + Sync) -> Vec<u8> {
        let alpha = |x, y| self.mean(x, y, Layer::Alpha, 0).clamp(0.0, 1.0);
        let pixel = |(x, y)| display.encode([0, 1, 2].map(|c| value(x, y, c)), alpha(x, y));
        let row = |y| (0..self.width()).map(move |x| (x, y)).flat_map(pixel);
        (0..self.height()).into_par_iter().flat_map_iter(row).collect()
    }

    /// The bytes of a PNG file of three channels of a layer, from its channel `first` on, times 2^`exposure`, without a
    /// tone curve.
    ///
    /// # Errors
    /// [`Error::Encode`] with what the encoder reports.
    pub fn layer_to_png(&self, layer: Layer, first: usize, exposure: f32) -> Result<Vec<u8>, Error> {
        self.encode_png(&self.layer_to_srgb(layer, first, Display::srgb(exposure)), png::ColorType::Rgb, &[])
    }

    /// The bytes of a PNG file of the beauty, or of `denoised` (three values a pixel), with text chunks for `notes`
    /// (names and values).
    ///
    /// # Errors
    /// [`Error::Encode`] with what the encoder reports.
    pub fn to_png(
        &self,
        denoised: Option<&[f32]>,
        display: Display,
        notes: &[(String, String)],
    ) -> Result<Vec<u8>, Error> {
        let pixels = match denoised {
            Some(denoised) => self.denoised_to_srgb(denoised, display),
            None => self.to_srgb(display),
        };
        self.encode_png(&pixels, png::ColorType::Rgb, notes)
    }

    /// As [`Film::to_png`], with an alpha channel: the share of each pixel that objects cover. The colours are those of
    /// the objects, as PNG requires: the beauty divided by alpha. The background must be black.
    ///
    /// # Errors
    /// [`Error::Encode`] with what the encoder reports.
    pub fn to_transparent_png(
        &self,
        denoised: Option<&[f32]>,
        display: Display,
        notes: &[(String, String)],
    ) -> Result<Vec<u8>, Error> {
        let mut pixels = Vec::with_capacity(4 * self.width() * self.height());
        for (i, (x, y)) in (0..self.height()).flat_map(|y| (0..self.width()).map(move |x| (x, y))).enumerate() {
            let alpha = self.mean(x, y, Layer::Alpha, 0).clamp(0.0, 1.0);
            let beauty = |c: usize| match denoised {
                Some(denoised) => f64::from(denoised[3 * i + c]),
                None => self.mean(x, y, Layer::Beauty, c),
            };
            let color = [0, 1, 2].map(|c| if alpha > 0.0 { beauty(c) / alpha } else { 0.0 });
            pixels.extend(display.encode(color, 1.0));
            pixels.push((255.0 * alpha).round() as u8);
        }
        self.encode_png(&pixels, png::ColorType::Rgba, notes)
    }

    fn encode_png(&self, pixels: &[u8], color: png::ColorType, notes: &[(String, String)]) -> Result<Vec<u8>, Error> {
        let failed = |e: png::EncodingError| Error::Encode { format: "PNG", what: e.to_string() };
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width() as u32, self.height() as u32);
        encoder.set_color(color);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let digest = (PIXELS_NOTE.to_owned(), Digest::of(pixels).to_string());
        for (name, value) in notes.iter().chain([&digest]) {
            encoder.add_itxt_chunk(name.clone(), value.clone()).map_err(failed)?;
        }
        let mut writer = encoder.write_header().map_err(failed)?;
        writer.write_image_data(pixels).map_err(failed)?;
        writer.finish().map_err(failed)?;
        Ok(bytes)
    }
}

/// The notes of a file, and the digest of its pixels.
pub(super) fn png_notes(bytes: &[u8]) -> Result<(Notes, Digest), String> {
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().map_err(|e| e.to_string())?;
    let size = reader.output_buffer_size().ok_or("it is too large")?;
    check_claim(size as u128, bytes.len())?;
    let mut pixels = vec![0; size];
    reader.next_frame(&mut pixels).map_err(|e| e.to_string())?;
    // The chunks after the pixels may be cut off.
    reader.finish().map_err(|e| e.to_string())?;
    let text = |chunk: &png::text_metadata::ITXtChunk| Some((chunk.keyword.clone(), chunk.get_text().ok()?));
    Ok((reader.info().utf8_text.iter().filter_map(text).collect(), Digest::of(&pixels)))
}
