//! Archives: the tree of objects with their properties.

use crate::cursor::Cursor;
use crate::error::{Error, damaged};
use crate::metadata::Metadata;
use crate::ogawa::{self, Child, Group};
use crate::property::{self, Kind, Property, Series};
use crate::sample::Sample;
use crate::source::Source;
use crate::time::{self, TimeSampling};
use std::borrow::Cow;
use std::ops::Range;

/// How many objects may be inside each other, and how many properties.
const MAX_DEPTH: usize = 128;

/// The file has two hashes behind the headers of objects.
const HASHES: usize = 32;

/// The file has a hash before the bytes of each sample.
const HASH: usize = 16;

/// An Alembic archive.
///
/// The tree is read at once: its size is bounded by that of the file. Samples are read on demand.
#[derive(Clone, Debug)]
pub struct Archive {
    bytes: Source,
    /// What describes the archive, as the program that wrote it.
    pub metadata: Metadata,
    /// When samples are. The first one is for properties without time.
    pub times: Vec<TimeSampling>,
    /// All objects; parents are before their children. The first one is the root.
    pub objects: Vec<Object>,
}

/// An object: a transform, curves, a mesh, a camera, or something else that its schema names.
#[derive(Clone, Debug)]
pub struct Object {
    /// Its name, without those of its parents. The root has none.
    pub name: String,
    /// What describes it.
    pub metadata: Metadata,
    /// The index of its parent. `None` for the root.
    pub parent: Option<usize>,
    /// The indices of its children.
    pub children: Vec<usize>,
    /// Its properties.
    pub properties: Vec<Property>,
}

impl Object {
    /// The schema, as `AbcGeom_Curve_v2`.
    pub fn schema(&self) -> Option<&str> {
        self.metadata.get("schema")
    }

    /// A property.
    pub fn property(&self, name: &str) -> Option<&Property> {
        property::find(&self.properties, name)
    }
}

impl Archive {
    /// Reads the tree of an archive in memory.
    ///
    /// # Errors
    /// [`Error::Hdf5`], [`Error::NotAlembic`], [`Error::NotClosed`], [`Error::Version`], [`Error::Damaged`].
    pub fn open(bytes: Vec<u8>) -> Result<Self, Error> {
        Self::new(Source::Memory(bytes))
    }

    /// Reads the tree of an archive in a file, which must not change while the archive is used.
    ///
    /// # Errors
    /// As [`Archive::open`], and [`Error::Read`].
    pub fn open_file(file: std::fs::File) -> Result<Self, Error> {
        Self::new(Source::file(file)?)
    }

    fn new(bytes: Source) -> Result<Self, Error> {
        let root = ogawa::root(&bytes)?;
        let number = |index: usize| -> Result<i64, Error> {
            let data = ogawa::data(&bytes, root, index)?;
            Ok(data.first_chunk::<4>().map_or(-1, |word| i32::from_le_bytes(*word).into()))
        };
        let (format, library) = (number(0)?, number(1)?);
        if format != 0 {
            return Err(Error::Version { what: "archive", found: format, allowed: "0" });
        }
        if library < 9999 {
            return Err(Error::Version {
                what: "library that wrote the archive",
                found: library,
                allowed: "9999 or more",
            });
        }
        let metadata = Metadata::new(&String::from_utf8_lossy(&ogawa::data(&bytes, root, 3)?));
        let times = time::read(&ogawa::data(&bytes, root, 4)?, root.at())?;
        let indexed = indexed_metadata(&ogawa::data(&bytes, root, 5)?, root.at())?;
        let mut tree = Tree { bytes: &bytes, indexed, samplings: times.len(), budget: bytes.len() };
        let objects = tree.objects(ogawa::subgroup(&bytes, root, 2)?)?;
        Ok(Archive { metadata, times, objects, bytes })
    }

    /// A sample of a property.
    ///
    /// # Errors
    /// [`Error::Damaged`] if the file has no such sample.
    pub fn sample(&self, series: &Series, sample: u32) -> Result<Sample<'_>, Error> {
        let range = self.place(series, sample)?;
        let bytes = if range.is_empty() { Cow::Borrowed(&[][..]) } else { self.bytes.read(range)? };
        Ok(Sample { pod: series.pod, bytes })
    }

    /// The number of numbers in a sample, which is not read. 0 for text.
    ///
    /// # Errors
    /// As [`Archive::sample`].
    pub fn length(&self, series: &Series, sample: u32) -> Result<usize, Error> {
        let range = self.place(series, sample)?;
        Ok(series.pod.size().map_or(0, |size| range.len() / size))
    }

    /// Where a sample is in the file.
    fn place(&self, series: &Series, sample: u32) -> Result<Range<usize>, Error> {
        let at = series.group.at();
        let missing = || damaged(at, format!("sample {sample} is missing: there are {}", series.samples));
        let stored = series.stored(sample).ok_or_else(missing)?;
        // Arrays have data and dimensions in turn.
        let stored = if series.is_array { 2 * stored } else { stored };
        match ogawa::child(&self.bytes, series.group, stored)? {
            Child::Data(range) if range.is_empty() => Ok(range),
            Child::Data(range) if range.len() < HASH => Err(damaged(at, format!("a sample has {} bytes", range.len()))),
            Child::Data(range) => Ok(range.start + HASH..range.end),
            Child::Group(_) => Err(damaged(at, format!("child {stored} is a group, but must be data"))),
        }
    }

    /// The times of the samples of a property.
    pub fn times(&self, series: &Series) -> &TimeSampling {
        // The headers are checked.
        &self.times[series.time_sampling as usize]
    }

    /// The times of the first and of the last sample of what changes, in seconds. `None` if nothing does.
    pub fn range(&self) -> Option<[f64; 2]> {
        let mut next: Vec<&Property> = self.objects.iter().flat_map(|object| &object.properties).collect();
        let mut range: Option<[f64; 2]> = None;
        while let Some(property) = next.pop() {
            next.extend(property.children());
            // The first sampling is for what has no time.
            let moving = property.series().filter(|series| !series.is_constant() && series.time_sampling > 0);
            if let Some(series) = moving {
                let [first, last] = [0, series.samples.saturating_sub(1)].map(|sample| self.times(series).time(sample));
                range = Some(range.map_or([first, last], |[from, to]| [from.min(first), to.max(last)]));
            }
        }
        range
    }

    /// The names of an object and of its parents, as `/fox/coat`. That of the root is `/`.
    pub fn path(&self, object: usize) -> String {
        let mut names = Vec::new();
        let mut next = Some(object);
        while let Some(found) = next.and_then(|index| self.objects.get(index)) {
            names.push(found.name.as_str());
            next = found.parent;
        }
        names.pop();
        names.iter().rev().fold(if names.is_empty() { "/" } else { "" }.to_owned(), |path, name| path + "/" + name)
    }

    /// The object with a path.
    pub fn find(&self, path: &str) -> Option<usize> {
        let mut names = path.split('/').filter(|name| !name.is_empty());
        names.try_fold(0, |object: usize, name| {
            self.objects[object].children.iter().copied().find(|child| self.objects[*child].name == name)
        })
    }

    /// Frames per second, if the program that wrote the archive says it.
    pub fn frames_per_second(&self) -> Option<f64> {
        let rate: f64 = self.metadata.get("FramesPerTimeUnit")?.trim().parse().ok()?;
        (rate.is_finite() && rate > 0.0).then_some(rate)
    }
}

/// Short metadata that headers refer to by its index. The first one is empty.
fn indexed_metadata(bytes: &[u8], at: usize) -> Result<Vec<Metadata>, Error> {
    let mut cursor = Cursor::new(bytes, "metadata", at);
    let mut all = vec![Metadata::default()];
    while !cursor.is_empty() && all.len() < 255 {
        let length = cursor.u8()?;
        all.push(Metadata::new(&cursor.text(length.into())?));
    }
    Ok(all)
}

/// Builds the tree of objects.
struct Tree<'a> {
    bytes: &'a Source,
    indexed: Vec<Metadata>,
    samplings: usize,
    /// What the file can hold of objects and properties, in bytes. Groups that have several parents, or themselves
    /// among their children, use it up.
    budget: usize,
}

impl Tree<'_> {
    /// Takes the size of an object or a property: its position and its name.
    fn spend(&mut self, name: &str, at: usize) -> Result<(), Error> {
        let rest = self.budget.checked_sub(8 + name.len());
        self.budget = rest.ok_or_else(|| damaged(at, "there are more objects and properties than fit in the file"))?;
        Ok(())
    }

    fn objects(&mut self, root: Group) -> Result<Vec<Object>, Error> {
        let mut objects = vec![Object {
            name: String::new(),
            metadata: Metadata::default(),
            parent: None,
            children: Vec::new(),
            properties: Vec::new(),
        }];
        let mut open = vec![(0, root, 0)];
        while let Some((index, group, depth)) = open.pop() {
            if depth > MAX_DEPTH {
                return Err(damaged(group.at(), format!("more than {MAX_DEPTH} objects are inside each other")));
            }
            if group.len() == 0 {
                continue;
            }
            if let Child::Group(properties) = ogawa::child(self.bytes, group, 0)? {
                objects[index].properties = self.properties(properties, 0)?;
            }
            let Child::Data(range) = ogawa::child(self.bytes, group, group.len() - 1)? else { continue };
            let headers = self.bytes.read(range)?;
            let headers = &headers[..headers.len().saturating_sub(HASHES)];
            let mut cursor = Cursor::new(headers, "headers of objects", group.at());
            while !cursor.is_empty() {
                let length = cursor.u32()?;
                let name = cursor.text(length)?;
                let metadata = match cursor.u8()? {
                    255 => {
                        let length = cursor.u32()?;
                        Metadata::new(&cursor.text(length)?)
                    }
                    index => property::metadata(&cursor, &self.indexed, index.into())?,
                };
                self.spend(&name, group.at())?;
                let child = objects.len();
                objects[index].children.push(child);
                let place = objects[index].children.len();
                open.push((child, ogawa::subgroup(self.bytes, group, place)?, depth + 1));
                objects.push(Object {
                    name,
                    metadata,
                    parent: Some(index),
                    children: Vec::new(),
                    properties: Vec::new(),
                });
            }
        }
        Ok(objects)
    }

    fn properties(&mut self, group: Group, depth: usize) -> Result<Vec<Property>, Error> {
        if depth > MAX_DEPTH {
            return Err(damaged(group.at(), format!("more than {MAX_DEPTH} properties are inside each other")));
        }
        let mut properties = Vec::new();
        if group.len() == 0 {
            return Ok(properties);
        }
        let Child::Data(range) = ogawa::child(self.bytes, group, group.len() - 1)? else { return Ok(properties) };
        let headers = self.bytes.read(range)?;
        let mut cursor = Cursor::new(&headers, "headers of properties", group.at());
        while !cursor.is_empty() {
            let header = property::header(&mut cursor, &self.indexed, self.samplings)?;
            self.spend(&header.name, group.at())?;
            let own = ogawa::subgroup(self.bytes, group, properties.len())?;
            let kind = match header.series {
                None => Kind::Compound(self.properties(own, depth + 1)?),
                Some(series) if series.is_array => Kind::Array(Series { group: own, ..series }),
                Some(series) => Kind::Scalar(Series { group: own, ..series }),
            };
            properties.push(Property { name: header.name, metadata: header.metadata, kind });
        }
        Ok(properties)
    }
}
