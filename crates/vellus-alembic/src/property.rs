//! Properties and their headers.

use crate::cursor::Cursor;
use crate::error::Error;
use crate::metadata::Metadata;
use crate::ogawa::Group;

/// The type of one number, or text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pod {
    /// One byte, 0 or 1.
    Bool,
    /// 8 bits without a sign.
    U8,
    /// 8 bits.
    I8,
    /// 16 bits without a sign.
    U16,
    /// 16 bits.
    I16,
    /// 32 bits without a sign.
    U32,
    /// 32 bits.
    I32,
    /// 64 bits without a sign.
    U64,
    /// 64 bits.
    I64,
    /// Half precision.
    F16,
    /// Single precision.
    F32,
    /// Double precision.
    F64,
    /// Text.
    Text,
    /// Text of 32-bit characters.
    WideText,
}

impl Pod {
    /// All types, in the order of their numbers in the file.
    const ALL: [Pod; 14] = [
        Pod::Bool,
        Pod::U8,
        Pod::I8,
        Pod::U16,
        Pod::I16,
        Pod::U32,
        Pod::I32,
        Pod::U64,
        Pod::I64,
        Pod::F16,
        Pod::F32,
        Pod::F64,
        Pod::Text,
        Pod::WideText,
    ];

    /// Its number in the file.
    pub(crate) fn number(self) -> u32 {
        Pod::ALL.iter().position(|pod| *pod == self).unwrap_or_default() as u32
    }

    /// What the format calls it in metadata.
    pub(crate) fn name(self) -> &'static str {
        const NAMES: [&str; 14] = [
            "bool_t",
            "uint8_t",
            "int8_t",
            "uint16_t",
            "int16_t",
            "uint32_t",
            "int32_t",
            "uint64_t",
            "int64_t",
            "float16_t",
            "float32_t",
            "float64_t",
            "string",
            "wstring",
        ];
        NAMES[self.number() as usize]
    }

    /// The size of a number in bytes. `None` for text.
    pub fn size(self) -> Option<usize> {
        match self {
            Pod::Bool | Pod::U8 | Pod::I8 => Some(1),
            Pod::U16 | Pod::I16 | Pod::F16 => Some(2),
            Pod::U32 | Pod::I32 | Pod::F32 => Some(4),
            Pod::U64 | Pod::I64 | Pod::F64 => Some(8),
            Pod::Text | Pod::WideText => None,
        }
    }
}

/// A property of an object.
#[derive(Clone, Debug)]
pub struct Property {
    /// Its name.
    pub name: String,
    /// What describes it, as the scope of an attribute.
    pub metadata: Metadata,
    /// What it is.
    pub kind: Kind,
}

/// The kind of a property.
#[derive(Clone, Debug)]
pub enum Kind {
    /// Other properties.
    Compound(Vec<Property>),
    /// A fixed number of values in each sample: [`Series::extent`].
    Scalar(Series),
    /// A list of values in each sample.
    Array(Series),
}

/// The samples of a property. [`Archive::sample`](crate::Archive::sample) reads them.
#[derive(Clone, Debug)]
pub struct Series {
    /// The type of the numbers.
    pub pod: Pod,
    /// How many numbers a value has: 3 for a point.
    pub extent: u8,
    /// The number of samples.
    pub samples: u32,
    /// The first sample that differs from sample 0. 0 if all are equal.
    pub first_changed: u32,
    /// The last sample that differs from the one before it.
    pub last_changed: u32,
    /// The index of its times in the archive.
    pub time_sampling: u32,
    /// Whether samples are lists.
    pub(crate) is_array: bool,
    /// The samples in the file.
    pub(crate) group: Group,
}

impl Property {
    /// The properties inside of this one.
    pub fn children(&self) -> &[Property] {
        match &self.kind {
            Kind::Compound(children) => children,
            _ => &[],
        }
    }

    /// A property inside of this one.
    pub fn child(&self, name: &str) -> Option<&Property> {
        find(self.children(), name)
    }

    /// Its samples, if it is not a compound.
    pub fn series(&self) -> Option<&Series> {
        match &self.kind {
            Kind::Compound(_) => None,
            Kind::Scalar(series) | Kind::Array(series) => Some(series),
        }
    }
}

/// The property of a name.
pub(crate) fn find<'a>(properties: &'a [Property], name: &str) -> Option<&'a Property> {
    properties.iter().find(|property| property.name == name)
}

impl Series {
    /// Whether all samples are equal.
    pub fn is_constant(&self) -> bool {
        self.first_changed == 0
    }

    /// Where a sample is stored among the samples of the file, which leaves out equal ones at both ends. `None` if
    /// there is no such sample.
    pub(crate) fn stored(&self, sample: u32) -> Option<usize> {
        if sample >= self.samples {
            return None;
        }
        let (first, last) = (self.first_changed, self.last_changed);
        Some(match sample {
            _ if sample < first || (first == 0 && last == 0) => 0,
            _ => (sample.min(last.max(first)) - first) as usize + 1,
        })
    }
}

/// The header of a property. `series` is `None` for a compound; its group is not known yet.
pub(crate) struct Header {
    pub name: String,
    pub metadata: Metadata,
    pub series: Option<Series>,
}

/// Reads the header of one property. The bits of the first word: 0 and 1 the kind (0 compound, 1 scalar, 2 and 3
/// array); 2 and 3 the size of the numbers that follow; 4 to 7 the type; 8 whether there is a time sampling; 9 whether
/// there are the first and the last sample that change; 11 whether all samples are equal; 12 to 19 the extent; 20 to 27
/// the index of the metadata, 255 if it follows.
pub(crate) fn header(cursor: &mut Cursor, indexed: &[Metadata], samplings: usize) -> Result<Header, Error> {
    let info = cursor.u32()?;
    let bits = |first: u32, count: u32| (info >> first) & ((1 << count) - 1);
    let (kind, hint) = (bits(0, 2), bits(2, 2));
    let series = if kind == 0 {
        None
    } else {
        let pod = *Pod::ALL.get(bits(4, 4) as usize).ok_or_else(|| cursor.error("a property has no known type"))?;
        let samples = cursor.sized(hint)?;
        let (first_changed, last_changed) = match (bits(9, 1), bits(11, 1)) {
            (1, _) => (cursor.sized(hint)?, cursor.sized(hint)?),
            (_, 1) => (0, 0),
            // With one sample, nothing changes.
            _ if samples <= 1 => (0, 0),
            _ => (1, samples - 1),
        };
        let time_sampling = if bits(8, 1) == 1 { cursor.sized(hint)? } else { 0 };
        if time_sampling as usize >= samplings {
            return Err(cursor.error(format!("time sampling {time_sampling} is missing: there are {samplings}")));
        }
        let (extent, group) = (bits(12, 8) as u8, Group::default());
        let is_array = kind != 1;
        Some(Series { pod, extent, samples, first_changed, last_changed, time_sampling, is_array, group })
    };
    let length = cursor.sized(hint)?;
    if length == 0 {
        return Err(cursor.error("a property has no name"));
    }
    let name = cursor.text(length)?;
    let metadata = match bits(20, 8) {
        255 => {
            let length = cursor.sized(hint)?;
            Metadata::new(&cursor.text(length)?)
        }
        index => metadata(cursor, indexed, index)?,
    };
    Ok(Header { name, metadata, series })
}

/// Metadata by its index.
pub(crate) fn metadata(cursor: &Cursor, indexed: &[Metadata], index: u32) -> Result<Metadata, Error> {
    let found = indexed.get(index as usize).cloned();
    found.ok_or_else(|| cursor.error(format!("metadata {index} is missing: there are {}", indexed.len())))
}
