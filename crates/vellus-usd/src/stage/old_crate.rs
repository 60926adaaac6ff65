//! Rewrites binary layers of versions before 0.7 in a form that `openusd` reads.
//!
//! Before 0.4, the tables were not compressed. Before 0.7, `openusd` misreads the times of samples.

use super::usdc_check::Cursor;
use crate::error::Invalid;
use crate::write::crate_file::{MOST_BYTES, lz4, pack_integers};
use std::collections::HashMap;

/// The bits of a value that is an array of doubles, and of one that is a vector of them.
const DOUBLES: u64 = 1 << 63 | 9 << 48;
const DOUBLE_VECTOR: u64 = 48;
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

/// The layer with the times of samples as arrays, and nothing if it has none that `openusd` misreads.
pub(crate) fn with_new_times(
    bytes: &[u8],
    representations: impl Iterator<Item = u64>,
) -> Result<Option<Vec<u8>>, Invalid> {
    let old = version(bytes)?;
    let mut new = bytes.to_vec();
    let mut moved = HashMap::new();
    for value in representations.filter(|value| value >> 48 & 0xff == 46 && value >> 62 == 0) {
        let mut at = Cursor { bytes, at: value & POSITION };
        at.follow()?;
        let place = usize::try_from(at.at).unwrap_or(usize::MAX);
        let times = at.u64()?;
        if times >> 48 != DOUBLE_VECTOR {
            continue;
        }
        let array = match moved.get(&times) {
            Some(known) => *known,
            None => {
                let mut at = Cursor { bytes, at: times & POSITION };
                let count = u32::try_from(at.u64()?).map_err(|_| "a value has too many samples")?;
                let numbers = at.bytes(8 * u64::from(count))?;
                let array = DOUBLES | new.len() as u64;
                if old < [0, 5, 0] {
                    new.extend(1u32.to_le_bytes());
                }
                new.extend(count.to_le_bytes());
                new.extend(numbers);
                if new.len() > 2 * bytes.len() {
                    return Err("the times of samples overlap".into());
                }
                moved.insert(times, array);
                array
            }
        };
        new[place..place + 8].copy_from_slice(&array.to_le_bytes());
    }
    Ok((!moved.is_empty()).then_some(new))
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
        let before = (24 + tokens.len() + fields.len() + sets.len() + specs.len() + 8) as u64;
        let sibling = (before + 4 * size + 8).to_le_bytes().to_vec();
        // /, /a with a child and a sibling, /a/b with a sibling, /a.x, /c.
        let tree = [header(0, 0, 1), header(1, 1, 3), sibling, header(2, 2, 2), header(3, 0, 4), header(4, 3, 0)];
        let paths = [words(&[5, 0]), tree.concat()].concat();
        let mut table = 5u64.to_le_bytes().to_vec();
        for (name, section) in
            [("TOKENS", tokens), ("FIELDS", fields), ("FIELDSETS", sets), ("SPECS", specs), ("PATHS", paths)]
        {
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
