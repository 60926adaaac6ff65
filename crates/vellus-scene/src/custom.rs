//! Attributes of strands that rendering does not use.

use crate::error::{Error, invalid};
use crate::strands::Strands;

/// What has a value of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Per {
    /// The set of strands.
    Set,
    /// Each strand.
    Strand,
    /// Each of [`Strands::points`].
    Point,
}

/// The values of an attribute, one row behind another.
#[derive(Clone, Debug, PartialEq)]
pub enum CustomValues {
    /// Numbers of single precision.
    F32(Vec<f32>),
    /// Numbers of double precision.
    F64(Vec<f64>),
    /// Whole numbers.
    I32(Vec<i32>),
    /// Texts.
    Text(Vec<String>),
}

/// An attribute of strands that rendering does not use. Conversions keep it.
#[derive(Clone, Debug, PartialEq)]
pub struct Custom {
    /// The index of the strands in [`crate::Scene::strands`].
    pub strands: usize,
    /// Its name, without `primvars:`.
    pub name: String,
    /// What has a value of its own.
    pub per: Per,
    /// The number of values in a row: 3 for a vector.
    pub lanes: usize,
    /// The values.
    pub values: CustomValues,
}

impl Custom {
    /// The number of rows.
    pub fn rows(&self) -> usize {
        let values = match &self.values {
            CustomValues::F32(values) => values.len(),
            CustomValues::F64(values) => values.len(),
            CustomValues::I32(values) => values.len(),
            CustomValues::Text(values) => values.len(),
        };
        values / self.lanes.max(1)
    }

    /// The same attribute with these of its rows.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn with_rows(&self, rows: &[usize]) -> Self {
        fn pick<T: Clone>(values: &[T], lanes: usize, rows: &[usize]) -> Vec<T> {
            rows.iter().flat_map(|row| values[row * lanes..(row + 1) * lanes].iter().cloned()).collect()
        }
        let values = match &self.values {
            CustomValues::F32(values) => CustomValues::F32(pick(values, self.lanes, rows)),
            CustomValues::F64(values) => CustomValues::F64(pick(values, self.lanes, rows)),
            CustomValues::I32(values) => CustomValues::I32(pick(values, self.lanes, rows)),
            CustomValues::Text(values) => CustomValues::Text(pick(values, self.lanes, rows)),
        };
        Custom { values, name: self.name.clone(), ..*self }
    }

    /// Checks that it has a row for each of what it is for.
    ///
    /// # Errors
    /// [`Error::Invalid`] if it does not.
    pub fn validate(&self, strands: &[Strands]) -> Result<(), Error> {
        let Some(set) = strands.get(self.strands) else {
            return Err(invalid(&self.name, format!("it is for the strands {}, which do not exist", self.strands)));
        };
        let expected = match self.per {
            Per::Set => 1,
            Per::Strand => set.len(),
            Per::Point => set.points.len(),
        };
        if self.rows() == expected {
            return Ok(());
        }
        let what = format!("{} has {} rows for each {:?}: there must be {expected}", self.name, self.rows(), self.per);
        Err(invalid(&set.name, what))
    }
}
