//! Parameters of the fibre that change from query to query.

use crate::arrays::{Real, Rows};
use crate::error::value;
use crate::query::Bad;
use crate::render::values;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use vellus::{CoatColors, Fiber, Parameter};

/// The argument `parameters`: arrays by name.
pub struct Parameters<'py>(Vec<(Parameter, Real<'py>)>);

impl<'py> Parameters<'py> {
    /// Reads the argument.
    ///
    /// # Errors
    /// `ValueError` for an unknown name and for two colours, `TypeError` for what is no array.
    pub fn new(given: Option<&Bound<'py, PyAny>>) -> PyResult<Self> {
        let wrong = |what: &Bound<'py, PyAny>| {
            let kind = what.get_type();
            PyTypeError::new_err(format!("parameters must be a dict of arrays by name, not of {kind}"))
        };
        let given = given.map(|given| given.cast::<PyDict>().map_err(|_| wrong(given))).transpose()?;
        let mut all: Vec<(Parameter, Real<'py>)> = Vec::new();
        for (name, array) in given.into_iter().flatten() {
            let parameter = values::parameter(&name.extract::<String>().map_err(|_| wrong(&name))?)?;
            all.push((parameter, Real::new(&array, parameter.name())?));
        }
        // A reflectance depends on all others, so it is set last.
        all.sort_by_key(|(parameter, _)| *parameter);
        let mut colors = all.iter().map(|(parameter, _)| parameter).filter(|parameter| parameter.is_color());
        if let (Some(first), Some(second)) = (colors.next(), colors.next()) {
            let what = "only one parameter may give the colour";
            return Err(PyValueError::new_err(format!("parameters has {first} and {second}: {what}")));
        }
        Ok(Parameters(all))
    }

    pub fn arrays(&self) -> impl Iterator<Item = &Real<'py>> {
        self.0.iter().map(|(_, real)| real)
    }

    /// The arrays as rows. A number of a colour is grey.
    pub fn rows(&self, base: &Fiber) -> PyResult<Varying<'_>> {
        let rows = self.0.iter().map(|(parameter, real)| {
            let axis = match parameter.channels() {
                1 => None,
                2 => Some((2, "eumelanin, pheomelanin")),
                _ if real.shape().is_empty() => None,
                _ => Some((3, "r, g, b")),
            };
            Ok((*parameter, real.rows(parameter.name(), axis)?))
        });
        let rows = rows.collect::<PyResult<Vec<_>>>()?;
        // The table of colours takes long, and depends on all parameters but the absorption.
        let coat = match rows[..] {
            [(Parameter::Reflectance, _)] => Some(CoatColors::new(base).map_err(value)?),
            _ => None,
        };
        Ok(Varying { rows, base: *base, coat })
    }
}

/// Parameters of each query, and the fibre that has the others.
pub struct Varying<'a> {
    pub rows: Vec<(Parameter, Rows<'a>)>,
    base: Fiber,
    /// For a reflectance, if nothing else varies.
    coat: Option<CoatColors>,
}

/// The numbers of a chunk: the columns of each parameter.
pub struct Columns<'v> {
    varying: &'v Varying<'v>,
    columns: Vec<Vec<f32>>,
    shape: &'v [usize],
    start: usize,
    count: usize,
}

impl Varying<'_> {
    /// The numbers of `count` queries from `start` on.
    pub fn gather<'v>(&'v self, shape: &'v [usize], start: usize, count: usize) -> Columns<'v> {
        let columns = self.rows.iter().map(|(_, rows)| {
            let mut columns = vec![0.0f32; rows.width * count];
            rows.gather(shape, start, count, &mut columns);
            columns
        });
        Columns { varying: self, columns: columns.collect(), shape, start, count }
    }
}

impl Columns<'_> {
    /// The queries with a number that is not finite.
    pub fn absent(&self) -> impl Iterator<Item = usize> {
        (0..self.count).filter(|&i| !self.is_finite(i))
    }

    fn is_finite(&self, i: usize) -> bool {
        self.columns.iter().all(|columns| columns.iter().skip(i).step_by(self.count).all(|x| x.is_finite()))
    }

    /// Where the fibre of the query `first` ends, up to `count`.
    pub fn end(&self, first: usize) -> usize {
        let column =
            |column: &[f32]| column[first..].iter().take_while(|x| x.to_bits() == column[first].to_bits()).count();
        let same = self.columns.iter().flat_map(|columns| columns.chunks_exact(self.count)).map(column).min();
        first + same.unwrap_or(self.count - first)
    }

    /// The fibre of a query. Without a number, it is the base.
    ///
    /// # Errors
    /// [`Bad`] names a value out of range.
    pub fn fiber(&self, i: usize) -> Result<Fiber, Bad> {
        let mut fiber = self.varying.base;
        if !self.is_finite(i) {
            return Ok(fiber);
        }
        for ((parameter, rows), columns) in self.varying.rows.iter().zip(&self.columns) {
            let x = |c: usize| columns[c.min(rows.width - 1) * self.count + i];
            let given = [x(0), x(1), x(2)].map(|x| parameter.unit().to_stored(x));
            let bad = |error: vellus::Error| {
                let position = self.start + i;
                Bad { position, message: format!("{}: {error}", rows.index(self.shape, position)) }
            };
            match &self.varying.coat {
                Some(coat) => {
                    parameter.check(given).map_err(bad)?;
                    fiber = fiber.with_pigment(given.map(|c| coat.absorption(c)));
                }
                None => parameter.set(&mut fiber, given).map_err(bad)?,
            }
        }
        Ok(fiber)
    }
}
