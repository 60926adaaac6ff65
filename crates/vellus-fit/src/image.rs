//! Images of measurements: NPY and OpenEXR. NaN stands for what could not be measured.

use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// More values than this are taken for a garbled header.
const MOST: usize = 1 << 26;

/// Values row by row, the channels of a pixel together.
pub struct Pixels {
    pub width: usize,
    pub height: usize,
    pub channels: usize,
    pub values: Vec<f64>,
}

/// Of a header's sizes.
fn checked(height: usize, width: usize, channels: usize) -> Result<usize, String> {
    let count = height.checked_mul(width).and_then(|n| n.checked_mul(channels));
    count.filter(|n| (1..=MOST).contains(n)).ok_or_else(|| format!("it claims {height} × {width} × {channels} values"))
}

/// NumPy's format (NEP 1): a header in the syntax of Python, always the same three keys, and the values. No crate: those there
/// are bring a parser of Python with them.
pub fn npy(bytes: &[u8]) -> Result<Pixels, String> {
    let broken = || "broken NPY file".to_owned();
    let rest = bytes.strip_prefix(b"\x93NUMPY").ok_or("it is no NPY file")?;
    let (length, rest) = match rest {
        [1, _, a, b, rest @ ..] => (usize::from(u16::from_le_bytes([*a, *b])), rest),
        [2 | 3, _, a, b, c, d, rest @ ..] => (u32::from_le_bytes([*a, *b, *c, *d]) as usize, rest),
        _ => return Err(broken()),
    };
    let (head, data) = rest.split_at_checked(length).ok_or_else(broken)?;
    let head = std::str::from_utf8(head).map_err(|_| broken())?;
    let after =
        |key: &str| head.split_once(key).and_then(|(_, rest)| rest.split_once(':')).map(|(_, rest)| rest.trim());
    let kind = after("'descr'").and_then(|rest| rest.split('\'').nth(1)).ok_or_else(broken)?;
    if after("'fortran_order'").ok_or_else(broken)?.starts_with("True") {
        return Err("it is in Fortran's order: save numpy.ascontiguousarray of it".to_owned());
    }
    let shape = after("'shape'").and_then(|rest| rest.strip_prefix('(')?.split(')').next()).ok_or_else(broken)?;
    let shape = shape.split(',').map(str::trim).filter(|s| !s.is_empty()).map(str::parse::<usize>);
    let shape = shape.collect::<Result<Vec<usize>, _>>().map_err(|_| broken())?;
    let (height, width, channels) = match shape[..] {
        [height, width] => (height, width, 1),
        [height, width, channels @ (1 | 3)] => (height, width, channels),
        _ => return Err(format!("its shape is {shape:?}: expected rows, columns, and 3 channels or none")),
    };
    let count = checked(height, width, channels)?;
    let values: Vec<f64> = match kind {
        "<f8" => data.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect(),
        "<f4" => data.as_chunks::<4>().0.iter().map(|b| f64::from(f32::from_le_bytes(*b))).collect(),
        _ => return Err(format!("its values are of type {kind}: expected <f4 or <f8 (float32, float64)")),
    };
    if values.len() != count {
        return Err(format!("broken NPY file: {} values where its shape {shape:?} needs {count}", values.len()));
    }
    Ok(Pixels { width, height, channels, values })
}

/// R, G, B of the first layer that has them, or its only channel.
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
            _ => return Err("a layer with channels R, G, B or with one channel is needed".to_owned()),
        };
        let channels: Vec<Vec<f32>> = chosen.iter().map(|c| c.sample_data.values_as_f32().collect()).collect();
        let values =
            (0..size.area()).flat_map(|i| channels.iter().map(move |c| f64::from(c[i])).collect::<Vec<_>>()).collect();
        Ok(Pixels { width: size.width(), height: size.height(), channels: channels.len(), values })
    };
    // The crate is fuzzed, but what it decodes comes from anywhere: a panic is a broken file.
    let result: Result<Pixels, String> =
        catch_unwind(AssertUnwindSafe(read)).unwrap_or(Err("it cannot be decoded".to_owned()));
    result.map_err(|what| format!("broken OpenEXR image: {what}"))
}
