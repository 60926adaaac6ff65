//! Cryptomatte: which objects a pixel shows, and how much of it each of them covers.
//!
//! A film keeps exact counts of samples, so any division of the samples gives the same counts. Hashes, coverages and
//! ranks are only formed when a file is written, as the Cryptomatte specification 1.2 asks.

use crate::film::{Film, Layer};

/// The largest number of objects that a pixel has in a file. Three layers of four channels have two each.
pub(crate) const RANKS: usize = 6;

/// The names of something that a camera ray can hit: a set of strands or a mesh.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Thing {
    /// The object. If the name is a path, this is the path of the parent: in a file of Blender, a mesh and the hair on
    /// it have one parent.
    pub object: String,
    /// The look of strands, or the surface of a mesh.
    pub look: String,
    /// The name of a set of strands; empty for meshes.
    pub group: String,
}

impl Thing {
    /// The names of a set of strands or of a mesh with this name.
    pub(crate) fn new(name: &str, look: &str, is_strands: bool) -> Self {
        let parent = name.rsplit_once('/').map(|(parent, _)| parent).filter(|parent| parent.len() > 1);
        let group = if is_strands { name.to_owned() } else { String::new() };
        Thing { object: parent.unwrap_or(name).to_owned(), look: look.to_owned(), group }
    }

    /// The name in a layer; empty if it does not appear there.
    fn name(&self, layer: Layer) -> &str {
        match layer {
            Layer::CryptoObject => &self.object,
            Layer::CryptoLook => &self.look,
            Layer::CryptoGroup => &self.group,
            _ => "",
        }
    }
}

/// How many samples of a pixel hit a thing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Count {
    /// The pixel, counted row by row.
    pub pixel: u32,
    /// The index of the thing.
    pub thing: u32,
    /// At least 1.
    pub samples: u32,
}

/// Adds counts to counts. Both are sorted by pixel and thing, and so is the result.
pub(crate) fn merge(counts: &mut Vec<Count>, others: &[Count]) {
    if others.is_empty() {
        return;
    }
    let mut merged: Vec<Count> = Vec::with_capacity(counts.len().max(others.len()));
    let key = |count: &Count| (count.pixel, count.thing);
    let mut rest = others;
    for count in counts.iter() {
        let (smaller, larger) = rest.split_at(rest.partition_point(|other| key(other) < key(count)));
        merged.extend_from_slice(smaller);
        rest = larger;
        match rest.split_first() {
            Some((other, after)) if key(other) == key(count) => {
                merged.push(Count { samples: count.samples.saturating_add(other.samples), ..*count });
                rest = after;
            }
            _ => merged.push(*count),
        }
    }
    merged.extend_from_slice(rest);
    merged.shrink_to_fit();
    *counts = merged;
}

/// The hash of a name: MurmurHash3 (x86, 32 bits, seed 0), by Austin Appleby.
pub(crate) fn murmur3(name: &[u8]) -> u32 {
    let mix = |k: u32| k.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let (blocks, rest) = name.as_chunks::<4>();
    let hash = blocks.iter().fold(0u32, |hash, block| {
        (hash ^ mix(u32::from_le_bytes(*block))).rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    let tail = rest.iter().rev().fold(0, |tail, &byte| tail << 8 | u32::from(byte));
    let hash = hash ^ mix(tail) ^ name.len() as u32;
    let hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    let hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

/// The hash of a name whose bits are a normal float. The specification flips a bit of exponents that are all 0 or 1.
pub(crate) fn id(name: &str) -> u32 {
    let hash = murmur3(name.as_bytes());
    match hash >> 23 & 0xff {
        0 | 255 => hash ^ 1 << 23,
        _ => hash,
    }
}

/// The names of the channels of a layer, rank by rank: `CryptoObject00.R`, `CryptoObject00.G` and so on.
pub(crate) fn channel_names(layer: Layer) -> Vec<String> {
    let of_rank = |rank: usize| {
        let pair = if rank.is_multiple_of(2) { ["R", "G"] } else { ["B", "A"] };
        pair.map(|c| format!("{}{:02}.{c}", title(layer), rank / 2))
    };
    (0..RANKS).flat_map(of_rank).collect()
}

/// The name of a layer in a file.
fn title(layer: Layer) -> &'static str {
    match layer {
        Layer::CryptoLook => "CryptoMaterial",
        Layer::CryptoGroup => "CryptoGroup",
        _ => "CryptoObject",
    }
}

impl Film {
    /// The names of the things in a layer of [`Layer::CRYPTOMATTE`], sorted, with their ids in pixels.
    /// An id is the bits of a 32-bit float.
    pub fn ids(&self, layer: Layer) -> Vec<(&str, u32)> {
        ids(layer, self.layout().things())
    }
}

/// The names of a layer, sorted, with their ids.
fn ids(layer: Layer, things: &[Thing]) -> Vec<(&str, u32)> {
    let mut names: Vec<&str> = things.iter().map(|thing| thing.name(layer)).filter(|name| !name.is_empty()).collect();
    names.sort_unstable();
    names.dedup();
    names.into_iter().map(|name| (name, id(name))).collect()
}

/// The attributes of a layer in the header of a file: names and values.
pub(crate) fn attributes(layer: Layer, things: &[Thing]) -> [(String, String); 4] {
    let title = title(layer);
    let key = format!("{:08x}", murmur3(title.as_bytes()));
    let entry = |(name, id): (&str, u32)| format!("{}:\"{id:08x}\"", json(name));
    let manifest = format!("{{{}}}", ids(layer, things).into_iter().map(entry).collect::<Vec<_>>().join(","));
    [
        ("name", title.to_owned()),
        ("hash", "MurmurHash3_32".to_owned()),
        ("conversion", "uint32_to_float32".to_owned()),
        ("manifest", manifest),
    ]
    .map(|(name, value)| (format!("cryptomatte/{}/{name}", &key[..7]), value))
}

/// A text as JSON.
fn json(text: &str) -> String {
    let escaped: String = text
        .chars()
        .map(|c| match c {
            '"' | '\\' => format!("\\{c}"),
            c if c < ' ' => format!("\\u{:04x}", c as u32),
            c => c.to_string(),
        })
        .collect();
    format!("\"{escaped}\"")
}

impl Film {
    /// The values of the channels of a layer of Cryptomatte, pixel by pixel. A pixel has the ids with the largest
    /// coverage, the largest first. Of equal coverages, that of the smaller id comes first.
    pub(super) fn cryptomatte(&self, layer: Layer) -> Vec<Vec<f32>> {
        let width = self.width();
        let samples = |pixel: usize| self.samples_of(pixel % width, pixel / width);
        channels(layer, self.layout().things(), self.counts(), width * self.height(), samples)
    }
}

fn channels(
    layer: Layer,
    things: &[Thing],
    counts: &[Count],
    pixels: usize,
    samples: impl Fn(usize) -> u64,
) -> Vec<Vec<f32>> {
    let ids: Vec<Option<u32>> =
        things.iter().map(|thing| Some(thing.name(layer)).filter(|name| !name.is_empty()).map(id)).collect();
    let mut channels = vec![vec![0.0; pixels]; 2 * RANKS];
    for counts in counts.chunk_by(|a, b| a.pixel == b.pixel) {
        let mut ranks: Vec<(u32, u64)> = Vec::new();
        for count in counts {
            let Some(id) = ids[count.thing as usize] else { continue };
            match ranks.iter_mut().find(|rank| rank.0 == id) {
                Some(rank) => rank.1 += u64::from(count.samples),
                None => ranks.push((id, u64::from(count.samples))),
            }
        }
        ranks.sort_unstable_by_key(|&(id, samples)| (std::cmp::Reverse(samples), id));
        for (rank, &(id, count)) in ranks.iter().take(RANKS).enumerate() {
            let pixel = counts[0].pixel as usize;
            channels[2 * rank][pixel] = f32::from_bits(id);
            channels[2 * rank + 1][pixel] = (count as f64 / samples(pixel).max(1) as f64) as f32;
        }
    }
    channels
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vectors of the reference implementation, and the example of the specification.
    #[test]
    fn hashes_are_those_of_murmur3() {
        let vectors = [("", 0), ("a", 0x3c25_69b2), ("abc", 0xb3dd_93fa), ("hello", 0x248b_fa47)];
        for (name, hash) in vectors {
            assert_eq!(murmur3(name.as_bytes()), hash, "{name}");
        }
        assert_eq!(murmur3("The quick brown fox jumps over the lazy dog".as_bytes()), 0x2e4f_f723);
        assert!((0..100_000).all(|i| f32::from_bits(id(&i.to_string())).is_normal()));
    }

    #[test]
    fn objects_are_parents_of_paths() {
        let object = |name| Thing::new(name, "look", true).object;
        assert_eq!(["/root/Ball/P", "/fur", "fur"].map(object), ["/root/Ball", "/fur", "fur"]);
    }

    #[test]
    fn ranks_are_sorted_by_coverage() {
        let things: Vec<Thing> = ["a", "b", "c"].map(|name| Thing::new(name, "one", name != "b")).to_vec();
        let count = |pixel, thing, samples| Count { pixel, thing, samples };
        let counts = [count(1, 0, 2), count(1, 1, 4), count(1, 2, 2)];
        let at = |layer, rank: usize| {
            let channels = channels(layer, &things, &counts, 2, |_| 16);
            assert!(channels.iter().all(|values| values[0] == 0.0));
            (channels[2 * rank][1].to_bits(), channels[2 * rank + 1][1])
        };
        assert_eq!(at(Layer::CryptoObject, 0), (id("b"), 0.25));
        assert_eq!(at(Layer::CryptoObject, 1), (id("a").min(id("c")), 0.125));
        assert_eq!(at(Layer::CryptoLook, 0), (id("one"), 0.5));
        assert_eq!([0, 1, 2].map(|rank| at(Layer::CryptoGroup, rank).1), [0.125, 0.125, 0.0]);
        let [name, .., manifest] = attributes(Layer::CryptoGroup, &things);
        assert!(name.0.starts_with("cryptomatte/") && name.0.ends_with("/name") && name.0.len() == 24, "{name:?}");
        assert_eq!(manifest.1, format!("{{\"a\":\"{:08x}\",\"c\":\"{:08x}\"}}", id("a"), id("c")));
        assert_eq!(json("a\"\\\n"), "\"a\\\"\\\\\\u000a\"");
    }

    #[test]
    fn counts_are_added() {
        let count = |pixel, thing, samples| Count { pixel, thing, samples };
        let mut counts = vec![count(0, 1, 1), count(2, 0, 5)];
        merge(&mut counts, &[count(0, 0, 7), count(0, 1, 2), count(3, 0, 1)]);
        assert_eq!(counts, [count(0, 0, 7), count(0, 1, 3), count(2, 0, 5), count(3, 0, 1)]);
    }
}
