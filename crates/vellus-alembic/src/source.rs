//! The bytes of an archive: in memory, or parts of a file as they are asked for.

use crate::error::{Error, damaged};
use std::borrow::Cow;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

/// The size of a block of a file that is kept, and how many are: the tree has many small parts near each other.
const BLOCK: usize = 1 << 16;
const KEPT: usize = 8;

/// The bytes of an archive.
#[derive(Clone, Debug)]
pub(crate) enum Source {
    Memory(Vec<u8>),
    File { file: Arc<Mutex<Blocks>>, length: usize },
}

/// A file, and the blocks that were read last, with their numbers.
#[derive(Debug)]
pub(crate) struct Blocks {
    file: File,
    kept: Vec<(usize, Vec<u8>)>,
}

impl Source {
    pub fn file(mut file: File) -> Result<Self, Error> {
        let length = file.seek(SeekFrom::End(0)).map_err(told)?;
        let length = usize::try_from(length).map_err(|_| damaged(0, "the file is too large"))?;
        Ok(Source::File { file: Arc::new(Mutex::new(Blocks { file, kept: Vec::new() })), length })
    }

    /// The number of bytes.
    pub fn len(&self) -> usize {
        match self {
            Source::Memory(bytes) => bytes.len(),
            Source::File { length, .. } => *length,
        }
    }

    /// A part, which must be inside.
    pub fn read(&self, range: Range<usize>) -> Result<Cow<'_, [u8]>, Error> {
        let outside = || damaged(range.start, format!("{} bytes are expected here", range.len()));
        match self {
            Source::Memory(bytes) => Ok(Cow::Borrowed(bytes.get(range.clone()).ok_or_else(outside)?)),
            Source::File { length, .. } if range.end > *length || range.start > range.end => Err(outside()),
            // A panic elsewhere leaves no block half read.
            Source::File { file, length } => {
                let mut blocks = file.lock().unwrap_or_else(PoisonError::into_inner);
                blocks.read(range, *length).map(Cow::Owned)
            }
        }
    }

    /// A number at a place.
    pub fn u64(&self, at: usize) -> Result<u64, Error> {
        let end =
            at.checked_add(8).filter(|end| *end <= self.len()).ok_or_else(|| damaged(at, "the file ends here"))?;
        let bytes = self.read(at..end)?;
        Ok(bytes.first_chunk::<8>().map_or(0, |word| u64::from_le_bytes(*word)))
    }
}

impl Blocks {
    fn read(&mut self, range: Range<usize>, length: usize) -> Result<Vec<u8>, Error> {
        if range.len() >= BLOCK {
            return self.part(range);
        }
        let mut bytes = Vec::with_capacity(range.len());
        let mut at = range.start;
        while at < range.end {
            let number = at / BLOCK;
            let place = match self.kept.iter().position(|(kept, _)| *kept == number) {
                Some(place) => place,
                None => {
                    let block = self.part(number * BLOCK..length.min((number + 1) * BLOCK))?;
                    self.kept.truncate(KEPT - 1);
                    self.kept.insert(0, (number, block));
                    0
                }
            };
            let block = &self.kept[place].1;
            let first = at - number * BLOCK;
            let last = (range.end - number * BLOCK).min(block.len());
            bytes.extend_from_slice(&block[first..last]);
            at = number * BLOCK + last;
        }
        Ok(bytes)
    }

    fn part(&mut self, range: Range<usize>) -> Result<Vec<u8>, Error> {
        let mut bytes = Vec::with_capacity(range.len());
        self.file.seek(SeekFrom::Start(range.start as u64)).map_err(told)?;
        (&mut self.file).take(range.len() as u64).read_to_end(&mut bytes).map_err(told)?;
        match bytes.len() == range.len() {
            true => Ok(bytes),
            false => Err(damaged(range.start, "the file is shorter than when it was opened")),
        }
    }
}

fn told(error: std::io::Error) -> Error {
    Error::Read(error.to_string())
}
