//! Films as files: checkpoints, and sample ranges to merge.
//!
//! Layout, little endian: `VELLUSF3`; u32 width and height of the whole picture; u32 left column, top row, width,
//! height of the part; u32 its layers, a bit each in the order of [`Layer::ALL`](crate::Layer::ALL); 32 bytes of the
//! digest of what was rendered; u64 first sample, the one after the last, and the one after the last that was asked
//! for; the names of the light groups; the notes, names and values alternating; the sums, row by row, u32 words as
//! `sums.rs` describes; and 32 bytes of the digest (BLAKE3) of all bytes before. Names and notes are a u32 count of
//! texts, each a u32 count of bytes of UTF-8.

use crate::error::Error;
use crate::film::Film;
use crate::film::layout::Layout;
use std::ops::Range;
use vellus_io::Digest;

const MAGIC: &[u8; 8] = b"VELLUSF3";

/// Bytes of a digest.
const DIGEST: usize = 32;

/// Samples a pixel can have: its coverage then still fits a sum.
pub const MAX_SAMPLES: u64 = (1 << 31) - 1;

/// A film and which samples of what are in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// Equal for parts of the same picture: the digest of everything that can change one of its pixels.
    pub identity: Digest,
    /// Its samples.
    pub samples: Range<u64>,
    /// The sample after the last that was asked for. `samples.end` is smaller where rendering was interrupted or
    /// reached another goal before.
    pub planned: u64,
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

    fn digest(&mut self) -> Result<Digest, String> {
        let bytes = self.take(DIGEST)?;
        Ok(Digest(std::array::from_fn(|k| bytes[k])))
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

impl Checkpoint {
    /// The file's bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let film = &self.film;
        let mut bytes = Vec::with_capacity(4 * film.sums().len() + 4096);
        bytes.extend(MAGIC);
        for n in film.whole().into_iter().chain(film.area()) {
            bytes.extend((n as u32).to_le_bytes());
        }
        bytes.extend(film.layout().bits().to_le_bytes());
        bytes.extend(self.identity.0);
        for n in [self.samples.start, self.samples.end, self.planned] {
            bytes.extend(n.to_le_bytes());
        }
        put_texts(&mut bytes, film.layout().groups().iter().map(String::as_str));
        let notes: Vec<&str> = self.notes.iter().flat_map(|(name, value)| [name.as_str(), value]).collect();
        put_texts(&mut bytes, notes.into_iter());
        bytes.extend(film.sums().iter().flat_map(|word| word.to_le_bytes()));
        let digest = Digest::of(&bytes);
        bytes.extend(digest.0);
        bytes
    }

    /// Reads the bytes of a file that [`Checkpoint::to_bytes`] wrote.
    ///
    /// # Errors
    /// [`Error::Malformed`] says what is wrong with them.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        Checkpoint::parse(bytes).map_err(Error::Malformed)
    }

    fn parse(bytes: &[u8]) -> Result<Self, String> {
        if !bytes.starts_with(MAGIC) {
            return Err("it does not begin with VELLUSF3: it is no film, or one of another version".to_owned());
        }
        let content = bytes.len().saturating_sub(DIGEST).max(MAGIC.len());
        let (content, digest) = bytes.split_at(content);
        if Digest::of(content).0 != digest {
            return Err("it is damaged: its checksum does not match its content".to_owned());
        }
        let mut rest = Rest(&content[MAGIC.len()..]);
        let whole = [rest.small()?, rest.small()?];
        let area = [rest.small()?, rest.small()?, rest.small()?, rest.small()?];
        let layers = rest.small()? as u32;
        let (identity, samples, planned) = (rest.digest()?, rest.large()?..rest.large()?, rest.large()?);
        let (groups, notes) = (rest.texts()?, rest.texts()?);
        let fits = |k: usize| (1..=1 << 16).contains(&area[k + 2]) && area[k] + area[k + 2] <= whole[k];
        if whole.iter().any(|n| *n > 1 << 16) || !fits(0) || !fits(1) {
            return Err(format!("its part {area:?} of a picture of {whole:?} is not one this version writes"));
        }
        let layout = Layout::from_bits(layers, &groups);
        let expected = (area[2] * area[3]) as u128 * layout.bytes_per_pixel() as u128;
        if layout.bits() != layers || rest.0.len() as u128 != expected {
            return Err(format!("{} bytes follow the header, which announces {expected}", rest.0.len()));
        }
        if layout.groups() != groups {
            return Err(format!("its layers do not have the light groups {groups:?}"));
        }
        if notes.len() % 2 == 1 {
            return Err(format!("{} names and values of notes are not pairs", notes.len()));
        }
        let in_order = samples.start <= samples.end && samples.end <= planned;
        if !in_order || samples.end - samples.start > MAX_SAMPLES {
            return Err(format!("its samples run from {} to {} of {planned}", samples.start, samples.end));
        }
        let sums = rest.0.chunks_exact(4).map(|b| u32::from_le_bytes(std::array::from_fn(|k| b[k]))).collect();
        let film = Film::new(whole, area, layout).with_sums(samples.end - samples.start, sums);
        let notes = notes.chunks_exact(2).map(|pair| (pair[0].clone(), pair[1].clone())).collect();
        Ok(Checkpoint { identity, samples, planned, notes, film })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Layer;

    fn part() -> Checkpoint {
        let groups = ["key".to_owned(), "Füllicht".to_owned()];
        let layout = Layout::new(&[Layer::Depth, Layer::Lights, Layer::Strand], &groups);
        let mut film = Film::new([9, 8], [2, 3, 4, 3], layout);
        let length = 4 * film.layout().words();
        film.add_rows((0..3).map(|y| vec![y * 77 + 5; length]));
        film.advance(9);
        let notes = vec![("vellus_command".to_owned(), "vellus render 狐.usda".to_owned())];
        Checkpoint { identity: Digest([0xfe; 32]), samples: 2..11, planned: 12, notes, film }
    }

    #[test]
    fn parts_come_back() {
        assert_eq!(Checkpoint::from_bytes(&part().to_bytes()).unwrap(), part());
    }

    #[test]
    fn any_damage_is_noticed() {
        let bytes = part().to_bytes();
        for end in 0..bytes.len() {
            assert!(Checkpoint::from_bytes(&bytes[..end]).is_err(), "{end}");
        }
        for at in 0..bytes.len() {
            let mut flipped = bytes.clone();
            flipped[at] ^= 1 << (at % 8);
            let error = Checkpoint::from_bytes(&flipped).unwrap_err().to_string();
            assert!(error.contains(if at < 8 { "VELLUSF3" } else { "checksum" }), "{at}: {error}");
        }
        assert!(Checkpoint::from_bytes(&[&bytes[..], b"\0"].concat()).is_err());
    }

    #[test]
    fn headers_that_do_not_fit_are_refused_even_with_a_checksum() {
        let bytes = part().to_bytes();
        let signed = |mut content: Vec<u8>| {
            let digest = Digest::of(&content);
            content.extend(digest.0);
            content
        };
        let content = &bytes[..bytes.len() - DIGEST];
        for cut in [8, 20, 70, content.len() - 1] {
            assert!(Checkpoint::from_bytes(&signed(content[..cut].to_vec())).is_err(), "{cut}");
        }
        let mut odd = content.to_vec();
        let notes = odd.windows(4).position(|b| b == b"vell").unwrap() - 8;
        odd[notes..notes + 4].copy_from_slice(&1u32.to_le_bytes());
        assert!(Checkpoint::from_bytes(&signed(odd)).is_err());
        // Sizes, layers, samples, groups: all but the digest of what was rendered, which is at 36.
        for lie in [8, 16, 24, 32, 72, 80, 92] {
            let mut huge = content.to_vec();
            huge[lie..lie + 4].fill(0xff);
            assert!(Checkpoint::from_bytes(&signed(huge)).is_err(), "{lie}");
        }
    }
}
