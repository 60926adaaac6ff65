//! Ogawa, the container of an archive: groups and data, found by their positions in the file.
//!
//! The file begins with the word `Ogawa`, a byte that is 0xff if the file was closed, the version (two bytes, the
//! higher one first), and the position of the root. A group is the number of its children and their positions; data is
//! its size and its bytes. All numbers are 64-bit and little-endian. The top bit of a position says that it is data.
//! The position 0 is an empty group, or empty data with the top bit.

use crate::error::{Error, damaged};
use crate::source::Source;
use std::borrow::Cow;
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
pub(crate) fn root(bytes: &Source) -> Result<Group, Error> {
    let header = bytes.read(0..HEADER.min(bytes.len()))?;
    if header.starts_with(b"\x89HDF") {
        return Err(Error::Hdf5);
    }
    if !header.starts_with(b"Ogawa") || header.len() < HEADER {
        return Err(Error::NotAlembic);
    }
    if header[5] != 0xff {
        return Err(Error::NotClosed);
    }
    let version = i64::from(u16::from_be_bytes([header[6], header[7]]));
    if version != 1 {
        return Err(Error::Version { what: "container", found: version, allowed: "1" });
    }
    group(bytes, bytes.u64(8)?)
}

/// A child of a group.
pub(crate) fn child(bytes: &Source, parent: Group, index: usize) -> Result<Child, Error> {
    if index >= parent.count {
        let what = format!("child {index} is missing: the group has {}", parent.count);
        return Err(damaged(parent.first, what));
    }
    let position = bytes.u64(parent.first + 8 * index)?;
    if position & DATA == 0 {
        return Ok(Child::Group(group(bytes, position)?));
    }
    let position = position & !DATA;
    if position == 0 {
        return Ok(Child::Data(0..0));
    }
    let at = inside(bytes, position)?;
    let (size, first) = (bytes.u64(at)?, at + 8);
    match usize::try_from(size).ok().and_then(|size| first.checked_add(size)) {
        Some(end) if end <= bytes.len() => Ok(Child::Data(first..end)),
        _ => Err(damaged(at, format!("data of {size} bytes does not fit in the file of {} bytes", bytes.len()))),
    }
}

/// A child that must be data.
pub(crate) fn data(bytes: &Source, parent: Group, index: usize) -> Result<Cow<'_, [u8]>, Error> {
    match child(bytes, parent, index)? {
        Child::Data(range) => bytes.read(range),
        Child::Group(_) => Err(damaged(parent.first, format!("child {index} is a group, but must be data"))),
    }
}

/// A child that must be a group.
pub(crate) fn subgroup(bytes: &Source, parent: Group, index: usize) -> Result<Group, Error> {
    match child(bytes, parent, index)? {
        Child::Group(group) => Ok(group),
        Child::Data(_) => Err(damaged(parent.first, format!("child {index} is data, but must be a group"))),
    }
}

fn group(bytes: &Source, position: u64) -> Result<Group, Error> {
    if position == 0 {
        return Ok(Group::default());
    }
    let at = inside(bytes, position)?;
    let (count, first) = (bytes.u64(at)?, at + 8);
    match usize::try_from(count) {
        Ok(count) if count <= (bytes.len() - first) / 8 => Ok(Group { first, count }),
        _ => Err(damaged(at, format!("a group with {count} children does not fit in the file"))),
    }
}

fn inside(bytes: &Source, position: u64) -> Result<usize, Error> {
    match usize::try_from(position) {
        Ok(at) if at >= HEADER && at < bytes.len() => Ok(at),
        _ => Err(damaged(0, format!("the position {position} is outside of the file of {} bytes", bytes.len()))),
    }
}
