//! Checks a binary layer (.usdc) before it is decoded: no count may be larger than the file allows.
//!
//! The decoder allocates memory for the counts in the file, and a failed allocation ends the program. A compressed
//! block (LZ4) expands to at most 255 times its size. An integer takes at least a quarter of a byte before compression.

use crate::error::Invalid;
use std::collections::BTreeSet;

/// The largest compression ratio of LZ4.
const MOST_COMPRESSION: u64 = 255;
/// Values with deeper nesting count as circular.
pub(super) const DEEPEST: usize = 32;

/// The type of a list of doubles, which the decoder reads as an array.
const DOUBLES: u64 = 48;

/// A position in the bytes of a layer.
#[derive(Clone, Copy)]
pub(super) struct Cursor<'a> {
    pub bytes: &'a [u8],
    pub at: u64,
}

impl<'a> Cursor<'a> {
    fn rest(&self) -> u64 {
        (self.bytes.len() as u64).saturating_sub(self.at)
    }

    pub fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let start = usize::try_from(self.at).unwrap_or(usize::MAX);
        let bytes = self.bytes.get(start..).and_then(|rest| rest.first_chunk::<N>());
        let bytes = bytes.ok_or_else(|| format!("it is cut off: there is no byte {}", self.at))?;
        self.at += N as u64;
        Ok(*bytes)
    }

    pub fn u32(&mut self) -> Result<u64, Invalid> {
        Ok(u64::from(u32::from_le_bytes(self.array()?)))
    }

    pub fn u64(&mut self) -> Result<u64, Invalid> {
        Ok(u64::from_le_bytes(self.array()?))
    }

    /// Skips `count` items of `size` bytes.
    pub fn skip(&mut self, count: u64, size: u64) -> Result<(), Invalid> {
        match count.checked_mul(size) {
            Some(bytes) if bytes <= self.rest() => {
                self.at += bytes;
                Ok(())
            }
            _ => Err(format!("at byte {} it claims {count} items, more than the file can hold", self.at).into()),
        }
    }

    /// The next bytes.
    pub fn bytes(&mut self, count: u64) -> Result<&'a [u8], Invalid> {
        let start = usize::try_from(self.at).unwrap_or(usize::MAX);
        self.skip(count, 1)?;
        let bytes = self.bytes.get(start..).and_then(|rest| rest.get(..count as usize));
        bytes.ok_or_else(|| format!("it is cut off: there is no byte {start}").into())
    }

    /// Skips a compressed block that expands to at least `bytes`.
    fn compressed(&mut self, bytes: u64) -> Result<(), Invalid> {
        let at = self.at;
        let size = self.u64()?;
        self.skip(size, 1)?;
        if bytes / MOST_COMPRESSION > size {
            return Err(format!(
                "at byte {at} it claims {bytes} bytes, but {size} bytes cannot be decompressed to that many"
            )
            .into());
        }
        Ok(())
    }

    fn integers(&mut self, count: u64) -> Result<(), Invalid> {
        self.compressed(count / 4)
    }

    /// Reads a 64-bit offset and moves to its target.
    pub fn follow(&mut self) -> Result<(), Invalid> {
        let from = self.at;
        let offset = i64::from_le_bytes(self.array()?);
        self.at = from.checked_add_signed(offset).ok_or("an offset points outside the file")?;
        Ok(())
    }
}

/// Types whose arrays are indices of strings: strings, paths of files and expressions.
pub(crate) const STRINGS: [u64; 3] = [10, 12, 57];

/// Checks the tables that are decoded when a layer is opened.
pub(crate) fn check_tables(bytes: &[u8]) -> Result<(), Invalid> {
    let mut header = Cursor { bytes, at: 16 };
    let mut contents = Cursor { bytes, at: header.u64()? };
    let count = contents.u64()?;
    contents.skip(count, 32)?;
    contents.at -= 32 * count;
    for _ in 0..count {
        let name: [u8; 16] = contents.array()?;
        let mut section = Cursor { bytes, at: contents.u64()? };
        let _size = contents.u64()?;
        let name = name.split(|&b| b == 0).next().unwrap_or_default();
        if !matches!(name, b"TOKENS" | b"STRINGS" | b"FIELDS" | b"FIELDSETS" | b"PATHS" | b"SPECS") {
            continue;
        }
        let items = section.u64()?;
        match name {
            b"TOKENS" => {
                let size = section.u64()?;
                section.compressed(size)?;
            }
            b"STRINGS" => section.skip(items, 4)?,
            b"FIELDS" => {
                section.integers(items)?;
                section.compressed(items.saturating_mul(8))?;
            }
            b"FIELDSETS" => section.integers(items)?,
            b"PATHS" => {
                let encoded = section.u64()?;
                // The empty path, of a reference to the default prim, has a place in the table and no encoding.
                if items > encoded.saturating_add(1) {
                    return Err(format!("it claims {items} paths, but encodes {encoded}").into());
                }
                (0..3).try_for_each(|_| section.integers(encoded))?;
            }
            _ => (0..3).try_for_each(|_| section.integers(items))?,
        }
    }
    Ok(())
}

/// Checks values by their 64-bit representations, which have the type, flags and position.
/// Returns whether there is an empty array of strings, which the decoder misreads.
pub(crate) fn check_values(bytes: &[u8], mut representations: impl Iterator<Item = u64>) -> Result<bool, Invalid> {
    let version = Cursor { bytes, at: 8 }.array::<3>()?;
    let mut walk = Walk { budget: bytes.len(), has_empty: false };
    representations.try_for_each(|representation| value(bytes, version, representation, 0, &mut walk))?;
    Ok(walk.has_empty)
}

/// The state of a walk through all values.
struct Walk {
    /// How many more values may be visited: a file has fewer than bytes, unless values contain each other.
    budget: usize,
    has_empty: bool,
}

fn value(bytes: &[u8], version: [u8; 3], representation: u64, depth: usize, walk: &mut Walk) -> Result<(), Invalid> {
    if depth > DEEPEST || walk.budget == 0 {
        return Err("values are nested in a circle".into());
    }
    walk.budget -= 1;
    let [is_array, is_inlined, is_compressed] = [63, 62, 61].map(|bit| representation >> bit & 1 == 1);
    let kind = representation >> 48 & 0xff;
    let mut at = Cursor { bytes, at: representation & 0xffff_ffff_ffff };
    // The decoder reads lists and dictionaries as such, whatever the flags say, and arrays even if they are inlined.
    let is_list = matches!(kind, 31..=47 | 49..=50 | 54 | 55 | 58);
    if (is_array || kind == DOUBLES) && !is_list {
        if at.at == 0 {
            walk.has_empty |= STRINGS.contains(&kind);
            return Ok(());
        }
        // Strings, paths of files and expressions: their number has 8 bytes in all versions for the decoder.
        if STRINGS.contains(&kind) {
            return at.u64().and_then(|count| at.skip(count, 4));
        }
        if version < [0, 5, 0] {
            at.u32()?;
        }
        let count = if version < [0, 7, 0] { at.u32()? } else { at.u64()? };
        let is_integer = matches!(kind, 3..=6) && version >= [0, 5, 0];
        let is_float = matches!(kind, 7..=9 | DOUBLES | 56) && version >= [0, 6, 0];
        return match (is_compressed && count >= 4, is_integer, is_float) {
            (true, true, _) => at.integers(count),
            (true, _, true) => {
                // Stored as indices into a table, or as integers.
                if at.array::<1>()? == [b't'] {
                    let entries = at.u32()?;
                    at.skip(entries, item_size(kind))?;
                }
                at.integers(count)
            }
            _ => at.skip(count, item_size(kind)),
        };
    }
    if is_inlined && (!is_list || kind == 31) {
        return Ok(());
    }
    match kind {
        // Dictionary: names and values.
        31 => dictionary(&mut at, version, depth, walk),
        // Lists of edits: up to six sequences.
        32..=39 | 54 | 55 => {
            let [flags] = at.array::<1>()?;
            for _ in 0..(flags >> 1 & 0x3f).count_ones() {
                let count = at.u64()?;
                match kind {
                    // References and payloads: two indices, an offset and a scale; references have a dictionary too.
                    35 | 55 => {
                        Cursor { ..at }.skip(count, 8)?;
                        for _ in 0..count {
                            at.skip(1, if kind == 35 || version >= [0, 8, 0] { 24 } else { 8 })?;
                            if kind == 35 {
                                dictionary(&mut at, version, depth, walk)?;
                            }
                        }
                    }
                    _ => at.skip(count, if matches!(kind, 37 | 39) { 8 } else { 4 })?,
                }
            }
            Ok(())
        }
        // Paths, tokens, strings; variant selections and relocates are pairs of indices; numbers; offsets with scales.
        40 | 41 | 50 => at.u64().and_then(|count| at.skip(count, 4)),
        45 | 58 => at.u64().and_then(|count| at.skip(count, 8)),
        49 => at.u64().and_then(|count| at.skip(count, 16)),
        // Time samples: times, then values.
        46 => {
            at.follow()?;
            let times = at.u64()?;
            value(bytes, version, times, depth + 1, walk)?;
            at.follow()?;
            let count = at.u64()?;
            Cursor { ..at }.skip(count, 8)?;
            (0..count).try_for_each(|_| value(bytes, version, at.u64()?, depth + 1, walk))
        }
        _ => Ok(()),
    }
}

/// The values that hold the times of time samples, for those of these values that are time samples.
pub(crate) fn times(bytes: &[u8], representations: impl Iterator<Item = u64>) -> Result<BTreeSet<u64>, Invalid> {
    let samples = representations.filter(|value| value >> 48 & 0xff == 46 && value >> 62 == 0);
    samples
        .map(|value| {
            let mut at = Cursor { bytes, at: value & 0xffff_ffff_ffff };
            at.follow()?;
            at.u64()
        })
        .collect()
}

fn dictionary(at: &mut Cursor, version: [u8; 3], depth: usize, walk: &mut Walk) -> Result<(), Invalid> {
    let count = at.u64()?;
    // Each entry has a name, an offset and a value.
    Cursor { ..*at }.skip(count, 12)?;
    for _ in 0..count {
        at.u32()?;
        at.follow()?;
        let representation = at.u64()?;
        value(at.bytes, version, representation, depth + 1, walk)?;
    }
    Ok(())
}

/// Size of an item of an uncompressed array, in bytes.
fn item_size(kind: u64) -> u64 {
    // The type numbers of the format: matrices, quaternions, and vectors of 2 to 4 doubles, floats, halves or integers.
    match kind {
        1 | 2 => 1,
        7 => 2,
        25 => 6,
        5 | 6 | 9 | 18 | 20 | 22 | 29 | DOUBLES | 56 => 8,
        24 | 26 => 12,
        17 | 19 | 28 | 30 => 16,
        23 => 24,
        13 | 16 | 27 => 32,
        14 => 72,
        15 => 128,
        _ => 4,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A layer of version 0.8 with these numbers after its header.
    fn layer(numbers: &[u64]) -> Vec<u8> {
        let mut bytes = b"PXR-USDC\0\x08\0\0\0\0\0\0".to_vec();
        bytes.extend(numbers.iter().flat_map(|n| n.to_le_bytes()));
        bytes
    }

    const ARRAY: u64 = 1 << 63;
    const COMPRESSED: u64 = 1 << 61;
    const INLINED: u64 = 1 << 62;
    const POINTS: u64 = 24 << 48;
    const EDITS: u64 = 37 << 48;
    const TEXTS: u64 = 10 << 48;
    const INTEGERS: u64 = 3 << 48;
    const DICTIONARY: u64 = 31 << 48;

    #[test]
    fn counts_are_checked_against_the_size_of_the_file() {
        let check_value = |bytes: &[u8], value: u64| check_values(bytes, std::iter::once(value));
        let value = |kind: u64, numbers: &[u64]| check_value(&layer(numbers), kind | 16);
        assert_eq!(value(ARRAY | POINTS, &[2, 0, 0, 0]), Ok(false));
        assert_eq!(check_value(&layer(&[]), ARRAY | TEXTS), Ok(true));
        assert!(value(ARRAY | POINTS, &[10_000_000, 0, 0, 0]).unwrap_err().0.contains("claims 10000000 items"));
        assert!(value(ARRAY | POINTS, &[u64::MAX, 0, 0, 0]).is_err());
        // A block of 8 bytes.
        assert_eq!(value(ARRAY | COMPRESSED | INTEGERS, &[1000, 8, 0]), Ok(false));
        assert!(value(ARRAY | COMPRESSED | INTEGERS, &[1_000_000_000, 8, 0]).unwrap_err().0.contains("decompressed"));
        assert!(value(ARRAY | COMPRESSED | INTEGERS, &[1000, 1 << 40, 0]).is_err());
        assert!(check_value(&layer(&[]), ARRAY | POINTS | 0xffff_ffff_ffff).unwrap_err().0.contains("cut off"));
        // Flags that do not fit the type: the decoder does not look at them.
        let many = 1 << 40;
        for kind in [ARRAY | EDITS, INLINED | EDITS] {
            assert!(check_value(&layer(&[2 | many << 8, 0]), kind | 16).is_err());
        }
        for kind in [ARRAY | INLINED | POINTS, DOUBLES << 48, ARRAY | TEXTS] {
            assert!(value(kind, &[many, 0]).unwrap_err().0.contains("more than the file can hold"));
            // The same in a version whose arrays have numbers of 4 bytes.
            let mut old = layer(&[many | 9 << 32 | 9, 0]);
            old[9] = 6;
            assert!(check_value(&old, kind | 16).is_err());
        }
        let mut old = layer(&[1 | 1000 << 32, 8, 0]);
        old[9] = 4;
        assert!(check_value(&old, ARRAY | COMPRESSED | INTEGERS | 16).is_err());
    }

    #[test]
    fn values_that_contain_themselves_are_errors() {
        // One entry: a name (4 bytes), an offset of 8, and as value the dictionary itself.
        let mut bytes = layer(&[1]);
        bytes.extend([0; 4]);
        bytes.extend(8u64.to_le_bytes());
        bytes.extend((DICTIONARY | 16).to_le_bytes());
        assert!(check_values(&bytes, std::iter::once(DICTIONARY | 16)).unwrap_err().0.contains("in a circle"));
        // Many fields cannot refer to the same long value again and again either.
        let times = layer(&[8, 0, 8, 1000].into_iter().chain(std::iter::repeat_n(1 << 62, 1000)).collect::<Vec<_>>());
        let samples = 46 << 48 | 16;
        assert_eq!(check_values(&times, std::iter::once(samples)), Ok(false));
        assert!(check_values(&times, std::iter::repeat_n(samples, 1000)).is_err());
    }

    #[test]
    fn tables_are_checked_against_the_size_of_the_file() {
        let mut bytes = layer(&[32, 0, 1]);
        bytes.extend(b"STRINGS\0\0\0\0\0\0\0\0\0");
        bytes.extend([72u64, 16].iter().flat_map(|n| n.to_le_bytes()));
        bytes.extend([2u64, 0].iter().flat_map(|n| n.to_le_bytes()));
        assert_eq!(check_tables(&bytes), Ok(()));
        bytes[72] = 200;
        assert!(check_tables(&bytes).unwrap_err().0.contains("claims 200 items"));
        assert!(check_tables(&bytes[..40]).is_err());
    }
}
