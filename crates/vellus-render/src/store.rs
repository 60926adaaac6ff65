//! Films as files that rendering goes on from: checkpoints, and parts to merge.
//!
//! Layout, little endian: `VELLUSF2`; u32 width and height of the whole picture; u32 left column, top row, width, height of the
//! part; u32 its layers, a bit each in the order of [`Layer::ALL`](crate::Layer::ALL); u64 fingerprint of what was rendered; u64
//! first sample and the one after the last; the names of the light groups; the notes, names and values in turn; then the sums as
//! i64, row by row. Names and notes are a u32 count of texts, each a u32 count of bytes of UTF-8.

use crate::film::Film;
use crate::layout::Layout;
use std::ops::Range;

const MAGIC: &[u8; 8] = b"VELLUSF2";

/// A film and which samples of what are in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Equal for parts of the same picture.
    pub fingerprint: u64,
    /// Its samples.
    pub samples: Range<u64>,
    /// What is written into the picture's file: names and values.
    pub notes: Vec<(String, String)>,
    /// Their sums.
    pub film: Film,
}

fn put_texts<'a>(bytes: &mut Vec<u8>, texts: impl ExactSizeIterator<Item = &'a str>) {
    bytes.extend((texts.len() as u32).to_le_bytes());
    for text in texts {
        bytes.extend((text.len() as u32).to_le_bytes());
        bytes.extend(text.as_bytes());
    }
}

/// What is left of a file.
struct Rest<'a>(&'a [u8]);

impl<'a> Rest<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (bytes, rest) = self.0.split_at_checked(count).ok_or("it ends inside its header")?;
        self.0 = rest;
        Ok(bytes)
    }

    fn small(&mut self) -> Result<usize, String> {
        let bytes = self.take(4)?;
        Ok(u32::from_le_bytes(std::array::from_fn(|k| bytes[k])) as usize)
    }

    fn large(&mut self) -> Result<u64, String> {
        let bytes = self.take(8)?;
        Ok(u64::from_le_bytes(std::array::from_fn(|k| bytes[k])))
    }

    fn texts(&mut self) -> Result<Vec<String>, String> {
        let mut texts = Vec::new();
        for _ in 0..self.small()? {
            let length = self.small()?;
            let text = self.take(length)?;
            texts.push(String::from_utf8(text.to_vec()).map_err(|_| "its names are not UTF-8")?);
        }
        Ok(texts)
    }
}

impl Part {
    /// The file's bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let film = &self.film;
        let mut bytes = Vec::with_capacity(8 * film.sums().len() + 4096);
        bytes.extend(MAGIC);
        for n in film.whole().into_iter().chain(film.area()) {
            bytes.extend((n as u32).to_le_bytes());
        }
        bytes.extend(film.layout().bits().to_le_bytes());
        for n in [self.fingerprint, self.samples.start, self.samples.end] {
            bytes.extend(n.to_le_bytes());
        }
        put_texts(&mut bytes, film.layout().groups().iter().map(String::as_str));
        let notes: Vec<&str> = self.notes.iter().flat_map(|(name, value)| [name.as_str(), value]).collect();
        put_texts(&mut bytes, notes.into_iter());
        bytes.extend(film.sums().iter().flat_map(|sum| sum.to_le_bytes()));
        bytes
    }

    /// Reads a file's bytes.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        let mut rest = Rest(bytes);
        if rest.take(8).is_ok_and(|magic| magic != MAGIC) || bytes.len() < 8 {
            return Err("it does not begin with VELLUSF2: not a film, or one of another version".to_owned());
        }
        let whole = [rest.small()?, rest.small()?];
        let area = [rest.small()?, rest.small()?, rest.small()?, rest.small()?];
        let layers = rest.small()? as u32;
        let (fingerprint, samples) = (rest.large()?, rest.large()?..rest.large()?);
        let (groups, notes) = (rest.texts()?, rest.texts()?);
        let fits = |k: usize| (1..=1 << 16).contains(&area[k + 2]) && area[k] + area[k + 2] <= whole[k];
        if whole.iter().any(|n| *n > 1 << 16) || !fits(0) || !fits(1) {
            return Err(format!("its part {area:?} of a picture of {whole:?} is not one this version writes"));
        }
        let layout = Layout::from_bits(layers, &groups);
        let expected = (area[2] * area[3]) as u128 * layout.channels() as u128 * 8;
        if layout.bits() != layers || rest.0.len() as u128 != expected {
            return Err(format!("{} bytes follow the header, which announces {expected}", rest.0.len()));
        }
        if layout.groups() != groups {
            return Err(format!("its layers have not the light groups {groups:?}"));
        }
        if notes.len() % 2 == 1 {
            return Err(format!("{} names and values of notes are not pairs", notes.len()));
        }
        if samples.end < samples.start {
            return Err(format!("its samples run from {} to {}", samples.start, samples.end));
        }
        let sums = rest.0.chunks_exact(8).map(|b| i64::from_le_bytes(std::array::from_fn(|k| b[k]))).collect();
        let film = Film::new(whole, area, layout).with_sums(samples.end - samples.start, sums);
        let notes = notes.chunks_exact(2).map(|pair| (pair[0].clone(), pair[1].clone())).collect();
        Ok(Part { fingerprint, samples, notes, film })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Layer;

    #[test]
    fn parts_come_back_and_damage_is_named() {
        let groups = ["key".to_owned(), "Füllicht".to_owned()];
        let layout = Layout::new(&[Layer::Depth, Layer::Lights, Layer::Strand], &groups);
        let mut film = Film::new([9, 8], [2, 3, 4, 3], layout);
        let length = 4 * film.layout().channels();
        film.add_rows((0..3).map(|y| vec![y * 77 + 5; length]));
        film.advance(9);
        let notes = vec![("vellus_command".to_owned(), "vellus render 狐.usda".to_owned())];
        let part = Part { fingerprint: 0xfeed, samples: 2..11, notes, film };
        let bytes = part.to_bytes();
        assert_eq!(Part::from_bytes(&bytes), Ok(part));
        for (cut, what) in [(3, "VELLUSF2"), (20, "header"), (70, "header"), (bytes.len() - 1, "announces")] {
            assert!(Part::from_bytes(&bytes[..cut]).unwrap_err().contains(what));
        }
        let mut odd = bytes.clone();
        let notes = odd.windows(4).position(|b| b == b"vell").unwrap() - 8;
        odd[notes..notes + 4].copy_from_slice(&1u32.to_le_bytes());
        assert!(Part::from_bytes(&odd).is_err());
        for lie in [8, 16, 24, 32, 36, 44, 60, 64] {
            let mut huge = bytes.clone();
            huge[lie..lie + 4].fill(0xff);
            // A fingerprint may be any; nothing else may.
            assert!(lie == 36 || Part::from_bytes(&huge).is_err(), "{lie}");
        }
    }
}
