//! Films as files: checkpoints, and sample ranges to merge.
//!
//! The format is little endian:
//!
//! | bytes | content |
//! |---|---|
//! | 8 | `VELLUSF3`, or `VELLUSF4` with adaptive sampling |
//! | 2 × u32 | width and height of the whole picture |
//! | 4 × u32 | left column, top row, width and height of the film's area |
//! | u32 | layers, one bit each in the order of [`Layer::ALL`](crate::Layer::ALL) |
//! | 32 | identity of the picture |
//! | 3 × u64 | first sample, end of the samples, end of the planned samples |
//! | texts | names of the light groups |
//! | texts | notes: names and values alternate |
//! | u64 | only with adaptive sampling: the nominal number of samples at the last plan |
//! | (u64, u32) … | only with adaptive sampling: samples at the last plan and rate, for each half of a tile |
//! | u32 … | sums, row by row, as described in `sums.rs` |
//! | texts | only with layers of Cryptomatte: object, look and group of each thing |
//! | u32 | only with layers of Cryptomatte: the number of counts |
//! | 3 × u32 … | counts: pixel, thing and samples, sorted by pixel and thing |
//! | 32 | BLAKE3 digest of all bytes before |
//!
//! Texts start with their number, a u32. Each text is its number of bytes, a u32, followed by these bytes in UTF-8.

use crate::error::Error;
use crate::film::Film;
use crate::film::cryptomatte::{Count, Thing};
use crate::film::layout::Layout;
use crate::film::tiles::{self, Tile, Tiles};
use std::ops::Range;
use vellus_io::Digest;

const MAGIC: &[u8; 8] = b"VELLUSF3";

/// The first bytes of films with adaptive sampling.
const ADAPTIVE_MAGIC: &[u8; 8] = b"VELLUSF4";

/// Bytes in a digest.
const DIGEST: usize = 32;

/// The largest number of samples per pixel for which the sum of the coverage cannot overflow.
pub const MAX_SAMPLES: u64 = (1 << 31) - 1;

/// A film with the range of its samples and the identity of its picture. This is enough to continue or merge it.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// The digest of everything that can change a pixel. Films of the same picture have the same digest. See
    /// [`Identity`](crate::session::Identity).
    pub identity: Digest,
    /// The range of samples of each pixel in the film.
    pub samples: Range<u64>,
    /// The end of the planned samples. `samples.end` is smaller if rendering was interrupted, or reached another goal
    /// first.
    pub planned: u64,
    /// Text attributes for the picture's file: names and values.
    pub notes: Vec<(String, String)>,
    /// The sums of the samples.
    pub film: Film,
}

fn put_texts<'a>(bytes: &mut Vec<u8>, texts: impl ExactSizeIterator<Item = &'a str>) {
    bytes.extend((texts.len() as u32).to_le_bytes());
    for text in texts {
        bytes.extend((text.len() as u32).to_le_bytes());
        bytes.extend(text.as_bytes());
    }
}

/// The bytes of a file that are still to be read.
struct Remaining<'a>(&'a [u8]);

impl<'a> Remaining<'a> {
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

    /// The tiles of a film with adaptive sampling.
    fn tiles(&mut self, halves: usize, samples: &Range<u64>) -> Result<Tiles, String> {
        let start = self.large()?;
        let mut tile = || Ok::<Tile, String>(Tile { base: self.large()?, rate: self.small()? as u32 });
        let tiles: Vec<Tile> = (0..halves).map(|_| tile()).collect::<Result<_, _>>()?;
        if samples.start == 0 && tiles.iter().all(|tile| tile.is_possible(start, samples.end)) {
            Ok(Tiles { start, tiles })
        } else {
            Err("its numbers of samples are not those of its tiles".to_owned())
        }
    }

    /// Things and their counts, which must be the last content.
    fn counts(&mut self, pixels: usize, samples: u64) -> Result<(Vec<Thing>, Vec<Count>), String> {
        let (names, rest) = self.texts()?.into_iter().fold((Vec::new(), Vec::new()), |(mut things, mut part), name| {
            part.push(name);
            if let [object, look, group] = &mut part[..] {
                let [object, look, group] = [object, look, group].map(std::mem::take);
                things.push(Thing { object, look, group });
                part.clear();
            }
            (things, part)
        });
        let count = self.small()?;
        let (entries, tail) = self.0.as_chunks::<12>();
        if !rest.is_empty() || !tail.is_empty() || entries.len() != count {
            return Err(format!("its header announces {count} counts of things, and {} bytes follow", self.0.len()));
        }
        let number = |entry: &[u8; 12], k: usize| u32::from_le_bytes(std::array::from_fn(|i| entry[4 * k + i]));
        let entry = |e: &[u8; 12]| Count { pixel: number(e, 0), thing: number(e, 1), samples: number(e, 2) };
        let counts: Vec<Count> = entries.iter().map(entry).collect();
        let known = |c: &Count| (c.pixel as usize) < pixels && (c.thing as usize) < names.len();
        let counted = |c: &Count| c.samples > 0 && u64::from(c.samples) <= samples;
        let sorted = counts.is_sorted_by(|a, b| (a.pixel, a.thing) < (b.pixel, b.thing));
        if sorted && counts.iter().all(|c| known(c) && counted(c)) {
            Ok((names, counts))
        } else {
            Err("its counts of things are not those of its pixels and samples".to_owned())
        }
    }
}

impl Checkpoint {
    /// The bytes of a file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let film = &self.film;
        let mut bytes = Vec::with_capacity(4 * film.sums().len() + 4096);
        bytes.extend(if film.is_adaptive() { ADAPTIVE_MAGIC } else { MAGIC });
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
        if let Some(Tiles { start, tiles }) = &film.tiles {
            bytes.extend(start.to_le_bytes());
            for tile in tiles {
                bytes.extend(tile.base.to_le_bytes());
                bytes.extend(tile.rate.to_le_bytes());
            }
        }
        bytes.extend(film.sums().iter().flat_map(|word| word.to_le_bytes()));
        if film.layout().has_counts() {
            let names = film.layout().things().iter().flat_map(|thing| [&thing.object, &thing.look, &thing.group]);
            let names: Vec<&str> = names.map(String::as_str).collect();
            put_texts(&mut bytes, names.into_iter());
            bytes.extend((film.counts().len() as u32).to_le_bytes());
            let counts = film.counts().iter().flat_map(|count| [count.pixel, count.thing, count.samples]);
            bytes.extend(counts.flat_map(u32::to_le_bytes));
        }
        let digest = Digest::of(&bytes);
        bytes.extend(digest.0);
        bytes
    }

    /// Reads the bytes of a file that [`Checkpoint::to_bytes`] wrote.
    ///
    /// # Errors
    /// [`Error::Malformed`] describes the problem.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        Checkpoint::parse(bytes).map_err(Error::Malformed)
    }

    fn parse(bytes: &[u8]) -> Result<Self, String> {
        let adaptive = bytes.starts_with(ADAPTIVE_MAGIC);
        if !adaptive && !bytes.starts_with(MAGIC) {
            let expected = "it does not begin with VELLUSF3 or VELLUSF4";
            return Err(format!("{expected}: it is no film, or one of another version"));
        }
        let content = bytes.len().saturating_sub(DIGEST).max(MAGIC.len());
        let (content, digest) = bytes.split_at(content);
        if Digest::of(content).0 != digest {
            return Err("it is damaged: its checksum does not match its content".to_owned());
        }
        let mut rest = Remaining(&content[MAGIC.len()..]);
        let whole = [rest.small()?, rest.small()?];
        let area = [rest.small()?, rest.small()?, rest.small()?, rest.small()?];
        let layers = rest.small()? as u32;
        let (identity, samples, planned) = (rest.digest()?, rest.large()?..rest.large()?, rest.large()?);
        let (groups, notes) = (rest.texts()?, rest.texts()?);
        let fits = |k: usize| (1..=1 << 16).contains(&area[k + 2]) && area[k] + area[k + 2] <= whole[k];
        if whole.iter().any(|n| *n > 1 << 16) || !fits(0) || !fits(1) {
            return Err(format!("its part {area:?} of a picture of {whole:?} is not one this version writes"));
        }
        let in_order = samples.start <= samples.end && samples.end <= planned;
        if !in_order || samples.end - samples.start > MAX_SAMPLES {
            return Err(format!("its samples run from {} to {} of {planned}", samples.start, samples.end));
        }
        let tiles = match adaptive {
            true => Some(rest.tiles(tiles::halves(area[2], area[3]), &samples)?),
            false => None,
        };
        let layout = Layout::from_bits(layers, &groups);
        let expected = (area[2] * area[3]) as u128 * layout.bytes_per_pixel() as u128;
        let fits = if layout.has_counts() { rest.0.len() as u128 > expected } else { rest.0.len() as u128 == expected };
        if layout.bits() != layers || !fits {
            return Err(format!("{} bytes follow the header, which announces {expected}", rest.0.len()));
        }
        if layout.groups() != groups {
            return Err(format!("its layers do not have the light groups {groups:?}"));
        }
        if notes.len() % 2 == 1 {
            return Err(format!("{} names and values of notes are not pairs", notes.len()));
        }
        let sums = rest
            .take(expected as usize)?
            .chunks_exact(4)
            .map(|b| u32::from_le_bytes(std::array::from_fn(|k| b[k])))
            .collect();
        let pixels = area[2] * area[3];
        let (things, counts) = if layout.has_counts() {
            let most = tiles.as_ref().map_or(samples.end - samples.start, |_| MAX_SAMPLES);
            rest.counts(pixels, most)?
        } else {
            (Vec::new(), Vec::new())
        };
        let layout = layout.with_things(&things);
        let mut film = Film::new(whole, area, layout).with_counts(counts).with_sums(samples.end - samples.start, sums);
        film.tiles = tiles;
        let notes = notes.chunks_exact(2).map(|pair| (pair[0].clone(), pair[1].clone())).collect();
        Ok(Checkpoint { identity, samples, planned, notes, film })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Layer;
    use rayon::prelude::{IntoParallelIterator, ParallelIterator};

    fn part() -> Checkpoint {
        let groups = ["key".to_owned(), "Füllicht".to_owned()];
        let layout = Layout::new(&[Layer::Depth, Layer::Lights, Layer::Strand], &groups);
        let mut film = Film::new([9, 8], [2, 3, 4, 3], layout);
        let length = 4 * film.layout().words();
        film.add_rows((0..3).into_par_iter().map(|y| vec![y * 77 + 5; length]));
        film.advance(9);
        let notes = vec![("vellus_command".to_owned(), "vellus render 狐.usda".to_owned())];
        Checkpoint { identity: Digest([0xfe; 32]), samples: 2..11, planned: 12, notes, film }
    }

    /// A film with counts of two things.
    fn counted(counts: &[[u32; 3]]) -> Checkpoint {
        let things = ["/a/fur", "/a/skin"].map(|name| Thing::new(name, "look", name.ends_with("fur")));
        let layout = Layout::new(&[Layer::CryptoObject], &[]).with_things(&things);
        let counts = counts.iter().map(|&[pixel, thing, samples]| Count { pixel, thing, samples }).collect();
        let mut film = Film::new([9, 8], [2, 3, 4, 3], layout).with_counts(counts);
        film.advance(9);
        Checkpoint { film, ..part() }
    }

    #[test]
    fn films_come_back() {
        for film in [part(), counted(&[]), counted(&[[0, 1, 9], [3, 0, 1], [3, 1, 8]])] {
            assert_eq!(Checkpoint::from_bytes(&film.to_bytes()).unwrap(), film);
        }
    }

    #[test]
    fn counts_that_do_not_fit_are_refused() {
        let wrong: [&[[u32; 3]]; 5] =
            [&[[12, 0, 1]], &[[0, 2, 1]], &[[0, 0, 0]], &[[0, 0, 10]], &[[1, 1, 1], [1, 0, 1]]];
        for counts in wrong {
            let error = Checkpoint::from_bytes(&counted(counts).to_bytes()).unwrap_err().to_string();
            assert!(error.contains("its counts of things"), "{counts:?}: {error}");
        }
        let bytes = counted(&[[0, 1, 9]]).to_bytes();
        for end in [DIGEST + 12, DIGEST + 5, DIGEST + 40] {
            let mut content = bytes[..bytes.len() - end].to_vec();
            let digest = Digest::of(&content);
            content.extend(digest.0);
            assert!(Checkpoint::from_bytes(&content).is_err(), "{end}");
        }
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
        // The offsets of sizes, layers, samples and groups. The identity at 36 is not among them.
        for lie in [8, 16, 24, 32, 72, 80, 92] {
            let mut huge = content.to_vec();
            huge[lie..lie + 4].fill(0xff);
            assert!(Checkpoint::from_bytes(&signed(huge)).is_err(), "{lie}");
        }
    }
}
