//! Films as files that rendering goes on from: checkpoints, and parts to merge.
//!
//! Layout, little endian: `VELLUSF1`; u32 width, height, channels; u64 fingerprint of what was rendered; u64 first sample and
//! the one after the last; then the sums as i64, row by row.

use crate::film::{CHANNELS, Film};
use std::ops::Range;

const MAGIC: &[u8; 8] = b"VELLUSF1";
const HEADER: usize = 8 + 12 + 8 + 16;

/// A film and which samples of what are in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Equal for parts of the same picture.
    pub fingerprint: u64,
    /// Its samples.
    pub samples: Range<u64>,
    /// Their sums.
    pub film: Film,
}

impl Part {
    /// The file's bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        for n in [self.film.width(), self.film.height(), CHANNELS] {
            bytes.extend((n as u32).to_le_bytes());
        }
        for n in [self.fingerprint, self.samples.start, self.samples.end] {
            bytes.extend(n.to_le_bytes());
        }
        bytes.extend(self.film.sums().iter().flat_map(|sum| sum.to_le_bytes()));
        bytes
    }

    /// Reads a file's bytes.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        if bytes.get(..8) != Some(MAGIC) {
            return Err("it does not begin with VELLUSF1: not a film, or one of another version".to_owned());
        }
        let Some((header, rest)) = bytes.split_at_checked(HEADER) else {
            return Err("it ends inside its header".to_owned());
        };
        let small = |i: usize| u32::from_le_bytes(std::array::from_fn(|k| header[8 + 4 * i + k])) as usize;
        let large = |i: usize| u64::from_le_bytes(std::array::from_fn(|k| header[20 + 8 * i + k]));
        let [width, height, channels] = [0, 1, 2].map(small);
        let [fingerprint, start, end] = [0, 1, 2].map(large);
        if channels != CHANNELS || !(1..=1 << 16).contains(&width) || !(1..=1 << 16).contains(&height) {
            return Err(format!("its size of {width} × {height} × {channels} is not one this version writes"));
        }
        let expected = width * height * channels * 8;
        if rest.len() != expected {
            return Err(format!("{} bytes follow the header, which announces {expected}", rest.len()));
        }
        if end < start {
            return Err(format!("its samples run from {start} to {end}"));
        }
        let sums = rest.chunks_exact(8).map(|b| i64::from_le_bytes(std::array::from_fn(|k| b[k]))).collect();
        Ok(Part { fingerprint, samples: start..end, film: Film::from_sums(width, height, end - start, sums) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_come_back_and_damage_is_named() {
        let mut film = Film::new(4, 3);
        film.rows_mut().enumerate().for_each(|(y, row)| row.fill(y as i64 * 77 - 5));
        film.advance(9);
        let part = Part { fingerprint: 0xfeed, samples: 2..11, film };
        let bytes = part.to_bytes();
        assert_eq!(Part::from_bytes(&bytes), Ok(part));
        for (cut, what) in [(3, "VELLUSF1"), (20, "header"), (bytes.len() - 1, "announces")] {
            assert!(Part::from_bytes(&bytes[..cut]).unwrap_err().contains(what));
        }
        let mut huge = bytes;
        huge[8..12].fill(0xff);
        assert!(Part::from_bytes(&huge).is_err());
    }
}
