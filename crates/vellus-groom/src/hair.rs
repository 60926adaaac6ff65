//! Reads and writes Cem Yuksel's `.hair` files: a header of 128 bytes, followed by arrays, in little-endian.
//!
//! ```text
//! 0 "HAIR"   4 strands u32   8 points u32   12 flags of arrays u32   16 segments u32   20 thickness f32
//! 24 transparency f32   28 colour 3 × f32   40 information, 88 bytes
//! arrays: segments u16 per strand; per point position 3 × f32, thickness f32, transparency f32, colour 3 × f32
//! ```

use crate::bytes::{Bytes, MAX_WIDTH, given_width};
use crate::error::Error;
use glam::Vec4;
use vellus_scene::{Basis, Parameter, Strands, Values};

const HEADER: usize = 128;
const SEGMENTS: u32 = 1;
const POINTS: u32 = 2;
const THICKNESS: u32 = 4;
const TRANSPARENCY: u32 = 8;
const COLORS: u32 = 16;

/// Reads the strands of a `.hair` file as [`Basis::Linear`]. `name` is used in messages and becomes the name of the
/// strands.
///
/// Diameters are the thickness of each point if the file has it, otherwise `width` if it is set, otherwise the default
/// of the file. Colours of points become [`Parameter::Reflectance`] as linear RGB. Transparency and the default colour
/// are ignored: [`hair_header`] has them.
///
/// Strands with one point, or with numbers of which nothing can be rendered, are there too:
/// [`Strands::remove_broken`] removes them.
///
/// # Errors
/// [`Error::File`] if the file is invalid. [`Error::NoWidth`] if there is no width at all. [`Error::Width`] if `width`
/// is not in [0, 2·10⁹].
pub fn read_hair(bytes: &[u8], name: &str, width: Option<f32>) -> Result<Strands, Error> {
    let width = given_width(width)?;
    let file = Bytes { file: name, bytes };
    check_header(&file)?;
    let [count, points, arrays] = [file.u32(4, "strands")?, file.u32(8, "points")?, file.u32(12, "arrays")?];
    let (count, total) = (count as usize, points as usize);
    if arrays & POINTS == 0 {
        return Err(file.fail(12, "the file has no points according to its header"));
    }

    let mut offset = HEADER;
    let mut next = |present: u32, items: usize, size: usize| {
        let start = offset;
        offset = offset.saturating_add(if arrays & present == 0 { 0 } else { items.saturating_mul(size) });
        start
    };
    let [segments_at, points_at] = [next(SEGMENTS, count, 2), next(POINTS, total, 12)];
    let thickness_at = next(THICKNESS, total, 4);
    next(TRANSPARENCY, total, 4);
    let colors_at = next(COLORS, total, 12);

    let starts = starts(&file, arrays & SEGMENTS != 0, segments_at, count, total)?;
    let positions = file.points(points_at, total, 12)?;
    let thickness = if arrays & THICKNESS != 0 {
        Some(file.floats(thickness_at, total, "thicknesses", |_| true, "")?)
    } else {
        None
    };
    let default = width.or(default_thickness(&file)?);
    let radius = |i: usize| thickness.as_ref().map_or(default, |t| Some(t[i])).map(|t| 0.5 * t);
    let points = positions.iter().enumerate().map(|(i, p)| radius(i).map(|r| p.extend(r)));
    let points: Option<Vec<Vec4>> = points.collect();
    let mut varying = Vec::new();
    if arrays & COLORS != 0 {
        let good = |x: f32| x.is_nan() || (0.0..=1.0).contains(&x);
        let colors = file.floats(colors_at, total.saturating_mul(3), "colours", good, "a channel must be in [0, 1]")?;
        let colors = colors.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
        varying.push((Parameter::Reflectance, Values::PerPoint(colors)));
    }
    Ok(Strands {
        name: name.to_owned(),
        basis: Basis::Linear,
        starts,
        points: points.ok_or_else(|| Error::NoWidth { file: name.to_owned() })?,
        moved: None,
        normals: None,
        root_uv: None,
        look: 0,
        varying,
    })
}

fn check_header(file: &Bytes) -> Result<(), Error> {
    if file.array(0, 1, HEADER, "header")?[..4] == *b"HAIR" {
        Ok(())
    } else {
        Err(file.fail(0, "a .hair file begins with HAIR"))
    }
}

/// The thickness in the header, if it can be one.
fn default_thickness(file: &Bytes) -> Result<Option<f32>, Error> {
    let default = file.f32(20, "thickness")?;
    Ok((default > 0.0 && default <= MAX_WIDTH).then_some(default))
}

/// What the header of a `.hair` file says of all points. A default is `None` if the file has an array in its place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HairHeader {
    /// The diameter in the unit of the file, if it is positive. [`read_hair`] uses it without another width.
    pub thickness: Option<f32>,
    /// The transparency, from 0 to 1.
    pub transparency: Option<f32>,
    /// The colour, RGB.
    pub color: Option<[f32; 3]>,
}

/// Reads the header of a `.hair` file. `name` is used in messages.
///
/// # Errors
/// [`Error::File`] if the file has no such header.
pub fn hair_header(bytes: &[u8], name: &str) -> Result<HairHeader, Error> {
    let file = Bytes { file: name, bytes };
    check_header(&file)?;
    let arrays = file.u32(12, "arrays")?;
    let lacks = |array: u32| arrays & array == 0;
    let color = [file.f32(28, "colour")?, file.f32(32, "colour")?, file.f32(36, "colour")?];
    Ok(HairHeader {
        thickness: default_thickness(&file)?.filter(|_| lacks(THICKNESS)),
        transparency: Some(file.f32(24, "transparency")?).filter(|_| lacks(TRANSPARENCY)),
        color: Some(color).filter(|_| lacks(COLORS)),
    })
}

/// The index of the first point of each strand, from the array of segments, or from the default in the header.
fn starts(file: &Bytes, array: bool, at: usize, count: usize, total: usize) -> Result<Vec<u32>, Error> {
    let default = file.u32(16, "segments")?;
    // A strand has at least one point of 12 bytes. This limits the allocation by the size of the file.
    if count > file.bytes.len() / 12 {
        return Err(file.fail(4, format!("{count} strands do not fit into a file of {} bytes", file.bytes.len())));
    }
    let segments = if array { file.array(at, count, 2, "segment counts")? } else { &[] };
    let mut starts = Vec::with_capacity(count + 1);
    let mut end = 0u64;
    starts.push(0);
    for i in 0..count {
        let segments = segments.get(2 * i..2 * i + 2).map_or(default, |b| u16::from_le_bytes([b[0], b[1]]).into());
        let offset = if array { at + 2 * i } else { 16 };
        end += u64::from(segments) + 1;
        if end > total as u64 {
            return Err(file.fail(offset, format!("strand {i} ends at point {end}, but there are {total} points")));
        }
        starts.push(end as u32);
    }
    if end != total as u64 {
        return Err(file.fail(8, format!("the header says {total} points, but the strands have {end}")));
    }
    Ok(starts)
}

/// The bytes of a `.hair` file of these strands.
///
/// The file has segments, points, thickness, and colours if [`Parameter::Reflectance`] varies per point. The format
/// does not support anything else. Convert curves with [`flatten`](fn@crate::flatten) first.
///
/// # Errors
/// [`Error::Unwritable`] if the strands are not [`Basis::Linear`], or a strand has more than 65,535 segments.
/// [`Error::Scene`] if [`Strands::validate`] fails.
pub fn write_hair(strands: &Strands) -> Result<Vec<u8>, Error> {
    strands.validate()?;
    let fail = |what: String| Err(Error::Unwritable { strands: strands.name.clone(), what });
    if strands.basis != Basis::Linear {
        return fail(format!("a .hair file has straight segments, not {:?}: flatten them first", strands.basis));
    }
    let colors = strands.varying.iter().find_map(|(parameter, values)| match (parameter, values) {
        (Parameter::Reflectance, Values::PerPoint(values)) => Some(values),
        _ => None,
    });
    let mut bytes = Vec::with_capacity(HEADER + 2 * strands.len() + 28 * strands.points.len());
    bytes.extend(b"HAIR");
    let arrays = SEGMENTS | POINTS | THICKNESS | if colors.is_some() { COLORS } else { 0 };
    for word in [strands.len() as u32, strands.points.len() as u32, arrays, 0] {
        bytes.extend(word.to_le_bytes());
    }
    for default in [0.0f32, 0.0, 0.5, 0.5, 0.5] {
        bytes.extend(default.to_le_bytes());
    }
    bytes.resize(HEADER, 0);
    for (i, pair) in strands.starts.windows(2).enumerate() {
        match u16::try_from(pair[1] - pair[0] - 1) {
            Ok(segments) => bytes.extend(segments.to_le_bytes()),
            Err(_) => return fail(format!("strand {i} has more than the 65535 segments of a .hair file")),
        }
    }
    let mut floats = |values: &mut dyn Iterator<Item = f32>| values.for_each(|x| bytes.extend(x.to_le_bytes()));
    floats(&mut strands.points.iter().flat_map(|p| p.truncate().to_array()));
    floats(&mut strands.points.iter().map(|p| 2.0 * p.w));
    floats(&mut colors.into_iter().flatten().flatten().copied());
    Ok(bytes)
}
