//! Images of measurements: NPY and OpenEXR. NaN stands for a missing value.

use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The largest number of values in an image: 2²⁶, which are 512 MiB in double precision.
const MOST: usize = 1 << 26;

/// Values in row-major order; the channels of a pixel are adjacent.
pub struct Pixels {
    pub width: usize,
    pub height: usize,
    pub channels: usize,
    pub values: Vec<f64>,
}

/// Checks the sizes that a header states.
fn checked(height: usize, width: usize, channels: usize) -> Result<usize, String> {
    let count = height.checked_mul(width).and_then(|n| n.checked_mul(channels));
    count
        .filter(|n| (1..=MOST).contains(n))
        .ok_or_else(|| format!("it claims {height} × {width} × {channels} values: expected 1 to {MOST}"))
}

/// Reads NumPy's format (NEP 1): a header in Python syntax with three fixed keys, then the values. The available
/// crates depend on a parser of Python, so this code reads the header itself.
pub fn npy(bytes: &[u8]) -> Result<Pixels, String> {
    let rest = bytes.strip_prefix(b"\x93NUMPY").ok_or("byte 0: it is no NPY file: expected \\x93NUMPY")?;
    let (start, length) = match rest {
        [1, _, a, b, ..] => (10, usize::from(u16::from_le_bytes([*a, *b]))),
        [2 | 3, _, a, b, c, d, ..] => (12, u32::from_le_bytes([*a, *b, *c, *d]) as usize),
        [1..=3, ..] | [] => return Err(format!("byte {}: the file ends in the header of the NPY format", bytes.len())),
        [version, ..] => return Err(format!("byte 6: version {version} of the NPY format: expected 1, 2 or 3")),
    };
    let (head, data) = bytes[start..].split_at_checked(length).ok_or_else(|| {
        format!("byte {}: the file ends in the header, which should have {length} bytes from byte {start}", bytes.len())
    })?;
    let head = std::str::from_utf8(head)
        .map_err(|e| format!("byte {}: the header is not UTF-8 text", start + e.valid_up_to()))?;
    let missing = |key: &str, expected: &str| format!("the header has no {key}: expected {expected}");
    let after =
        |key: &str| head.split_once(key).and_then(|(_, rest)| rest.split_once(':')).map(|(_, rest)| rest.trim());
    let kind = after("'descr'")
        .and_then(|rest| rest.split('\'').nth(1))
        .ok_or_else(|| missing("'descr'", "'descr': '<f4' or '<f8'"))?;
    let order = after("'fortran_order'").ok_or_else(|| missing("'fortran_order'", "'fortran_order': False"))?;
    if order.starts_with("True") {
        return Err("it is in Fortran's order: save numpy.ascontiguousarray of it".to_owned());
    }
    let dimensions = || {
        let text = after("'shape'")?.strip_prefix('(')?.split(')').next()?;
        let numbers = text.split(',').map(str::trim).filter(|s| !s.is_empty());
        numbers.map(str::parse::<usize>).collect::<Result<Vec<usize>, _>>().ok()
    };
    let shape = dimensions().ok_or_else(|| missing("'shape' of whole numbers", "'shape': (rows, columns)"))?;
    let (height, width, channels) = match shape[..] {
        [height, width] => (height, width, 1),
        [height, width, channels @ (1 | 3)] => (height, width, channels),
        _ => return Err(format!("its shape is {shape:?}: expected rows, columns, and 3 channels or none")),
    };
    let count = checked(height, width, channels)?;
    let size = match kind {
        "<f8" => 8,
        "<f4" => 4,
        _ => return Err(format!("its values are of type {kind}: expected <f4 or <f8 (float32, float64)")),
    };
    if data.len() != size * count {
        let start = start + length;
        return Err(format!(
            "{} bytes of values from byte {start}: its shape {shape:?} of {kind} needs {}",
            data.len(),
            size * count
        ));
    }
    let values = match size {
        8 => data.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect(),
        _ => data.as_chunks::<4>().0.iter().map(|b| f64::from(f32::from_le_bytes(*b))).collect(),
    };
    Ok(Pixels { width, height, channels, values })
}

/// Reads R, G, B of the first layer that has them, or the only channel of a layer.
pub fn exr(bytes: &[u8]) -> Result<Pixels, String> {
    use exr::prelude::{ReadChannels, ReadLayers};
    let read = || {
        let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|e| e.to_string())?;
        for header in &meta.headers {
            checked(header.layer_size.height(), header.layer_size.width(), header.channels.list.len())?;
        }
        let image = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .non_parallel()
            .from_buffered(Cursor::new(bytes))
            .map_err(|e| e.to_string())?;
        let (size, list) = (image.layer_data.size, &image.layer_data.channel_data.list);
        let named = |name: &str| list.iter().find(|c| c.name.to_string() == name);
        let chosen = match (["R", "G", "B"].map(named), &list[..]) {
            ([Some(r), Some(g), Some(b)], _) => vec![r, g, b],
            (_, [only]) => vec![only],
            _ => return Err("no layer has the channels R, G, B or exactly one channel".to_owned()),
        };
        let channels: Vec<Vec<f32>> = chosen.iter().map(|c| c.sample_data.values_as_f32().collect()).collect();
        let values =
            (0..size.area()).flat_map(|i| channels.iter().map(move |c| f64::from(c[i])).collect::<Vec<_>>()).collect();
        Ok(Pixels { width: size.width(), height: size.height(), channels: channels.len(), values })
    };
    // The decoder is fuzzed, but its input is untrusted: a panic counts as a broken file.
    let result: Result<Pixels, String> =
        catch_unwind(AssertUnwindSafe(read)).unwrap_or(Err("it cannot be decoded".to_owned()));
    result.map_err(|what| format!("broken OpenEXR image: {what}"))
}
