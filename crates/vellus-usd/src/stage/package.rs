//! Reads packages (.usdz): zip archives whose files are stored without compression.
//!
//! The directory is checked before anything else is read, so a broken archive costs neither time nor memory. Offsets
//! and sizes are from PKWARE's APPNOTE, sections 4.3.7 (local header), 4.3.12 (directory) and 4.3.16 (end of the
//! directory).

use std::collections::HashMap;
use std::io::{Error, ErrorKind, Read, Result, Seek, SeekFrom};

/// The first bytes of a package: USDZ has nothing before the first file.
const MAGIC: [u8; 4] = *b"PK\x03\x04";

const LOCAL_HEADER: usize = 30;
const ENTRY: usize = 46;
const END: usize = 22;

/// The longest comment at the end of an archive.
const MAX_COMMENT: usize = u16::MAX as usize;

/// The largest directory: 64 MiB. This is 1 KiB for each of the 65,535 files that an archive can have.
const MAX_DIRECTORY: u32 = 64 << 20;

/// The position of a file in an archive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Entry {
    header: u64,
    size: u64,
}

/// The directory of a package.
#[derive(Debug)]
pub(super) struct Package {
    entries: HashMap<String, Entry>,
    root: Option<String>,
}

impl Package {
    /// Reads and checks the directory of an archive of `length` bytes.
    pub fn open(archive: &mut (impl Read + Seek), length: u64) -> Result<Self> {
        let magic = bytes_at(archive, length, 0, MAGIC.len());
        if !magic.is_ok_and(|magic| magic == MAGIC) {
            return Err(broken("it is no zip archive"));
        }
        let tail = length.min((END + MAX_COMMENT) as u64);
        let end = bytes_at(archive, length, length - tail, tail as usize)?;
        let end = (0..=end.len().saturating_sub(END)).rev().map(|i| &end[i..]).find(|end| {
            // The comment ends where the file ends.
            end.len() >= END && end.starts_with(b"PK\x05\x06") && end.len() == END + usize::from(u16_at(end, 20))
        });
        let end = end.ok_or_else(|| broken("it has no directory"))?;
        let (count, size, start) = (u16_at(end, 10), u32_at(end, 12), u32_at(end, 16));
        if size > MAX_DIRECTORY {
            return Err(broken(&format!("its directory has {size} bytes: at most {MAX_DIRECTORY} are supported")));
        }
        let directory = bytes_at(archive, length, u64::from(start), size as usize)?;
        let mut rest = &directory[..];
        let mut package = Package { entries: HashMap::new(), root: None };
        let mut total = 0;
        for _ in 0..count {
            let Some((header, more)) =
                rest.split_at_checked(ENTRY).filter(|(header, _)| header.starts_with(b"PK\x01\x02"))
            else {
                return Err(broken("its directory is cut off or garbled"));
            };
            let (name, extra) = (usize::from(u16_at(header, 28)), usize::from(u16_at(header, 30)));
            let whole = name + extra + usize::from(u16_at(header, 32));
            let (Some(name), Some(next)) = (more.get(..name), more.get(whole..)) else {
                return Err(broken("its directory is cut off or garbled"));
            };
            rest = next;
            let name = std::str::from_utf8(name).map_err(|_| broken("a file in it has a name that is not UTF-8"))?;
            let (flags, method) = (u16_at(header, 8), u16_at(header, 10));
            let (packed, size) = (u32_at(header, 20), u32_at(header, 24));
            let entry = Entry { header: u64::from(u32_at(header, 42)), size: u64::from(size) };
            if method != 0 || flags & 1 != 0 || packed != size {
                return Err(broken(&format!("{name:?} in it is compressed or encrypted: USDZ allows neither")));
            }
            if entry.header + LOCAL_HEADER as u64 + entry.size > length {
                return Err(broken(&format!("{name:?} in it extends beyond the end of the archive")));
            }
            total += entry.size;
            if total > length {
                return Err(broken("its files together are larger than the archive"));
            }
            let is_layer = [".usd", ".usda", ".usdc"].iter().any(|extension| name.ends_with(extension));
            if is_layer && package.root.is_none() {
                package.root = Some(name.to_owned());
            }
            package.entries.entry(name.to_owned()).or_insert(entry);
        }
        Ok(package)
    }

    /// The root layer: the first layer of the package.
    pub fn root(&self) -> Option<&str> {
        self.root.as_deref()
    }

    /// Whether the package has a file of this name.
    pub fn contains(&self, name: &str) -> bool {
        self.entries.contains_key(name)
    }

    /// The bytes of a file. The archive must be that of [`Package::open`].
    pub fn read(&self, archive: &mut (impl Read + Seek), length: u64, name: &str) -> Result<Vec<u8>> {
        let entry = self
            .entries
            .get(name)
            .ok_or_else(|| Error::new(ErrorKind::NotFound, format!("it has no file {name:?}")))?;
        let header = bytes_at(archive, length, entry.header, LOCAL_HEADER)?;
        if !header.starts_with(&MAGIC) {
            return Err(broken(&format!("its directory has a wrong offset for {name:?}")));
        }
        let skipped = LOCAL_HEADER + usize::from(u16_at(&header, 26)) + usize::from(u16_at(&header, 28));
        bytes_at(archive, length, entry.header + skipped as u64, entry.size as usize)
    }
}

fn broken(what: &str) -> Error {
    Error::new(ErrorKind::InvalidData, format!("broken package: {what}"))
}

/// Reads `count` bytes from `start`. Returns an error before it allocates memory if the archive is shorter.
fn bytes_at(archive: &mut (impl Read + Seek), length: u64, start: u64, count: usize) -> Result<Vec<u8>> {
    if start.saturating_add(count as u64) > length {
        return Err(broken("it is cut off or garbled"));
    }
    archive.seek(SeekFrom::Start(start))?;
    let mut bytes = vec![0; count];
    archive.read_exact(&mut bytes)?;
    Ok(bytes)
}

fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn archive() -> Vec<u8> {
        let mut writer = openusd::usdz::ArchiveWriter::new(Cursor::new(Vec::new()));
        writer.add_layer("a.usda", b"one").unwrap();
        writer.add_layer("b/c.png", b"two").unwrap();
        writer.finish().unwrap().into_inner()
    }

    fn open(bytes: &[u8]) -> Result<Package> {
        Package::open(&mut Cursor::new(bytes), bytes.len() as u64)
    }

    #[test]
    fn stored_files_are_found() {
        let bytes = archive();
        let package = open(&bytes).unwrap();
        assert_eq!(package.root(), Some("a.usda"));
        let read = |name| package.read(&mut Cursor::new(&bytes), bytes.len() as u64, name);
        assert_eq!((read("a.usda").unwrap(), read("b/c.png").unwrap()), (b"one".to_vec(), b"two".to_vec()));
        assert!(read("c").unwrap_err().to_string().contains("\"c\"") && !package.contains("c"));
    }

    #[test]
    fn broken_archives_are_refused() {
        let whole = archive();
        let error = |bytes: &[u8]| open(bytes).unwrap_err().to_string();
        assert!(error(b"").contains("no zip") && error(&[b' '; 100_000]).contains("no zip"));
        // Any truncated archive is an error. Any archive with a changed byte is an error or a package, without a panic.
        (0..whole.len()).for_each(|end| assert!(open(&whole[..end]).is_err(), "{end}"));
        for at in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[at] ^= 0xff;
            if let Ok(package) = open(&bytes) {
                let names: Vec<_> = package.entries.keys().cloned().collect();
                names.iter().for_each(|name| drop(package.read(&mut Cursor::new(&bytes), bytes.len() as u64, name)));
            }
        }
        let directory = whole.windows(4).position(|four| four == b"PK\x01\x02").unwrap();
        let mut packed = whole.clone();
        packed[directory + 10] = 8;
        assert!(error(&packed).contains("compressed"));
        // Both files claim more than half of the archive.
        let second = directory + ENTRY + whole[directory..][28] as usize + whole[directory..][30] as usize;
        let mut large = whole.clone();
        for entry in [directory, second] {
            assert!(large[entry..].starts_with(b"PK\x01\x02"));
            let claimed = (whole.len() * 6 / 10) as u32;
            large[entry + 20..entry + 24].copy_from_slice(&claimed.to_le_bytes());
            large[entry + 24..entry + 28].copy_from_slice(&claimed.to_le_bytes());
        }
        let message = error(&large);
        assert!(message.contains("together") || message.contains("beyond"), "{message}");
    }
}
