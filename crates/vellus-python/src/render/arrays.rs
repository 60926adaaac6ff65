//! Arrays of points, triangles and matrices.

use crate::arrays::{Real, text};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use vellus::glam::{Mat4, Vec3};

/// An argument as single-precision numbers, with its shape.
pub struct Floats {
    name: String,
    pub shape: Vec<usize>,
    pub values: Vec<f32>,
}

impl Floats {
    /// Reads the argument `name`.
    ///
    /// # Errors
    /// `TypeError` if it is not an array of real numbers, `ValueError` if a number is not finite.
    pub fn new(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Self> {
        let real = Real::new(value, name)?;
        let values = real.floats();
        if let Some(i) = values.iter().position(|x| !x.is_finite()) {
            return Err(PyValueError::new_err(format!("{name} has {} at position {i}: it must be finite", values[i])));
        }
        Ok(Floats { name: name.to_owned(), shape: real.shape().to_vec(), values })
    }

    /// The error for a shape that is not `expected`.
    pub fn wrong_shape(&self, expected: &str) -> PyErr {
        let Floats { name, shape, .. } = self;
        PyValueError::new_err(format!("{name} has the shape {}: it must be {expected}", text(shape)))
    }

    /// The same numbers with one axis instead of the two leading ones, if these are `grid`.
    pub fn merged(mut self, grid: Option<[usize; 2]>) -> Self {
        if let Some(grid) = grid.filter(|grid| self.shape.starts_with(grid)) {
            self.shape.splice(..2, [grid[0] * grid[1]]);
        }
        self
    }

    /// Rows of N numbers: the shape (rows, N).
    pub fn rows<const N: usize>(&self, rows: &str) -> PyResult<Vec<[f32; N]>> {
        match self.shape[..] {
            [_, n] if n == N => Ok(self.values.as_chunks::<N>().0.to_vec()),
            _ => Err(self.wrong_shape(&format!("({rows}, {N})"))),
        }
    }

    /// As [`Floats::rows`], with as many rows as something else has.
    pub fn rows_of<const N: usize>(&self, count: usize) -> PyResult<Vec<[f32; N]>> {
        let rows = self.rows::<N>(&count.to_string())?;
        if rows.len() == count { Ok(rows) } else { Err(self.wrong_shape(&format!("({count}, {N})"))) }
    }

    /// Points: the shape (points, 3).
    pub fn points(&self, points: &str) -> PyResult<Vec<Vec3>> {
        Ok(self.rows::<3>(points)?.into_iter().map(Vec3::from).collect())
    }

    /// One number for each of `count`, or one for all.
    pub fn each(&self, count: usize) -> PyResult<Vec<f32>> {
        match self.shape[..] {
            [] => Ok(vec![self.values[0]; count]),
            [n] if n == count => Ok(self.values.clone()),
            _ => Err(self.wrong_shape(&format!("() or ({count},)"))),
        }
    }

    /// An affine transform for column vectors: the shape (4, 4).
    pub fn matrix(&self) -> PyResult<Mat4> {
        let rows = self.rows_of::<4>(4)?;
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| rows[k]);
        if d != [0.0, 0.0, 0.0, 1.0] {
            let what = format!("{} has the last row {d:?}: it must be 0, 0, 0, 1", self.name);
            return Err(PyValueError::new_err(what));
        }
        Ok(Mat4::from_cols_array_2d(&[a, b, c, d]).transpose())
    }

    /// A vector: the shape (3,).
    pub fn vector(&self) -> PyResult<Vec3> {
        match self.shape[..] {
            [3] => Ok(Vec3::from_slice(&self.values)),
            _ => Err(self.wrong_shape("(3,)")),
        }
    }

    /// RGB, or one number for all channels.
    pub fn color(&self) -> PyResult<[f32; 3]> {
        match (&self.shape[..], &self.values[..]) {
            ([], [x]) => Ok([*x; 3]),
            ([3], [r, g, b]) => Ok([*r, *g, *b]),
            _ => Err(self.wrong_shape("() or (3,)")),
        }
    }
}

/// An argument as whole numbers from 0 on, with its shape.
pub fn indices(value: &Bound<'_, PyAny>, name: &str) -> PyResult<(Vec<usize>, Vec<u32>)> {
    let real = Real::new(value, name)?;
    let whole = |x: f64| (x >= 0.0 && x <= f64::from(u32::MAX) && x.fract() == 0.0).then_some(x as u32);
    let values = real.doubles();
    let wrong = |i: usize| format!("{name} has {} at position {i}: it must be a whole number from 0 on", values[i]);
    let numbers = values.iter().enumerate().map(|(i, x)| whole(*x).ok_or_else(|| PyValueError::new_err(wrong(i))));
    Ok((real.shape().to_vec(), numbers.collect::<PyResult<_>>()?))
}

/// A name out of a list.
pub fn one_of<T: Copy>(name: &str, given: &str, known: &[(&str, T)]) -> PyResult<T> {
    known.iter().find(|(known, _)| *known == given).map(|(_, value)| *value).ok_or_else(|| {
        let known: Vec<&str> = known.iter().map(|(known, _)| *known).collect();
        PyValueError::new_err(format!("{name} = {given:?} is unknown: it must be one of {}", known.join(", ")))
    })
}

/// An option with this name, out of keyword arguments.
pub fn required<'py>(value: Option<Bound<'py, PyAny>>, name: &str, of: &str) -> PyResult<Bound<'py, PyAny>> {
    value.ok_or_else(|| PyTypeError::new_err(format!("{of} needs {name}")))
}
