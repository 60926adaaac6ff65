//! Decodes the Radiance format (.hdr, .pic): RGB with a shared exponent, uncompressed or run-length encoded.
//!
//! G. Ward, *Real Pixels*, Graphics Gems II, 1991; both run-length schemes of Radiance's color.c.

use super::pixels::{Pixels, checked_size};
use crate::error::Invalid;

/// Decodes a file.
pub(crate) fn decode(bytes: &[u8]) -> Result<Pixels, Invalid> {
    let mut input = bytes;
    let mut exposure = 1.0f32;
    loop {
        let line = take_line(&mut input)?;
        if line.is_empty() {
            break;
        }
        if let Some(format) = line.strip_prefix("FORMAT=")
            && format.trim() != "32-bit_rle_rgbe"
        {
            return Err(
                format!("Radiance image of the format {}: only 32-bit_rle_rgbe is supported", shown(format)).into()
            );
        }
        if let Some(factor) = line.strip_prefix("EXPOSURE=").and_then(|x| x.trim().parse::<f32>().ok()) {
            // Stored pixels are multiplied by the exposure. The result must not be.
            exposure *= factor;
        }
    }
    if !(exposure.is_finite() && exposure > 0.0) {
        return Err(format!("Radiance image with an exposure of {exposure}: it must be positive").into());
    }
    let line = take_line(&mut input)?;
    let words: Vec<&str> = line.split_whitespace().collect();
    let (width, height) = match words[..] {
        ["-Y", height, "+X", width] => match (width.parse(), height.parse()) {
            (Ok(width), Ok(height)) => (width, height),
            _ => return Err(format!("Radiance image with a garbled size: {}", shown(line)).into()),
        },
        _ => {
            return Err(format!(
                "Radiance image with the size and order {}: only -Y height +X width is supported",
                shown(line)
            )
            .into());
        }
    };
    checked_size(width, height)?;

    // Rows are appended one by one, so a wrong size allocates nothing.
    let mut pixels = Vec::new();
    for row in 0..height {
        let cut = |()| format!("broken Radiance image: it ends or is garbled in row {row} of {height}");
        let scanline = match *input {
            [2, 2, high, low, ..] if (8..32768).contains(&width) && high < 128 => {
                if usize::from(high) << 8 | usize::from(low) != width {
                    return Err(cut(()).into());
                }
                input = &input[4..];
                packed_row(&mut input, width).map_err(cut)?
            }
            _ => plain_row(&mut input, width).map_err(cut)?,
        };
        pixels.extend(scanline.into_iter().map(|[r, g, b, e]| {
            // In double precision, because 2^(e − 136) alone may underflow in single precision.
            let scale = if e == 0 { 0.0 } else { 2f64.powi(i32::from(e) - 136) / f64::from(exposure) };
            [r, g, b].map(|x| (f64::from(x) * scale) as f32)
        }));
    }
    Ok(Pixels { width, height, rgb: pixels.into() })
}

fn shown(text: &str) -> String {
    vellus_io::excerpt(text.as_bytes(), 40)
}

fn take_line<'a>(input: &mut &'a [u8]) -> Result<&'a str, Invalid> {
    let end = input.iter().position(|&b| b == b'\n').ok_or("broken Radiance image: its header does not end")?;
    let (line, rest) = (&input[..end], &input[end + 1..]);
    *input = rest;
    std::str::from_utf8(line).map(str::trim_end).map_err(|_| "broken Radiance image: its header is not text".into())
}

fn take(input: &mut &[u8]) -> Result<u8, ()> {
    let (&first, rest) = input.split_first().ok_or(())?;
    *input = rest;
    Ok(first)
}

/// Decodes a row with the four channels one after the other. Each is a sequence of runs (a length above 128 and a
/// value) and literals (a length and values).
fn packed_row(input: &mut &[u8], width: usize) -> Result<Vec<[u8; 4]>, ()> {
    let mut row = vec![[0; 4]; width];
    for channel in 0..4 {
        let mut x = 0;
        while x < width {
            let length = take(input)?;
            let (count, is_run) = if length > 128 { (length - 128, true) } else { (length, false) };
            let end = x + usize::from(count);
            if count == 0 || end > width {
                return Err(());
            }
            let value = if is_run { take(input)? } else { 0 };
            for pixel in &mut row[x..end] {
                pixel[channel] = if is_run { value } else { take(input)? };
            }
            x = end;
        }
    }
    Ok(row)
}

/// Decodes a row pixel by pixel. (1, 1, 1, n) repeats the last pixel n times. Several of them in sequence are the
/// digits of a count in base 256.
fn plain_row(input: &mut &[u8], width: usize) -> Result<Vec<[u8; 4]>, ()> {
    let mut row: Vec<[u8; 4]> = Vec::new();
    let mut shift = 0;
    while row.len() < width {
        let pixel = [take(input)?, take(input)?, take(input)?, take(input)?];
        if let [1, 1, 1, n] = pixel {
            let count = usize::from(n).checked_shl(shift).ok_or(())?;
            let last = *row.last().ok_or(())?;
            if count > width - row.len() {
                return Err(());
            }
            row.resize(row.len() + count, last);
            shift += 8;
        } else {
            row.push(pixel);
            shift = 0;
        }
    }
    Ok(row)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "#?RADIANCE\n# made by hand\nFORMAT=32-bit_rle_rgbe\n\n";

    #[test]
    fn plain_and_both_run_length_schemes_agree() {
        // 128/256 · 2^(129 − 128) = 1.
        let plain = [HEADER.as_bytes(), b"-Y 1 +X 8\n", &[128, 64, 0, 129].repeat(8)].concat();
        let expected = Pixels { width: 8, height: 1, rgb: vec![[1.0, 0.5, 0.0]; 8].into() };
        assert_eq!(decode(&plain).unwrap(), expected);
        let old = [HEADER.as_bytes(), b"-Y 1 +X 8\n", &[128, 64, 0, 129, 1, 1, 1, 7]].concat();
        assert_eq!(decode(&old).unwrap(), expected);
        let runs = [2, 2, 0, 8, 136, 128, 136, 64, 3, 0, 0, 0, 133, 0, 136, 129];
        let packed = [HEADER.as_bytes(), b"-Y 1 +X 8\n", &runs].concat();
        assert_eq!(decode(&packed).unwrap(), expected);
        let brighter = decode(&[b"#?RADIANCE\nEXPOSURE=0.5\n\n-Y 1 +X 1\n".as_slice(), &[128, 64, 0, 129]].concat());
        assert_eq!(brighter.unwrap().rgb.get(0), [2.0, 1.0, 0.0]);
    }

    #[test]
    fn other_formats_and_orders_are_named() {
        let error = |text: &[u8]| decode(text).unwrap_err().0;
        assert!(error(b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n").contains("xyze"));
        assert!(error(b"#?RADIANCE\n\n+Y 1 +X 1\n").contains("+Y 1 +X 1"));
        assert!(error(b"#?RADIANCE\n\n-Y 2 +X 1\n\x01\x02\x03\x04").contains("row 1 of 2"));
    }
}
