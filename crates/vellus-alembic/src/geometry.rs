//! What curves and meshes have in common: points, numbers of points, and the samples of one time.

use crate::archive::{Archive, Object};
use crate::attribute::{Attribute, floor, rows};
use crate::error::{Error, wrong};
use crate::property::{Property, Series};

/// The schema of an object at a time in seconds.
pub(crate) struct Geometry<'a> {
    pub archive: &'a Archive,
    schema: &'a Property,
    time: f64,
}

impl<'a> Geometry<'a> {
    /// The properties of the schema `name` of an object.
    pub fn new(archive: &'a Archive, object: &'a Object, name: &str, time: f64) -> Result<Self, Error> {
        let schema = object.property(name).ok_or_else(|| wrong(name, "is missing"))?;
        Ok(Geometry { archive, schema, time })
    }

    /// The samples of a property. `None` if it is missing or has no samples.
    pub fn series(&self, name: &str) -> Option<&'a Series> {
        self.schema.child(name).and_then(Property::series).filter(|series| series.samples > 0)
    }

    /// The time of the last sample that is not later, and the number of samples.
    pub fn sampled(&self, name: &str) -> Option<(f64, u32)> {
        let series = self.series(name)?;
        let times = self.archive.times(series);
        Some((times.time(times.between(self.time, series.samples).floor), series.samples))
    }

    /// Integers of the last sample that is not later.
    pub fn integers(&self, name: &str) -> Result<Option<Vec<i64>>, Error> {
        self.series(name).map(|series| Ok(floor(self.archive, series, self.time)?.to_i64())).transpose()
    }

    /// Numbers of the last sample that is not later, or if `blend`, between samples.
    pub fn numbers(&self, name: &str, blend: bool) -> Result<Option<Vec<f32>>, Error> {
        Ok(self.rows::<1>(name, blend)?.map(Vec::into_flattened))
    }

    fn rows<const N: usize>(&self, name: &str, blend: bool) -> Result<Option<Vec<[f32; N]>>, Error> {
        let read = |series| match blend {
            true => rows(self.archive, series, self.time),
            false => Ok(floor(self.archive, series, self.time)?.to_rows()),
        };
        self.series(name).map(read).transpose()
    }

    /// The text of a property.
    pub fn text(&self, name: &str) -> Result<Option<String>, Error> {
        let first = |series| Ok(floor(self.archive, series, self.time)?.to_text().into_iter().next());
        Ok(self.series(name).map(first).transpose()?.flatten())
    }

    /// Vectors with three coordinates.
    pub fn vectors(&self, name: &str, blend: bool) -> Result<Option<Vec<[f32; 3]>>, Error> {
        if let Some(series) = self.series(name) {
            let sample = self.archive.times(series).between(self.time, series.samples).floor;
            let numbers = self.archive.length(series, sample)?;
            if numbers % 3 != 0 {
                return Err(wrong(name, format!("has {numbers} numbers: they must be threes")));
            }
        }
        self.rows(name, blend)
    }

    /// Whether a property has the same values in both samples around the time.
    pub fn is_steady(&self, names: &[&str]) -> Result<bool, Error> {
        for series in names.iter().filter_map(|name| self.series(name)) {
            let between = self.archive.times(series).between(self.time, series.samples);
            let sample = |index| Ok::<_, Error>(self.archive.sample(series, index)?.bytes);
            if series.stored(between.floor) != series.stored(between.ceil)
                && sample(between.floor)? != sample(between.ceil)?
            {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// The numbers of points of curves or faces, whose sum must be `total`.
    pub fn counts(&self, name: &str, total: usize, of: &str) -> Result<Vec<u32>, Error> {
        let counts = self.integers(name)?.unwrap_or_default();
        let mut sum = 0usize;
        let mut checked = Vec::with_capacity(counts.len());
        for (i, count) in counts.into_iter().enumerate() {
            let count = u32::try_from(count).map_err(|_| wrong(name, format!("[{i}] is {count}")))?;
            sum = sum.saturating_add(count as usize);
            checked.push(count);
        }
        match sum == total {
            true => Ok(checked),
            false => Err(wrong(name, format!("adds up to {sum}, but there are {total} {of}"))),
        }
    }

    /// An attribute that the schema defines. `None` if it is missing or empty.
    pub fn attribute(&self, name: &str) -> Result<Option<Attribute>, Error> {
        let Some(property) = self.schema.child(name) else { return Ok(None) };
        let values = property.child(".vals").and_then(Property::series).or(property.series());
        if values.is_none_or(|series| series.samples == 0) {
            return Ok(None);
        }
        Ok(Some(Attribute::read(self.archive, property, self.time)?).filter(|attribute| attribute.rows() > 0))
    }
}
