//! Attributes of geometry (GeomParam): values in a scope, with or without indices.

use crate::archive::{Archive, Object};
use crate::error::{Error, wrong};
use crate::property::{Kind, Pod, Property, Series};
use crate::sample::Sample;

/// The most numbers in one row of an attribute.
const MAX_LANES: usize = 4096;

/// What has a value of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// The object.
    Constant,
    /// Each curve or face.
    Uniform,
    /// Each place between segments of a curve; each vertex of a mesh.
    Varying,
    /// Each control point or vertex.
    Vertex,
    /// Each corner of a face.
    FaceVarying,
    /// The file does not say it.
    Unknown,
}

/// The values of an attribute, one row behind another.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Numbers of half and single precision.
    Single(Vec<f32>),
    /// Numbers of double precision.
    Double(Vec<f64>),
    /// Integers and truth values.
    Whole(Vec<i64>),
    /// Texts.
    Text(Vec<String>),
}

/// An attribute at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    /// Its name.
    pub name: String,
    /// What has a value of its own. Programs are not strict: the number of rows is a better guide.
    pub scope: Scope,
    /// How many values a row has: 3 for a colour.
    pub lanes: usize,
    /// The type of the values in the file.
    pub pod: Pod,
    /// What the values are, as `point`, `vector`, `normal` or `rgb`; empty if the file does not say it.
    pub interpretation: String,
    /// The values.
    pub values: Values,
    /// The index of the row in `values` for each row of the attribute, if rows are shared.
    pub indices: Option<Vec<u32>>,
}

impl Values {
    fn new(sample: &Sample) -> Self {
        match sample.pod {
            Pod::F16 | Pod::F32 => Values::Single(sample.to_f32()),
            Pod::F64 => Values::Double(sample.to_f64()),
            Pod::Text | Pod::WideText => Values::Text(sample.to_text()),
            _ => Values::Whole(sample.to_i64()),
        }
    }

    /// The number of values.
    pub fn len(&self) -> usize {
        match self {
            Values::Single(values) => values.len(),
            Values::Double(values) => values.len(),
            Values::Whole(values) => values.len(),
            Values::Text(values) => values.len(),
        }
    }

    /// Whether there are no values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Attribute {
    /// Reads an attribute at a time in seconds. Numbers that are not integers are interpolated between samples, unless
    /// the attribute has indices or its length changes: then it is that of the last sample.
    ///
    /// # Errors
    /// [`Error::Damaged`], or [`Error::Property`] if it has no values at all.
    pub fn read(archive: &Archive, property: &Property, time: f64) -> Result<Self, Error> {
        let missing = || wrong(&property.name, "has no values");
        let (values, indices) = match &property.kind {
            Kind::Compound(_) => {
                let part = |name: &str| property.child(name).and_then(Property::series);
                (part(".vals").ok_or_else(missing)?, part(".indices"))
            }
            Kind::Scalar(series) | Kind::Array(series) => (series, None),
        };
        if values.samples == 0 {
            return Err(missing());
        }
        let is_indexed = indices.is_some_and(|indices| indices.samples > 0);
        let indices = match indices.filter(|_| is_indexed) {
            Some(series) => {
                let indices = floor(archive, series, time)?.to_i64();
                Some(indices.into_iter().map(|index| u32::try_from(index).unwrap_or(u32::MAX)).collect())
            }
            None => None,
        };
        let read = match values.pod {
            Pod::F16 | Pod::F32 if !is_indexed => Values::Single(rows::<1>(archive, values, time)?.into_flattened()),
            _ => Values::new(&floor(archive, values, time)?),
        };
        let metadata = match &property.kind {
            Kind::Compound(_) => [Some(&property.metadata), property.child(".vals").map(|vals| &vals.metadata)],
            _ => [Some(&property.metadata), None],
        };
        let get = |name: &str| metadata.into_iter().flatten().find_map(|metadata| metadata.get(name));
        let length = get("arrayExtent").and_then(|text| text.trim().parse().ok()).unwrap_or(1);
        let lanes = usize::from(values.extent.max(1)).saturating_mul(length).clamp(1, MAX_LANES);
        Ok(Attribute {
            name: property.name.clone(),
            scope: scope(get("geoScope")),
            lanes,
            pod: values.pod,
            interpretation: get("interpretation").unwrap_or_default().to_owned(),
            values: read,
            indices,
        })
    }

    /// The number of rows.
    pub fn rows(&self) -> usize {
        self.indices.as_ref().map_or(self.values.len() / self.lanes, Vec::len)
    }

    /// The place of a value.
    fn place(&self, row: usize, lane: usize) -> Option<usize> {
        let row = match &self.indices {
            Some(indices) => *indices.get(row)? as usize,
            None => row,
        };
        (lane < self.lanes).then(|| row.checked_mul(self.lanes)?.checked_add(lane)).flatten()
    }

    /// A number. `None` beyond the end, for an index out of range, and for text.
    pub fn number(&self, row: usize, lane: usize) -> Option<f64> {
        let place = self.place(row, lane)?;
        match &self.values {
            Values::Single(values) => values.get(place).map(|x| f64::from(*x)),
            Values::Double(values) => values.get(place).copied(),
            Values::Whole(values) => values.get(place).map(|x| *x as f64),
            Values::Text(_) => None,
        }
    }

    /// A text. `None` beyond the end, for an index out of range, and for numbers.
    pub fn text(&self, row: usize) -> Option<&str> {
        match &self.values {
            Values::Text(values) => values.get(self.place(row, 0)?).map(String::as_str),
            _ => None,
        }
    }
}

fn scope(name: Option<&str>) -> Scope {
    match name {
        Some("con") => Scope::Constant,
        Some("uni") => Scope::Uniform,
        Some("var") => Scope::Varying,
        Some("vtx") => Scope::Vertex,
        Some("fvr") => Scope::FaceVarying,
        _ => Scope::Unknown,
    }
}

/// The attributes of an object that its schema does not define (`.arbGeomParams`). [`Attribute::read`] reads them.
pub fn attributes(object: &Object) -> &[Property] {
    parts(object, ".arbGeomParams")
}

/// The properties of an object that programs and users add (`.userProperties`). [`Attribute::read`] reads them.
pub fn user_properties(object: &Object) -> &[Property] {
    parts(object, ".userProperties")
}

fn parts<'a>(object: &'a Object, name: &str) -> &'a [Property] {
    [".geom", ".xform"].iter().find_map(|part| object.property(part)?.child(name)).map_or(&[], Property::children)
}

/// Whether an object is visible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Visibility {
    /// As its parent.
    Inherited,
    /// It and its children are hidden, unless they say that they are visible.
    Hidden,
    /// It is visible.
    Visible,
}

/// Whether an object is visible at a time in seconds.
///
/// # Errors
/// [`Error::Damaged`].
pub fn visibility(archive: &Archive, object: &Object, time: f64) -> Result<Visibility, Error> {
    let series = object.property("visible").and_then(Property::series).filter(|series| series.samples > 0);
    let Some(series) = series else { return Ok(Visibility::Inherited) };
    Ok(match floor(archive, series, time)?.to_i64().first() {
        Some(0) => Visibility::Hidden,
        Some(1) => Visibility::Visible,
        _ => Visibility::Inherited,
    })
}

/// The path of the object that an instance is a copy of. `None` if the object is not an instance.
///
/// # Errors
/// [`Error::Damaged`].
pub fn instance_source(archive: &Archive, object: &Object) -> Result<Option<String>, Error> {
    let source = object.property(".instanceSource").and_then(Property::series).filter(|series| series.samples > 0);
    let is_instance = object.metadata.get("isInstance") == Some("1");
    let Some(series) = source.filter(|_| is_instance) else { return Ok(None) };
    Ok(archive.sample(series, 0)?.to_text().into_iter().next())
}

/// The last sample that is not later than a time.
pub(crate) fn floor<'a>(archive: &'a Archive, series: &Series, time: f64) -> Result<Sample<'a>, Error> {
    archive.sample(series, archive.times(series).between(time, series.samples).floor)
}

/// Rows of numbers at a time, interpolated between samples of the same length.
pub(crate) fn rows<const N: usize>(archive: &Archive, series: &Series, time: f64) -> Result<Vec<[f32; N]>, Error> {
    let between = archive.times(series).between(time, series.samples);
    let mut rows = archive.sample(series, between.floor)?.to_rows::<N>();
    if series.stored(between.floor) != series.stored(between.ceil) {
        let next = archive.sample(series, between.ceil)?.to_rows::<N>();
        if next.len() == rows.len() {
            let share = between.share as f32;
            let mix = |row: &mut [f32; N], next: [f32; N]| {
                *row = std::array::from_fn(|i| row[i] + share * (next[i] - row[i]))
            };
            rows.iter_mut().zip(next).for_each(|(row, next)| mix(row, next));
        }
    }
    Ok(rows)
}
