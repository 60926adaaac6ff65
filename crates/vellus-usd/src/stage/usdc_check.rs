//! Checks of a binary layer (.usdc) before it is decoded: no count may claim more than the file can hold.
//!
//! The decoder allocates by the counts it finds, and an allocation that fails ends the program. Compressed blocks (LZ4) hold at most
//! 255 times their size; integers take at least a quarter of a byte before that.

/// LZ4 cannot do better.
const MOST_COMPRESSION: u64 = 255;
/// Deeper values are taken for a circle.
const DEEPEST: usize = 32;

/// A position in the bytes of a layer.
#[derive(Clone, Copy)]
struct Cursor<'a> {
    bytes: &'a [u8],
    at: u64,
}

impl Cursor<'_> {
    fn rest(&self) -> u64 {
        (self.bytes.len() as u64).saturating_sub(self.at)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let start = usize::try_from(self.at).unwrap_or(usize::MAX);
        let bytes = self.bytes.get(start..).and_then(|rest| rest.first_chunk::<N>());
        let bytes = bytes.ok_or_else(|| format!("it is cut off: nothing at byte {}", self.at))?;
        self.at += N as u64;
        Ok(*bytes)
    }

    fn u32(&mut self) -> Result<u64, String> {
        Ok(u64::from(u32::from_le_bytes(self.array()?)))
    }

    fn u64(&mut self) -> Result<u64, String> {
        Ok(u64::from_le_bytes(self.array()?))
    }

    /// Passes `count` items of `size` bytes.
    fn skip(&mut self, count: u64, size: u64) -> Result<(), String> {
        match count.checked_mul(size) {
            Some(bytes) if bytes <= self.rest() => {
                self.at += bytes;
                Ok(())
            }
            _ => Err(format!("at byte {} it claims {count} items, more than there is room for", self.at)),
        }
    }

    /// Passes a compressed block that is to hold at least `bytes`.
    fn compressed(&mut self, bytes: u64) -> Result<(), String> {
        let at = self.at;
        let size = self.u64()?;
        self.skip(size, 1)?;
        if bytes / MOST_COMPRESSION > size {
            return Err(format!("at byte {at} it claims {bytes} bytes, more than {size} can be decompressed to"));
        }
        Ok(())
    }

    fn integers(&mut self, count: u64) -> Result<(), String> {
        self.compressed(count / 4)
    }

    /// Passes a 64-bit offset and goes where it leads.
    fn follow(&mut self) -> Result<(), String> {
        let from = self.at;
        let offset = i64::from_le_bytes(self.array()?);
        self.at = from.checked_add_signed(offset).ok_or("an offset leads out of the file")?;
        Ok(())
    }
}

/// Checks the tables, which are decoded as a layer is opened.
pub(crate) fn check_tables(bytes: &[u8]) -> Result<(), String> {
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
                if items > encoded {
                    return Err(format!("it claims {items} paths, but encodes {encoded}"));
                }
                (0..3).try_for_each(|_| section.integers(encoded))?;
            }
            _ => (0..3).try_for_each(|_| section.integers(items))?,
        }
    }
    Ok(())
}

/// Checks values by their 64-bit representations: type, flags and where they lie.
pub(crate) fn check_values(bytes: &[u8], mut representations: impl Iterator<Item = u64>) -> Result<(), String> {
    let version = Cursor { bytes, at: 8 }.array::<3>()?;
    // No file has more values than bytes; one whose values contain one another does.
    let mut budget = bytes.len();
    representations.try_for_each(|representation| value(bytes, version, representation, 0, &mut budget))
}

fn value(bytes: &[u8], version: [u8; 3], representation: u64, depth: usize, budget: &mut usize) -> Result<(), String> {
    if depth > DEEPEST || *budget == 0 {
        return Err("values are nested in a circle".to_owned());
    }
    *budget -= 1;
    let [is_array, is_inlined, is_compressed] = [63, 62, 61].map(|bit| representation >> bit & 1 == 1);
    let kind = representation >> 48 & 0xff;
    let mut at = Cursor { bytes, at: representation & 0xffff_ffff_ffff };
    if is_inlined || (is_array && at.at == 0) {
        return Ok(());
    }
    if is_array {
        if version < [0, 5, 0] {
            at.u32()?;
        }
        let count = if version < [0, 7, 0] { at.u32()? } else { at.u64()? };
        let (is_integer, is_float) = (matches!(kind, 3..=6), matches!(kind, 7..=9 | 56));
        return match (is_compressed && count >= 4, is_integer, is_float) {
            (true, true, _) => at.integers(count),
            (true, _, true) => {
                // By a table, or as integers.
                if at.array::<1>()? == [b't'] {
                    let entries = at.u32()?;
                    at.skip(entries, item_size(kind))?;
                }
                at.integers(count)
            }
            _ => at.skip(count, item_size(kind)),
        };
    }
    match kind {
        // Dictionary: names and values.
        31 => dictionary(&mut at, version, depth, budget),
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
                                dictionary(&mut at, version, depth, budget)?;
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
        45 | 48 | 58 => at.u64().and_then(|count| at.skip(count, 8)),
        49 => at.u64().and_then(|count| at.skip(count, 16)),
        // Samples in time: times, then values.
        46 => {
            at.follow()?;
            let times = at.u64()?;
            value(bytes, version, times, depth + 1, budget)?;
            at.follow()?;
            let count = at.u64()?;
            Cursor { ..at }.skip(count, 8)?;
            (0..count).try_for_each(|_| value(bytes, version, at.u64()?, depth + 1, budget))
        }
        _ => Ok(()),
    }
}

fn dictionary(at: &mut Cursor, version: [u8; 3], depth: usize, budget: &mut usize) -> Result<(), String> {
    let count = at.u64()?;
    // A name, an offset and a value each.
    Cursor { ..*at }.skip(count, 12)?;
    for _ in 0..count {
        at.u32()?;
        at.follow()?;
        let representation = at.u64()?;
        value(at.bytes, version, representation, depth + 1, budget)?;
    }
    Ok(())
}

/// Bytes of an item of an uncompressed array.
fn item_size(kind: u64) -> u64 {
    // By the numbers of the format: matrices, quaternions, vectors of 2 to 4 as double, single, half, integer.
    match kind {
        1 | 2 => 1,
        7 => 2,
        25 => 6,
        5 | 6 | 9 | 18 | 20 | 22 | 29 | 56 => 8,
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
    const POINTS: u64 = 24 << 48;
    const INTEGERS: u64 = 3 << 48;
    const DICTIONARY: u64 = 31 << 48;

    #[test]
    fn counts_are_held_against_the_size_of_the_file() {
        let check_value = |bytes: &[u8], value: u64| check_values(bytes, std::iter::once(value));
        let value = |kind: u64, numbers: &[u64]| check_value(&layer(numbers), kind | 16);
        assert_eq!(value(ARRAY | POINTS, &[2, 0, 0, 0]), Ok(()));
        assert!(value(ARRAY | POINTS, &[10_000_000, 0, 0, 0]).unwrap_err().contains("claims 10000000 items"));
        assert!(value(ARRAY | POINTS, &[u64::MAX, 0, 0, 0]).is_err());
        // A block of 8 bytes.
        assert_eq!(value(ARRAY | COMPRESSED | INTEGERS, &[1000, 8, 0]), Ok(()));
        assert!(value(ARRAY | COMPRESSED | INTEGERS, &[1_000_000_000, 8, 0]).unwrap_err().contains("decompressed"));
        assert!(value(ARRAY | COMPRESSED | INTEGERS, &[1000, 1 << 40, 0]).is_err());
        assert!(check_value(&layer(&[]), ARRAY | POINTS | 0xffff_ffff_ffff).unwrap_err().contains("cut off"));
    }

    #[test]
    fn values_that_hold_themselves_end() {
        // One entry: a name (4 bytes), an offset of 8, and as value the dictionary itself.
        let mut bytes = layer(&[1]);
        bytes.extend([0; 4]);
        bytes.extend(8u64.to_le_bytes());
        bytes.extend((DICTIONARY | 16).to_le_bytes());
        assert!(check_values(&bytes, std::iter::once(DICTIONARY | 16)).unwrap_err().contains("in a circle"));
        // Nor can many fields lead to the same long value again and again.
        let times = layer(&[8, 0, 8, 1000].into_iter().chain(std::iter::repeat_n(1 << 62, 1000)).collect::<Vec<_>>());
        let samples = 46 << 48 | 16;
        assert_eq!(check_values(&times, std::iter::once(samples)), Ok(()));
        assert!(check_values(&times, std::iter::repeat_n(samples, 1000)).is_err());
    }

    #[test]
    fn tables_are_held_against_the_size_of_the_file() {
        let mut bytes = layer(&[32, 0, 1]);
        bytes.extend(b"STRINGS\0\0\0\0\0\0\0\0\0");
        bytes.extend([72u64, 16].iter().flat_map(|n| n.to_le_bytes()));
        bytes.extend([2u64, 0].iter().flat_map(|n| n.to_le_bytes()));
        assert_eq!(check_tables(&bytes), Ok(()));
        bytes[72] = 200;
        assert!(check_tables(&bytes).unwrap_err().contains("claims 200 items"));
        assert!(check_tables(&bytes[..40]).is_err());
    }
}
