//! Pictures for pages: a header and a PNG file.

use png::{BitDepth, ColorType, Compression, Encoder, Filter};
use serde::Serialize;

/// What a page needs to know about a picture.
#[derive(Clone, Debug, Serialize)]
pub struct Header {
    /// Counts pictures from 1.
    pub frame: u64,
    /// Number of the last command that the picture shows.
    pub revision: u64,
    /// Width and height of the picture.
    pub size: [usize; 2],
    /// Left, top, right, bottom of the part of the whole picture, in [0, 1].
    pub area: [f32; 4],
    /// Samples a pixel.
    pub samples: u64,
    /// Width of a pixel relative to the full resolution.
    pub coarse: usize,
    /// Relative noise, if known.
    pub noise: Option<f64>,
    /// Millions of rays per second.
    pub mrays: f64,
    /// Whether the picture is denoised.
    pub denoised: bool,
    /// Whether all samples are done.
    pub done: bool,
    /// Milliseconds from the first command that the picture shows to the end of its rendering; 0 if it shows no new
    /// command.
    pub latency: f64,
}

/// A picture in the form in which it is sent.
#[derive(Debug)]
pub struct Frame {
    /// Length of the header, header, PNG.
    pub bytes: Vec<u8>,
}

impl Frame {
    /// Encodes a picture of three bytes a pixel, row by row. `None` if the encoder fails.
    pub fn new(header: &Header, pixels: &[u8]) -> Option<Self> {
        let json = serde_json::to_vec(header).ok()?;
        let mut bytes = u32::try_from(json.len()).ok()?.to_le_bytes().to_vec();
        bytes.extend(&json);
        let [width, height] = header.size;
        let mut encoder = Encoder::new(&mut bytes, u32::try_from(width).ok()?, u32::try_from(height).ok()?);
        encoder.set_color(ColorType::Rgb);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_compression(Compression::Fastest);
        encoder.set_filter(Filter::Up);
        let mut writer = encoder.write_header().ok()?;
        writer.write_image_data(pixels).ok()?;
        writer.finish().ok()?;
        Some(Frame { bytes })
    }
}
