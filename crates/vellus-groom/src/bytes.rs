//! Reads little-endian numbers of a file that may be damaged.

use crate::error::Error;
use glam::Vec3;
use vellus_scene::MAX_COORDINATE;

/// The content of a file, with its name for messages.
pub(crate) struct Bytes<'a> {
    pub file: &'a str,
    pub bytes: &'a [u8],
}

impl<'a> Bytes<'a> {
    pub fn fail(&self, offset: usize, what: impl Into<String>) -> Error {
        Error::File { file: self.file.to_owned(), offset, what: what.into() }
    }

    /// `count` items of `size` bytes at `offset`. Returns an error without allocation if the file is too short.
    pub fn array(&self, offset: usize, count: usize, size: usize, name: &str) -> Result<&'a [u8], Error> {
        let end = count.checked_mul(size).and_then(|n| n.checked_add(offset));
        end.and_then(|end| self.bytes.get(offset..end)).ok_or_else(|| {
            let there = self.bytes.len().saturating_sub(offset);
            self.fail(offset, format!("{count} {name} of {size} bytes belong here, but {there} bytes are left"))
        })
    }

    pub fn u32(&self, offset: usize, name: &str) -> Result<u32, Error> {
        Ok(u32s(self.array(offset, 1, 4, name)?).next().unwrap_or_default())
    }

    pub fn f32(&self, offset: usize, name: &str) -> Result<f32, Error> {
        self.u32(offset, name).map(f32::from_bits)
    }

    /// Points, with any coordinates: see [`vellus_scene::Strands::remove_broken`]. `stride` is the distance between
    /// points in bytes, at least 12.
    pub fn points(&self, offset: usize, count: usize, stride: usize) -> Result<Vec<Vec3>, Error> {
        let bytes = self.array(offset, count, stride, "points")?;
        let point = |bytes: &[u8]| {
            let mut coordinates = f32s(&bytes[..12]);
            Vec3::from_array(std::array::from_fn(|_| coordinates.next().unwrap_or_default()))
        };
        Ok(bytes.chunks_exact(stride).map(point).collect())
    }

    /// Numbers that satisfy `good`. `range` describes the condition for messages.
    pub fn floats(
        &self,
        offset: usize,
        count: usize,
        name: &str,
        good: fn(f32) -> bool,
        range: &str,
    ) -> Result<Vec<f32>, Error> {
        let values: Vec<f32> = f32s(self.array(offset, count, 4, name)?).collect();
        match values.iter().position(|&x| !good(x)) {
            Some(i) => Err(self.fail(offset + 4 * i, format!("{} is among the {name}: {range}", values[i]))),
            None => Ok(values),
        }
    }
}

fn u32s(bytes: &[u8]) -> impl Iterator<Item = u32> {
    bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
}

fn f32s(bytes: &[u8]) -> impl Iterator<Item = f32> {
    u32s(bytes).map(f32::from_bits)
}

/// The largest width, in units of the file.
pub(crate) const MAX_WIDTH: f32 = 2.0 * MAX_COORDINATE;

/// Checks the default width for strands without widths. 0 is allowed, for strands that are only measured.
pub(crate) fn given_width(width: Option<f32>) -> Result<Option<f32>, Error> {
    match width {
        Some(width) if !(0.0..=MAX_WIDTH).contains(&width) => Err(Error::Width(width)),
        width => Ok(width),
    }
}
