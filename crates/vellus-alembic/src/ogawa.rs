//! Ogawa, the container of an archive: groups and data, found by their positions in the file.
//!
//! The file begins with the word `Ogawa`, a byte that is 0xff if the file was closed, the version (two bytes, the
//! higher one first), and the position of the root. A group is the number of its children and their positions; data is
//! its size and its bytes. All numbers are 64-bit and little-endian. The top bit of a position says that it is data.
//! The position 0 is an empty group, or empty data with the top bit.

use crate::error::{Error, damaged};
use std::ops::Range;

/// The top bit of a position of data.
const DATA: u64 = 1 << 63;

/// The size of the header.
const HEADER: usize = 16;

/// A group: the position of its children's positions, and their number. All of them are inside the file.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Group {
    first: usize,
    count: usize,
}

/// A child of a group.
#[derive(Clone, Debug)]
pub(crate) enum Child {
    /// A group.
    Group(Group),
    /// The place of data in the file.
    Data(Range<usize>),
}

impl Group {
    /// The number of children.
    pub fn len(&self) -> usize {
        self.count
    }

    /// The position of this group, for messages.
    pub fn at(&self) -> usize {
        self.first
    }
}

/// The root of a file.
pub(crate) fn root(bytes: &[u8]) -> Result<Group, Error> {
    if bytes.starts_with(b"\x89HDF") {
        return Err(Error::Hdf5);
    }
    if !bytes.starts_with(b"Ogawa") || bytes.len() < HEADER {
        return Err(Error::NotAlembic);
    }
    if bytes[5] != 0xff {
        return Err(Error::NotClosed);
    }
    let version = i64::from(u16::from_be_bytes([bytes[6], bytes[7]]));
    if version != 1 {
        return Err(Error::Version { what: "container", found: version, allowed: "1" });
    }
    group(bytes, u64_at(bytes, 8)?)
}

/// A child of a group.
pub(crate) fn child(bytes: &[u8], parent: Group, index: usize) -> Result<Child, Error> {
    if index >= parent.count {
        let what = format!("child {index} is missing: the group has {}", parent.count);
        return Err(damaged(parent.first, what));
    }
    let position = u64_at(bytes, parent.first + 8 * index)?;
    if position & DATA == 0 {
        return Ok(Child::Group(group(bytes, position)?));
    }
    let position = position & !DATA;
    if position == 0 {
        return Ok(Child::Data(0..0));
    }
    let at = inside(bytes, position)?;
    let (size, first) = (u64_at(bytes, at)?, at + 8);
    match usize::try_from(size).ok().and_then(|size| first.checked_add(size)) {
        Some(end) if end <= bytes.len() => Ok(Child::Data(first..end)),
        _ => Err(damaged(at, format!("data of {size} bytes does not fit in the file of {} bytes", bytes.len()))),
    }
}

/// A child that must be data.
pub(crate) fn data(bytes: &[u8], parent: Group, index: usize) -> Result<&[u8], Error> {
    match child(bytes, parent, index)? {
        Child::Data(range) => Ok(&bytes[range]),
        Child::Group(_) => Err(damaged(parent.first, format!("child {index} is a group, but must be data"))),
    }
}

/// A child that must be a group.
pub(crate) fn subgroup(bytes: &[u8], parent: Group, index: usize) -> Result<Group, Error> {
    match child(bytes, parent, index)? {
        Child::Group(group) => Ok(group),
        Child::Data(_) => Err(damaged(parent.first, format!("child {index} is data, but must be a group"))),
    }
}

fn group(bytes: &[u8], position: u64) -> Result<Group, Error> {
    if position == 0 {
        return Ok(Group::default());
    }
    let at = inside(bytes, position)?;
    let (count, first) = (u64_at(bytes, at)?, at + 8);
    match usize::try_from(count) {
        Ok(count) if count <= (bytes.len() - first) / 8 => Ok(Group { first, count }),
        _ => Err(damaged(at, format!("a group with {count} children does not fit in the file"))),
    }
}

fn inside(bytes: &[u8], position: u64) -> Result<usize, Error> {
    match usize::try_from(position) {
        Ok(at) if at >= HEADER && at < bytes.len() => Ok(at),
        _ => Err(damaged(0, format!("the position {position} is outside of the file of {} bytes", bytes.len()))),
    }
}

fn u64_at(bytes: &[u8], at: usize) -> Result<u64, Error> {
    let word = bytes.get(at..).and_then(|rest| rest.first_chunk::<8>());
    word.map(|word| u64::from_le_bytes(*word)).ok_or_else(|| damaged(at, "the file ends here"))
}
