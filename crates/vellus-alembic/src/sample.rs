//! One sample of a property: bytes, as numbers or text.

use crate::property::Pod;
use std::borrow::Cow;

/// One sample of a property.
#[derive(Clone, Debug)]
pub struct Sample<'a> {
    /// The type of the numbers.
    pub pod: Pod,
    /// The numbers or the text, without the hash, as they are in the file (little-endian).
    pub bytes: Cow<'a, [u8]>,
}

impl Sample<'_> {
    /// The number of numbers. 0 for text.
    pub fn len(&self) -> usize {
        self.pod.size().map_or(0, |size| self.bytes.len() / size)
    }

    /// Whether there are no bytes.
    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// All numbers in double precision. Nothing for text.
    pub fn to_f64(&self) -> Vec<f64> {
        self.numbers(|x| x, |x| x as f64)
    }

    /// All numbers in single precision. Nothing for text.
    pub fn to_f32(&self) -> Vec<f32> {
        self.numbers(|x| x as f32, |x| x as f32)
    }

    /// All numbers in single precision, in rows of N. Numbers of an incomplete row are left out. Nothing for text.
    pub fn to_rows<const N: usize>(&self) -> Vec<[f32; N]> {
        if self.pod == Pod::F32 {
            let rows = self.bytes.as_chunks::<4>().0.as_chunks::<N>().0;
            return rows.iter().map(|row| row.map(f32::from_le_bytes)).collect();
        }
        self.to_f32().as_chunks::<N>().0.to_vec()
    }

    /// All numbers as integers, rounded towards 0; those without a sign of 64 bits are at most `i64::MAX`. Nothing for
    /// text.
    pub fn to_i64(&self) -> Vec<i64> {
        self.numbers(|x| x as i64, |x| x)
    }

    /// All texts. What is not Unicode is replaced. Nothing for numbers.
    pub fn to_text(&self) -> Vec<String> {
        let mut all: Vec<String> = match self.pod {
            Pod::Text => self.bytes.split(|byte| *byte == 0).map(|text| String::from_utf8_lossy(text).into()).collect(),
            Pod::WideText => {
                let characters = self.bytes.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word));
                let characters: Vec<u32> = characters.collect();
                let text = |text: &[u32]| text.iter().filter_map(|character| char::from_u32(*character)).collect();
                characters.split(|character| *character == 0).map(text).collect()
            }
            _ => return Vec::new(),
        };
        // Each text ends with 0.
        all.pop();
        all
    }

    fn numbers<T>(&self, float: impl Fn(f64) -> T, whole: impl Fn(i64) -> T) -> Vec<T> {
        /// Numbers of a size.
        fn all<T, const N: usize>(bytes: &[u8], convert: impl Fn([u8; N]) -> T) -> Vec<T> {
            bytes.as_chunks::<N>().0.iter().map(|word| convert(*word)).collect()
        }
        let bytes = &self.bytes[..];
        match self.pod {
            Pod::Bool => all(bytes, |[byte]| whole((byte != 0).into())),
            Pod::U8 => all(bytes, |[byte]| whole(byte.into())),
            Pod::I8 => all(bytes, |word| whole(i8::from_le_bytes(word).into())),
            Pod::U16 => all(bytes, |word| whole(u16::from_le_bytes(word).into())),
            Pod::I16 => all(bytes, |word| whole(i16::from_le_bytes(word).into())),
            Pod::U32 => all(bytes, |word| whole(u32::from_le_bytes(word).into())),
            Pod::I32 => all(bytes, |word| whole(i32::from_le_bytes(word).into())),
            Pod::U64 => all(bytes, |word| whole(u64::from_le_bytes(word).try_into().unwrap_or(i64::MAX))),
            Pod::I64 => all(bytes, |word| whole(i64::from_le_bytes(word))),
            Pod::F16 => all(bytes, |word| float(half(u16::from_le_bytes(word)))),
            Pod::F32 => all(bytes, |word| float(f32::from_le_bytes(word).into())),
            Pod::F64 => all(bytes, |word| float(f64::from_le_bytes(word))),
            Pod::Text | Pod::WideText => Vec::new(),
        }
    }
}

/// A number of half precision: 1 bit for the sign, 5 for the exponent, 10 for the fraction.
fn half(bits: u16) -> f64 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023) / 1024.0);
    let size = match exponent {
        0 => fraction * 2f64.powi(-14),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1.0 + fraction) * 2f64.powi(exponent - 15),
    };
    if bits >> 15 == 1 { -size } else { size }
}

/// The bits of a number in half precision, rounded to the nearest one; infinite if it is too large.
pub(crate) fn to_half(x: f32) -> u16 {
    let sign = ((x.to_bits() >> 16) & 0x8000) as u16;
    let size = f64::from(x.abs());
    if x.is_nan() {
        return sign | 0x7e00;
    }
    // From half a step beyond the largest number on, it is infinite.
    if size >= 65520.0 {
        return sign | 0x7c00;
    }
    // The exponent of the last place: that of numbers below 2⁻¹⁴ is fixed.
    let exponent = if size < 2f64.powi(-14) { -14 } else { size.log2().floor() as i32 };
    let units = (size * 2f64.powi(10 - exponent)).round_ties_even();
    // A carry gives the next exponent.
    let bits = (i64::from(exponent + 14) << 10) + units as i64;
    sign | bits as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_half_is_written_as_it_was_read() {
        for bits in 0..=u16::MAX {
            let value = half(bits);
            if !value.is_nan() {
                assert_eq!(to_half(value as f32), bits, "{value}");
            }
        }
        assert_eq!([to_half(1e9), to_half(65519.0), to_half(65520.0), to_half(1e-9)], [0x7c00, 0x7bff, 0x7c00, 0]);
    }

    #[test]
    fn half_precision_has_its_known_values() {
        let known =
            [(0x3c00, 1.0), (0xc000, -2.0), (0x7bff, 65504.0), (0x0001, 2f64.powi(-24)), (0x3555, 0.333251953125)];
        for (bits, value) in known {
            assert_eq!(half(bits), value);
        }
        assert!(half(0x7c00) == f64::INFINITY && half(0x7e00).is_nan());
    }

    #[test]
    fn every_type_is_read() {
        let sample = |pod, bytes: &'static [u8]| Sample { pod, bytes: Cow::Borrowed(bytes) };
        assert_eq!(sample(Pod::Bool, &[0, 7]).to_i64(), [0, 1]);
        assert_eq!(sample(Pod::I8, &[255, 1]).to_f32(), [-1.0, 1.0]);
        assert_eq!(sample(Pod::U64, &[255; 8]).to_i64(), [i64::MAX]);
        assert_eq!(sample(Pod::F32, &[0, 0, 0x80, 0x3f, 9]).to_f64(), [1.0]);
        assert_eq!(sample(Pod::Text, b"ab\0\0c\0").to_text(), ["ab", "", "c"]);
        assert_eq!(sample(Pod::WideText, &[0xe4, 0, 0, 0, 0, 0, 0, 0]).to_text(), ["\u{e4}"]);
        assert!(sample(Pod::Text, b"").to_text().is_empty() && sample(Pod::F32, &[1]).to_i64().is_empty());
    }
}
