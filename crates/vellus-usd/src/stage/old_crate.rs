//! Rewrites binary layers in a form that `openusd` reads: those of versions before 0.7, and empty arrays of strings.
//!
//! Before 0.4, the tables were not compressed. Before 0.7, `openusd` misreads the times of samples and arrays of
//! strings, and may ask for so much memory that the program ends.

use super::usdc_check::{Cursor, DEEPEST, STRINGS};
use crate::error::Invalid;
use crate::write::crate_file::{MOST_BYTES, lz4, pack_integers};
use std::collections::HashMap;

/// The bit of arrays, and the type of an array of doubles.
const ARRAY: u64 = 1 << 63;
const DOUBLES: u64 = 9 << 48;
/// Types of values.
const DICTIONARY: u64 = 31;
const SAMPLES: u64 = 46;
const LIST_OF_DOUBLES: u64 = 48;
/// The bits of a value that are its position.
const POSITION: u64 = 0xffff_ffff_ffff;

/// The largest number of tables. A layer has six.
const MOST_TABLES: u64 = 32;

/// The version of a layer.
pub(crate) fn version(bytes: &[u8]) -> Result<[u8; 3], Invalid> {
    Cursor { bytes, at: 8 }.array::<3>().map_err(Invalid)
}

/// A layer of a version before 0.4 as one of version 0.4: with compressed tables, behind all else.
pub(crate) fn with_new_tables(bytes: Vec<u8>) -> Result<Vec<u8>, Invalid> {
    let old = version(&bytes)?;
    if old >= [0, 4, 0] {
        return Ok(bytes);
    }
    if bytes.len() > MOST_BYTES {
        return Err("a layer of a version before 0.4 is larger than 2 GB".into());
    }
    // In the first version, each path and spec begins with 4 bytes without meaning.
    let is_padded = old < [0, 1, 0];
    let mut contents = Cursor { bytes: &bytes, at: Cursor { bytes: &bytes, at: 16 }.u64()? };
    let count = contents.u64()?;
    if count > MOST_TABLES {
        return Err(format!("it claims {count} tables: at most {MOST_TABLES} are read").into());
    }
    let mut sections = Vec::new();
    for _ in 0..count {
        sections.push((contents.array::<16>()?, contents.u64()?, contents.u64()?));
    }
    let named = |name: &[u8; 16]| name.split(|&b| b == 0).next().unwrap_or_default().to_vec();
    let tokens = sections.iter().find(|(name, ..)| named(name) == b"TOKENS").map(|&(_, at, _)| at);
    let tokens = tokens.map_or(Ok(0), |at| Cursor { bytes: &bytes, at }.u64())?;
    let mut new = bytes.clone();
    let mut table = count.to_le_bytes().to_vec();
    for (name, mut start, mut size) in sections {
        let at = Cursor { bytes: &bytes, at: start };
        let rewritten = match &named(&name)[..] {
            b"TOKENS" => Some(with_copy(at)?),
            b"FIELDS" => Some(fields(at)?),
            b"FIELDSETS" => Some(columns(&rows::<1>(at)?, [0])),
            b"PATHS" => Some(paths(at, is_padded, tokens)?),
            b"SPECS" if is_padded => Some(columns(&rows::<4>(at)?, [1, 2, 3])),
            b"SPECS" => Some(columns(&rows::<3>(at)?, [0, 1, 2])),
            _ => None,
        };
        if let Some(rewritten) = rewritten {
            (start, size) = (new.len() as u64, rewritten.len() as u64);
            new.extend(rewritten);
        }
        table.extend([&name[..], &start.to_le_bytes(), &size.to_le_bytes()].concat());
    }
    let place = (new.len() as u64).to_le_bytes();
    new.extend(table);
    new[8..11].copy_from_slice(&[0, 4, 0]);
    new[16..24].copy_from_slice(&place);
    Ok(new)
}

/// The tokens, and a copy of the first one at their end: the token of a property has a minus sign, which 0 cannot have.
fn with_copy(mut at: Cursor) -> Result<Vec<u8>, Invalid> {
    let (count, size) = (at.u64()?, at.u64()?);
    let mut tokens = at.bytes(size)?.to_vec();
    let first = tokens.iter().position(|&b| b == 0).map_or(tokens.len(), |end| end + 1);
    tokens.extend_from_within(..first);
    Ok([&(count + 1).to_le_bytes()[..], &(tokens.len() as u64).to_le_bytes(), &lz4(&tokens)].concat())
}

/// A list of rows of numbers with 4 bytes.
fn rows<const N: usize>(mut at: Cursor) -> Result<Vec<[u32; N]>, Invalid> {
    let count = at.u64()?;
    let bytes = at.bytes(count.saturating_mul(4 * N as u64))?;
    let number = |row: &[u8], i: usize| u32::from_le_bytes([0, 1, 2, 3].map(|b| row[4 * i + b]));
    Ok(bytes.chunks_exact(4 * N).map(|row| std::array::from_fn(|i| number(row, i))).collect())
}

/// The number of rows, and some of their columns, compressed.
fn columns<const N: usize, const M: usize>(rows: &[[u32; N]], wanted: [usize; M]) -> Vec<u8> {
    let pack = |i: usize| pack_integers(rows.iter().map(move |row| row[i].cast_signed()));
    [(rows.len() as u64).to_le_bytes().to_vec()].into_iter().chain(wanted.map(pack)).flatten().collect()
}

fn fields(at: Cursor) -> Result<Vec<u8>, Invalid> {
    let rows = rows::<4>(at)?;
    let values: Vec<u8> = rows.iter().flat_map(|row| [row[2].to_le_bytes(), row[3].to_le_bytes()].concat()).collect();
    Ok([columns(&rows, [1]), lz4(&values)].concat())
}

/// The tree of paths, parents before their children. A path with a child and a sibling has the position of the sibling.
fn paths(mut at: Cursor, is_padded: bool, tokens: u64) -> Result<Vec<u8>, Invalid> {
    let count = at.u64()?;
    // Each path has at least 12 bytes.
    Cursor { ..at }.skip(count, 12)?;
    let copy = i32::try_from(tokens).map_err(|_| "it claims too many tokens")?;
    // Paths, their tokens, and where the next sibling is.
    let mut entries: Vec<[i32; 3]> = Vec::new();
    let mut siblings: Vec<(usize, u64)> = Vec::new();
    loop {
        if entries.len() as u64 >= count {
            return Err(format!("it claims {count} paths, but encodes more").into());
        }
        if is_padded {
            at.u32()?;
        }
        let [path, token, bits] = [at.u32()? as u32, at.u32()? as u32, at.u32()? as u32 & 7];
        let token = if token == 0 { copy } else { token.cast_signed() };
        let entry = entries.len();
        entries.push([path.cast_signed(), if bits & 4 == 0 { token } else { token.wrapping_neg() }, 0]);
        match bits & 3 {
            0 => {
                entries[entry][2] = -2;
                let Some((sibling, place)) = siblings.pop() else { break };
                entries[sibling][2] = (entries.len() - sibling) as i32;
                at.at = place;
            }
            1 => entries[entry][2] = -1,
            2 => {}
            _ => siblings.push((entry, at.u64()?)),
        }
    }
    let encoded = (entries.len() as u64).to_le_bytes();
    let columns = [0, 1, 2].map(|i| pack_integers(entries.iter().map(move |entry| entry[i])));
    Ok([&count.to_le_bytes()[..], &encoded, &columns.concat()].concat())
}

/// The layer with the values as they are in version 0.7, as far as `openusd` misreads them: lists of doubles, such as
/// the times of samples, and arrays of strings and files, whose number must have 8 bytes, also if it is 0. `fields` has
/// the token and the value of each field. Nothing if there are none.
pub(crate) fn with_new_values(bytes: &[u8], fields: &[(usize, u64)]) -> Result<Option<Vec<u8>>, Invalid> {
    let mut values =
        Values { bytes, old: version(bytes)?, new: bytes.to_vec(), moved: HashMap::new(), budget: bytes.len() };
    let new: Vec<u64> = fields.iter().map(|&(_, value)| values.renew(value, 0)).collect::<Result<_, _>>()?;
    if new.iter().zip(fields).any(|(new, (_, old))| new != old) {
        let table = [
            (new.len() as u64).to_le_bytes().to_vec(),
            pack_integers(fields.iter().map(|&(token, _)| token as i32)),
            lz4(&new.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>()),
        ];
        values.replace_section(b"FIELDS", &table.concat())?;
    }
    Ok((values.new.len() > bytes.len()).then_some(values.new))
}

/// The values of an old layer, while new ones are written behind all else.
struct Values<'a> {
    bytes: &'a [u8],
    old: [u8; 3],
    new: Vec<u8>,
    /// The new values of old ones.
    moved: HashMap<u64, u64>,
    /// How many more values may be visited: a file has fewer than bytes, unless values contain each other.
    budget: usize,
}

impl Values<'_> {
    /// The value that takes the place of another one. Values inside it are replaced where they are.
    fn renew(&mut self, value: u64, depth: usize) -> Result<u64, Invalid> {
        if depth > DEEPEST || self.budget == 0 {
            return Err("values are nested in a circle".into());
        }
        self.budget -= 1;
        let mut at = Cursor { bytes: self.bytes, at: value & POSITION };
        match (value >> 48 & 0xff, value >> 62) {
            (DICTIONARY, 0) => {
                for _ in 0..at.u64()? {
                    at.u32()?;
                    at.follow()?;
                    self.renew_at(&mut at, depth)?;
                }
            }
            (SAMPLES, 0) => {
                at.follow()?;
                self.renew_at(&mut at, depth)?;
                at.follow()?;
                for _ in 0..at.u64()? {
                    self.renew_at(&mut at, depth)?;
                }
            }
            (LIST_OF_DOUBLES, 0) if self.old < [0, 7, 0] => {
                let count = u32::try_from(at.u64()?).map_err(|_| "a value has too many samples")?;
                let rank = if self.old < [0, 5, 0] { &1u32.to_le_bytes()[..] } else { &[] };
                let head = [rank, &count.to_le_bytes()].concat();
                return self.moved_to(value, ARRAY | DOUBLES, &head, at.bytes(8 * u64::from(count))?);
            }
            // An empty array has no position, which the decoder does not know.
            (kind, 2 | 3) if STRINGS.contains(&kind) && at.at == 0 => {
                return self.moved_to(value, value & !POSITION, &0u64.to_le_bytes(), &[]);
            }
            (kind, 2) if STRINGS.contains(&kind) && self.old < [0, 7, 0] => {
                if self.old < [0, 5, 0] {
                    at.u32()?;
                }
                let count = at.u32()?;
                return self.moved_to(value, value & !POSITION, &count.to_le_bytes(), at.bytes(4 * count)?);
            }
            _ => {}
        }
        Ok(value)
    }

    /// Renews the next value, whose bits are here.
    fn renew_at(&mut self, at: &mut Cursor, depth: usize) -> Result<(), Invalid> {
        let place = usize::try_from(at.at).unwrap_or(usize::MAX);
        let new = self.renew(at.u64()?, depth + 1)?;
        self.new[place..place + 8].copy_from_slice(&new.to_le_bytes());
        Ok(())
    }

    /// Appends a value, and returns its bits.
    fn moved_to(&mut self, old: u64, kind: u64, head: &[u8], items: &[u8]) -> Result<u64, Invalid> {
        if let Some(known) = self.moved.get(&old) {
            return Ok(*known);
        }
        let new = kind | self.new.len() as u64;
        self.new.extend([head, items].concat());
        if self.new.len() > 2 * self.bytes.len() {
            return Err("the values of an old layer overlap".into());
        }
        self.moved.insert(old, new);
        Ok(new)
    }

    /// Appends a table, and changes its position in the table of contents.
    fn replace_section(&mut self, wanted: &[u8], table: &[u8]) -> Result<(), Invalid> {
        let mut contents = Cursor { bytes: self.bytes, at: Cursor { bytes: self.bytes, at: 16 }.u64()? };
        for _ in 0..contents.u64()? {
            let name = contents.array::<16>()?;
            let entry = usize::try_from(contents.at).unwrap_or(usize::MAX);
            contents.skip(2, 8)?;
            if name.starts_with(wanted) && name[wanted.len()] == 0 {
                let place = [self.new.len() as u64, table.len() as u64];
                self.new[entry..entry + 8].copy_from_slice(&place[0].to_le_bytes());
                self.new[entry + 8..entry + 16].copy_from_slice(&place[1].to_le_bytes());
            }
        }
        self.new.extend_from_slice(table);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openusd::usdc::CrateFile;
    use std::io;

    /// A layer with the prims /a, /a/b and /c, and the property /a.x, whose token is the first one.
    fn layer(is_first: bool) -> Vec<u8> {
        let padding: &[u32] = if is_first { &[0] } else { &[] };
        let mut bytes =
            [b"PXR-USDC\0".as_slice(), &[u8::from(!is_first), is_first.into(), 0, 0, 0, 0, 0], &[0; 8]].concat();
        let words = |words: &[u32]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
        let tokens = [words(&[4, 0, 8, 0]), b"x\0a\0b\0c\0".to_vec()].concat();
        let fields = words(&[1, 0, 0, 2, 7, 9 << 16]);
        let sets = words(&[2, 0, 0, u32::MAX]);
        let spec = |path: u32, kind: u32| words(&[padding, &[path, 0, kind]].concat());
        let specs = [words(&[2, 0]), spec(1, 6), spec(3, 1)].concat();
        let header = |path: u32, token: u32, bits: u32| words(&[padding, &[path, token, bits]].concat());
        let size = header(0, 0, 0).len() as u64;
        let strings = words(&[2, 0, 3, 1]);
        let before = (24 + tokens.len() + strings.len() + fields.len() + sets.len() + specs.len() + 8) as u64;
        let sibling = (before + 4 * size + 8).to_le_bytes().to_vec();
        // /, /a with a child and a sibling, /a/b with a sibling, /a.x, /c.
        let tree = [header(0, 0, 1), header(1, 1, 3), sibling, header(2, 2, 2), header(3, 0, 4), header(4, 3, 0)];
        let paths = [words(&[5, 0]), tree.concat()].concat();
        let mut table = 6u64.to_le_bytes().to_vec();
        for (name, section) in [
            ("TOKENS", tokens),
            ("STRINGS", strings),
            ("FIELDS", fields),
            ("FIELDSETS", sets),
            ("SPECS", specs),
            ("PATHS", paths),
        ] {
            let mut padded = [0; 16];
            padded[..name.len()].copy_from_slice(name.as_bytes());
            let place = [bytes.len() as u64, section.len() as u64];
            table.extend([&padded[..], &place[0].to_le_bytes(), &place[1].to_le_bytes()].concat());
            bytes.extend(section);
        }
        let place = (bytes.len() as u64).to_le_bytes();
        bytes[16..24].copy_from_slice(&place);
        [bytes, table].concat()
    }

    #[test]
    fn old_tables_have_the_same_entries() {
        for is_first in [true, false] {
            let bytes = with_new_tables(layer(is_first)).unwrap();
            let file = CrateFile::open(io::Cursor::new(&bytes)).unwrap();
            let paths: Vec<&str> = file.paths.iter().map(|path| path.as_str()).collect();
            assert_eq!(paths, ["/", "/a", "/a/b", "/a.x", "/c"]);
            assert_eq!(file.tokens, ["x", "a", "b", "c", "x"]);
            assert_eq!((file.fields[0].token_index, file.fields[0].value_rep.0), (2, 9 << 48 | 7));
            assert_eq!(file.fieldsets, [Some(0), None]);
            let specs: Vec<_> = file.specs.iter().map(|spec| (spec.path_index, spec.fieldset_index)).collect();
            assert_eq!(specs, [(1, 0), (3, 0)]);
        }
    }

    /// In a field, in samples, and in a dictionary.
    #[test]
    fn old_arrays_of_strings_are_read() {
        use openusd::sdf::Value;
        let mut bytes = with_new_tables(layer(false)).unwrap();
        let mut put = |words: &[u64]| {
            let place = bytes.len() as u64;
            words.iter().for_each(|word| bytes.extend(word.to_le_bytes()));
            place
        };
        // One dimension, two strings.
        let array = ARRAY | STRINGS[0] << 48 | put(&[2 << 32 | 1, 1 << 32]);
        let times = LIST_OF_DOUBLES << 48 | put(&[1, 1f64.to_bits()]);
        let samples = SAMPLES << 48 | put(&[8, times, 8, 1, array]);
        // One entry, with the name of the string 0 and an offset of 8.
        let dictionary = DICTIONARY << 48 | put(&[1, 8 << 32, array << 32, array >> 32]);
        for value in [array, samples, dictionary] {
            let fields = [(2, value)];
            let new = with_new_values(&bytes, &fields).unwrap().unwrap();
            let mut file = CrateFile::open(io::Cursor::new(&new)).unwrap();
            let mut found = file.fields[0].value_rep;
            if value != array {
                // It is changed in its place.
                found.0 = value;
            }
            let strings = match file.value(found).unwrap() {
                Value::TimeSamples(samples) => samples[0].1.clone(),
                Value::Dictionary(all) => all["c"].clone(),
                other => other,
            };
            assert_eq!(strings, Value::StringVec(vec!["c".to_owned(), "a".to_owned()]));
        }
        assert_eq!(with_new_values(&bytes, &[(2, 1 << 62)]), Ok(None));
        bytes[9] = 8;
        let new = with_new_values(&bytes, &[(2, ARRAY | STRINGS[1] << 48)]).unwrap().unwrap();
        let mut file = CrateFile::open(io::Cursor::new(&new)).unwrap();
        let found = file.fields[0].value_rep;
        assert_eq!(file.value(found).unwrap(), Value::AssetPathVec(Vec::new()));
        let circle = DICTIONARY << 48 | bytes.len() as u64;
        bytes.extend([1u64, 8 << 32, circle << 32, circle >> 32].iter().flat_map(|word| word.to_le_bytes()));
        assert!(with_new_values(&bytes, &[(2, circle)]).unwrap_err().0.contains("in a circle"));
    }

    #[test]
    fn damaged_old_layers_are_errors() {
        let good = layer(true);
        for end in 0..good.len() {
            assert!(with_new_tables(good[..end].to_vec()).is_err(), "{end}");
        }
        for at in 24..good.len() {
            let mut bytes = good.clone();
            bytes[at] = 0xff;
            // No panic, and no endless loop.
            let _ = with_new_tables(bytes);
        }
    }
}
