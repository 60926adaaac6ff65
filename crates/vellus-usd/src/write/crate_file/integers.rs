//! Compression of integers and of floating-point numbers, as crate files have it.

use std::collections::HashMap;

/// Codes integers and compresses the codes. The size in bytes comes first.
///
/// First the most frequent difference of neighbours. Then two bits for each integer: its difference is the most
/// frequent one, or has 8, 16 or 32 bits. Then these differences.
pub(crate) fn pack_integers(values: impl Iterator<Item = i32> + Clone) -> Vec<u8> {
    let (common, codes, rest) = code(values);
    lz4(&[&common.to_le_bytes()[..], &codes, &rest].concat())
}

fn code(values: impl Iterator<Item = i32> + Clone) -> (i32, Vec<u8>, Vec<u8>) {
    let differences = values.scan(0i32, |last, value| Some(value.wrapping_sub(std::mem::replace(last, value))));
    // Any difference will do. Those of more than 16 bits are not counted, so that the memory is bounded.
    let mut counts = HashMap::<i16, u32>::new();
    for short in differences.clone().filter_map(|difference| i16::try_from(difference).ok()) {
        *counts.entry(short).or_default() += 1;
    }
    let common = counts.into_iter().max_by_key(|(short, count)| (*count, *short));
    let common = common.map_or(0, |(short, _)| i32::from(short));
    let (mut codes, mut rest) = (Vec::new(), Vec::new());
    for (i, difference) in differences.enumerate() {
        let code = if difference == common {
            0
        } else if let Ok(byte) = i8::try_from(difference) {
            rest.extend(byte.to_le_bytes());
            1
        } else if let Ok(short) = i16::try_from(difference) {
            rest.extend(short.to_le_bytes());
            2
        } else {
            rest.extend(difference.to_le_bytes());
            3
        };
        match i % 4 {
            0 => codes.push(code),
            place => codes[i / 4] |= code << (2 * place),
        }
    }
    (common, codes, rest)
}

/// The compressed form of numbers that are whole, or of which there are few different ones.
pub(crate) fn pack_floats(values: impl Iterator<Item = f32> + Clone) -> Option<Vec<u8>> {
    // The sign of negative zero would be lost.
    let is_whole = |x: f32| (x as i32 as f32).to_bits() == x.to_bits();
    if values.clone().all(is_whole) {
        return Some([b"i", &pack_integers(values.map(|x| x as i32))[..]].concat());
    }
    let most = (values.clone().count() / 4).min(1024);
    let mut indices = HashMap::new();
    let mut table: Vec<u8> = Vec::new();
    for x in values.clone() {
        let next = indices.len();
        indices.entry(x.to_bits()).or_insert_with(|| {
            table.extend(x.to_le_bytes());
            next as i32
        });
        if indices.len() > most {
            return None;
        }
    }
    let packed = pack_integers(values.map(|x| indices[&x.to_bits()]));
    Some([b"t", &(indices.len() as u32).to_le_bytes()[..], &table, &packed].concat())
}

/// Compresses at most [`MOST_BYTES`]. The size comes first, and then the number of further blocks, which is zero.
pub(crate) fn lz4(bytes: &[u8]) -> Vec<u8> {
    let packed = lz4_flex::block::compress(bytes);
    [&(packed.len() as u64 + 1).to_le_bytes()[..], &[0], &packed].concat()
}

/// The largest block of LZ4.
pub(crate) const MOST_BYTES: usize = 0x7e00_0000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_are_coded_as_openusd_describes() {
        // The example of OpenUSD, pxr/usd/sdf/integerCoding.cpp. Its first code is in the lowest bits.
        let (common, codes, rest) = code([123, 124, 125, 100_125, 100_125, 100_126, 100_126].into_iter());
        assert_eq!((common, codes), (1, vec![0b11_00_00_01, 0b01_00_01]));
        assert_eq!(rest, [&[123][..], &100_000i32.to_le_bytes(), &[0, 0]].concat());
        let (common, codes, rest) = code([0, 0, 300, i32::MIN].into_iter());
        assert_eq!((common, codes, rest.len()), (0, vec![0b11_10_00_00], 6));
    }

    #[test]
    fn blocks_are_read_by_lz4() {
        let bytes: Vec<u8> = (0..1000u32).flat_map(|i| (i / 7).to_le_bytes()).collect();
        let packed = lz4(&bytes);
        assert_eq!(packed[..9], [&(packed.len() as u64 - 8).to_le_bytes()[..], &[0]].concat());
        assert_eq!(lz4_flex::block::decompress(&packed[9..], bytes.len()).unwrap(), bytes);
    }

    #[test]
    fn floats_are_packed_only_if_bits_survive() {
        let kind = |values: &[f32]| pack_floats(values.iter().copied()).map(|bytes| bytes[0]);
        assert_eq!(kind(&[1.0, -2.0, 0.0, 2_147_483_648.0]), Some(b'i'));
        assert_eq!(kind(&[0.0, -0.0, 0.0, -0.0, 0.0, -0.0, 0.0, 0.0]), Some(b't'));
        assert_eq!(kind(&[0.5; 4]), Some(b't'));
        assert_eq!(kind(&[0.5, 0.25, 0.5, 0.5]), None);
        assert_eq!(kind(&[f32::NAN; 8]), Some(b't'));
    }
}
