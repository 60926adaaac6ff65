//! Values of a crate file. Each has a representation of 64 bits: flags, its type, and itself or its position.

use crate::write::crate_file::integers::MOST_BYTES;
use crate::write::crate_file::tables::Tables;
use crate::write::value::Element;
use std::io::{self, Write};

const ARRAY: u64 = 1 << 63;
const INLINED: u64 = 1 << 62;
const COMPRESSED: u64 = 1 << 61;

/// Shorter arrays are not compressed. OpenUSD does not expect it.
const LEAST_COMPRESSED: usize = 16;
/// Longer arrays of integers could be too large for a block. They are not compressed.
const MOST_COMPRESSED: usize = MOST_BYTES / 5;

/// Writes values, and knows the position in the file.
pub(crate) struct Heap<'a> {
    out: &'a mut dyn Write,
    /// The number of bytes before the next one.
    pub at: u64,
    pub tables: Tables,
}

impl<'a> Heap<'a> {
    pub fn new(out: &'a mut dyn Write) -> Self {
        Heap { out, at: 0, tables: Tables::new() }
    }

    pub fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.out.write_all(bytes)?;
        self.at += bytes.len() as u64;
        Ok(())
    }

    /// Writes a value of a type with this number.
    pub fn place(&mut self, kind: u64, bytes: &[u8]) -> io::Result<u64> {
        let representation = kind << 48 | self.at;
        self.write(bytes)?;
        Ok(representation)
    }

    /// Stores a value. Its representation contains it if it has at most four bytes.
    pub fn value<E: Element>(&mut self, value: &E) -> io::Result<u64> {
        let mut bytes = Vec::new();
        value.bytes(&mut self.tables, &mut bytes);
        if bytes.len() > 4 {
            return self.place(E::KIND, &bytes);
        }
        Ok(inlined(E::KIND, bytes.iter().rev().fold(0, |value, byte| value << 8 | u64::from(*byte))))
    }

    /// Stores an array.
    pub fn array<E: Element>(&mut self, values: impl Iterator<Item = E> + Clone) -> io::Result<u64> {
        let count = values.clone().count();
        if count == 0 {
            // An empty array has no position.
            return Ok(ARRAY | E::KIND << 48);
        }
        let is_packable = (LEAST_COMPRESSED..=MOST_COMPRESSED).contains(&count);
        let packed = if is_packable { E::pack(values.clone()) } else { None };
        // So that OpenUSD can use the numbers where they are, without a copy.
        self.write(&[0; 8][..(self.at.wrapping_neg() % 8) as usize])?;
        let representation = ARRAY | self.place(E::KIND, &(count as u64).to_le_bytes())?;
        if let Some(bytes) = packed {
            self.write(&bytes)?;
            return Ok(COMPRESSED | representation);
        }
        let mut bytes = Vec::new();
        for value in values {
            value.bytes(&mut self.tables, &mut bytes);
            if bytes.len() >= 1 << 16 {
                self.write(&bytes)?;
                bytes.clear();
            }
        }
        self.write(&bytes)?;
        Ok(representation)
    }
}

/// The representation of a small value.
pub(crate) fn inlined(kind: u64, value: u64) -> u64 {
    INLINED | kind << 48 | value
}
