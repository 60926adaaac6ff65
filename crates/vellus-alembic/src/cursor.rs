//! Reads numbers and text from bytes, one after another.

use crate::error::{Error, damaged};

/// Bytes that are not read yet.
pub(crate) struct Cursor<'a> {
    rest: &'a [u8],
    /// What the bytes are, for messages.
    what: &'static str,
    /// The position of the group that they belong to, for messages.
    at: usize,
}

impl<'a> Cursor<'a> {
    pub fn new(bytes: &'a [u8], what: &'static str, at: usize) -> Self {
        Cursor { rest: bytes, what, at }
    }

    pub fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    /// An error of these bytes.
    pub fn error(&self, what: impl std::fmt::Display) -> Error {
        damaged(self.at, format!("{}: {what}", self.what))
    }

    pub fn bytes(&mut self, count: usize) -> Result<&'a [u8], Error> {
        let (bytes, rest) = self
            .rest
            .split_at_checked(count)
            .ok_or_else(|| self.error(format!("{count} more bytes are expected, but there are {}", self.rest.len())))?;
        self.rest = rest;
        Ok(bytes)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        let bytes = self.bytes(N)?;
        Ok(std::array::from_fn(|i| bytes[i]))
    }

    pub fn u8(&mut self) -> Result<u8, Error> {
        Ok(self.array::<1>()?[0])
    }

    pub fn u32(&mut self) -> Result<u32, Error> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    pub fn f64(&mut self) -> Result<f64, Error> {
        Ok(f64::from_le_bytes(self.array()?))
    }

    /// A number of one, two or four bytes: the hint is 0, 1 or 2.
    pub fn sized(&mut self, hint: u32) -> Result<u32, Error> {
        match hint {
            0 => Ok(self.u8()?.into()),
            1 => Ok(u16::from_le_bytes(self.array()?).into()),
            2 => self.u32(),
            _ => Err(self.error("a number has no known size")),
        }
    }

    /// Text of this many bytes. What is not UTF-8 is replaced.
    pub fn text(&mut self, count: u32) -> Result<String, Error> {
        let count = usize::try_from(count).unwrap_or(usize::MAX);
        Ok(String::from_utf8_lossy(self.bytes(count)?).into_owned())
    }
}
