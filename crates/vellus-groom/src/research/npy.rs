//! Arrays of NumPy: `.npy`, and `.npz` with several of them. Strands are an array of strands × points × 3.

use super::Polylines;
use crate::error::Error;
use glam::{Vec2, Vec3};
use std::io::{Cursor, Read};

/// Names of arrays with the points of strands, in this order.
const POINTS: [&str; 5] = ["positions", "strands", "points", "hair", "arr_0"];

/// Names of arrays with the texture coordinates of the roots.
const ROOT_UV: [&str; 4] = ["root_uv", "roots_uv", "uv", "uvs"];

/// The largest ratio of sizes that deflate has.
const DEFLATED: u64 = 1032;

/// An array of floating-point numbers.
struct Array {
    shape: Vec<usize>,
    /// In the order of C.
    values: Vec<f32>,
}

/// Reads a file.
pub(super) fn read(bytes: &[u8], name: &str) -> Result<Polylines, Error> {
    let fail = |what: String| Error::File { file: name.to_owned(), offset: 0, what };
    let (points, root_uv) = if bytes.starts_with(b"PK") {
        let mut archive =
            zip::ZipArchive::new(Cursor::new(bytes)).map_err(|error| fail(format!("broken .npz file: {error}")))?;
        let names: Vec<String> =
            archive.file_names().filter_map(|n| n.strip_suffix(".npy")).map(str::to_owned).collect();
        let mut array = |name: &str| -> Result<Array, Error> {
            let at = format!("{name}.npy");
            let mut entry = archive.by_name(&at).map_err(|error| fail(format!("{at}: {error}")))?;
            let most = entry.compressed_size().saturating_mul(DEFLATED).min(entry.size());
            let mut bytes = Vec::new();
            let read = (&mut entry).take(most).read_to_end(&mut bytes);
            read.map_err(|error| fail(format!("{at}: {error}")))?;
            parse(&bytes).map_err(|what| fail(format!("{at}: {what}")))
        };
        let known = POINTS.iter().find(|known| names.iter().any(|name| name == *known));
        let points = match known {
            Some(known) => array(known)?,
            None => {
                let mut all = Vec::new();
                for name in &names {
                    // Arrays of other types are no strands.
                    all.extend(array(name).ok().filter(is_strands).map(|array| (name, array)));
                }
                if all.len() > 1 {
                    let names: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
                    let what = "have strands: one must be called positions or strands";
                    return Err(fail(format!("the arrays {} {what}", names.join(", "))));
                }
                let what = || fail(format!("none of its arrays ({}) is strands × points × 3", names.join(", ")));
                all.pop().ok_or_else(what)?.1
            }
        };
        let uv = ROOT_UV.iter().find(|known| names.iter().any(|name| name == *known));
        (points, uv.map(|name| array(name)).transpose()?)
    } else {
        (parse(bytes).map_err(fail)?, None)
    };
    if !is_strands(&points) {
        return Err(fail(format!("its shape is {}: it must be strands × points × 3", told(&points.shape))));
    }
    let [count, length] = [points.shape[0], points.shape[1]];
    if u32::try_from(count * length).is_err() {
        return Err(fail(format!("{count} strands of {length} points are too many")));
    }
    let root_uv = root_uv.filter(|uv| uv.shape == [count, 2]);
    Ok(Polylines {
        starts: (0..=count).map(|i| (i * length) as u32).collect(),
        points: points.values.chunks_exact(3).map(Vec3::from_slice).collect(),
        colors: None,
        root_uv: root_uv.map(|uv| uv.values.chunks_exact(2).map(Vec2::from_slice).collect()),
    })
}

fn is_strands(array: &Array) -> bool {
    matches!(array.shape[..], [_, _, 3])
}

fn told(shape: &[usize]) -> String {
    format!("({})", shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", "))
}

/// Reads an array (NumPy Enhancement Proposal 1).
fn parse(bytes: &[u8]) -> Result<Array, String> {
    let broken = || "broken header of an array".to_owned();
    let (length, start) = match bytes {
        [0x93, b'N', b'U', b'M', b'P', b'Y', 1, _, a, b, ..] => (u32::from(u16::from_le_bytes([*a, *b])), 10),
        [0x93, b'N', b'U', b'M', b'P', b'Y', 2 | 3, _, a, b, c, d, ..] => (u32::from_le_bytes([*a, *b, *c, *d]), 12),
        _ => return Err("it is no array of NumPy".to_owned()),
    };
    let rest = bytes.get(start..).ok_or_else(broken)?;
    let (header, data) = rest.split_at_checked(length as usize).ok_or_else(broken)?;
    let header = std::str::from_utf8(header).map_err(|_| broken())?;
    let value = |key: &str| {
        let (_, after) = header.split_once(&format!("'{key}':"))?;
        Some(after.trim_start())
    };
    let kind = value("descr").and_then(|text| text.strip_prefix('\'')?.split('\'').next()).ok_or_else(broken)?;
    let is_fortran = value("fortran_order").ok_or_else(broken)?.starts_with("True");
    let list = value("shape").and_then(|text| text.strip_prefix('(')?.split(')').next()).ok_or_else(broken)?;
    let numbers = list.split(',').map(str::trim).filter(|text| !text.is_empty()).map(str::parse);
    let shape: Vec<usize> = numbers.collect::<Result<_, _>>().map_err(|_| broken())?;
    let (size, is_big): (usize, bool) = match kind {
        "<f2" | "<f4" | "<f8" => (usize::from(kind.as_bytes()[2] - b'0'), false),
        ">f2" | ">f4" | ">f8" => (usize::from(kind.as_bytes()[2] - b'0'), true),
        other => return Err(format!("its numbers are of the type {other}: they must be floating-point numbers")),
    };
    let count = shape.iter().try_fold(1usize, |product, side| product.checked_mul(*side));
    let needed = count.and_then(|count| count.checked_mul(size));
    let Some(data) = needed.and_then(|needed| data.get(..needed)) else {
        return Err(format!("its shape {} needs more than the {} bytes that are there", told(&shape), data.len()));
    };
    let number = |word: &[u8]| -> f32 {
        let mut all = [0u8; 8];
        all[..size].copy_from_slice(word);
        if is_big {
            all[..size].reverse();
        }
        match size {
            2 => half(u16::from_le_bytes([all[0], all[1]])),
            4 => f32::from_le_bytes([all[0], all[1], all[2], all[3]]),
            _ => f64::from_le_bytes(all) as f32,
        }
    };
    let values: Vec<f32> = data.chunks_exact(size).map(number).collect();
    if !is_fortran || shape.len() < 2 {
        return Ok(Array { shape, values });
    }
    // The place of each element when the first index is the fastest.
    let place = |mut index: usize| {
        let mut strides = vec![1; shape.len()];
        (1..shape.len()).for_each(|axis| strides[axis] = strides[axis - 1] * shape[axis - 1]);
        let mut place = 0;
        for (side, stride) in shape.iter().zip(strides).rev() {
            place += index % side * stride;
            index /= side;
        }
        place
    };
    let turned = (0..values.len()).map(|index| values[place(index)]).collect();
    Ok(Array { shape, values: turned })
}

/// A number of half precision: 1 bit for the sign, 5 for the exponent, 10 for the fraction.
fn half(bits: u16) -> f32 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f32::from(bits & 1023) / 1024.0);
    let size = match exponent {
        0 => fraction * 2f32.powi(-14),
        31 if fraction == 0.0 => f32::INFINITY,
        31 => f32::NAN,
        _ => (1.0 + fraction) * 2f32.powi(exponent - 15),
    };
    if bits >> 15 == 1 { -size } else { size }
}
