//! Results of queries: columns of numbers that become rows of NumPy arrays.

use numpy::{PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;

/// Columns of the results that go into an array of Python.
pub struct Output<'py> {
    array: Array<'py>,
    columns: [usize; 2],
}

enum Array<'py> {
    Single(Bound<'py, PyArrayDyn<f32>>),
    Double(Bound<'py, PyArrayDyn<f64>>),
    Index(Bound<'py, PyArrayDyn<i8>>),
}

/// The same, while the interpreter's lock is released.
pub enum Slice<'a> {
    Single(&'a mut [f32]),
    Double(&'a mut [f64]),
    Index(&'a mut [i8]),
}

impl<'py> Output<'py> {
    /// A new array of the given shape for some columns: from the first one on, as many as `inner` has numbers.
    pub fn new(py: Python<'py>, shape: &[usize], inner: &[usize], first: usize, double: bool) -> Self {
        let shape = [shape, inner].concat();
        let columns = [first, inner.iter().product()];
        let array = if double {
            Array::Double(PyArrayDyn::zeros(py, shape, false))
        } else {
            Array::Single(PyArrayDyn::zeros(py, shape, false))
        };
        Output { array, columns }
    }

    /// A new array of small integers for one column.
    pub fn index(py: Python<'py>, shape: &[usize], column: usize) -> Self {
        Output { array: Array::Index(PyArrayDyn::zeros(py, shape.to_vec(), false)), columns: [column, 1] }
    }

    /// The array, borrowed for writing. It is new, so nobody else has it.
    pub fn borrow(&self) -> PyResult<Borrowed<'py>> {
        Ok(match &self.array {
            Array::Single(array) => Borrowed::Single(array.try_readwrite()?),
            Array::Double(array) => Borrowed::Double(array.try_readwrite()?),
            Array::Index(array) => Borrowed::Index(array.try_readwrite()?),
        })
    }

    /// The first column, and how many there are.
    pub fn columns(&self) -> [usize; 2] {
        self.columns
    }

    pub fn into_any(self) -> Bound<'py, PyAny> {
        match self.array {
            Array::Single(array) => array.into_any(),
            Array::Double(array) => array.into_any(),
            Array::Index(array) => array.into_any(),
        }
    }
}

/// A new array of Python, borrowed for writing.
pub enum Borrowed<'py> {
    Single(numpy::PyReadwriteArrayDyn<'py, f32>),
    Double(numpy::PyReadwriteArrayDyn<'py, f64>),
    Index(numpy::PyReadwriteArrayDyn<'py, i8>),
}

impl Borrowed<'_> {
    pub fn slice(&mut self) -> PyResult<Slice<'_>> {
        Ok(match self {
            Borrowed::Single(array) => Slice::Single(array.as_slice_mut()?),
            Borrowed::Double(array) => Slice::Double(array.as_slice_mut()?),
            Borrowed::Index(array) => Slice::Index(array.as_slice_mut()?),
        })
    }
}

/// The part of each output that belongs to each chunk of the queries.
pub fn split(slices: Vec<(Slice<'_>, [usize; 2])>, total: usize, chunk: usize) -> Vec<Vec<(Slice<'_>, [usize; 2])>> {
    let mut parts: Vec<Vec<_>> = (0..total.div_ceil(chunk)).map(|_| Vec::new()).collect();
    for (slice, columns) in slices {
        let length = chunk * columns[1];
        macro_rules! part {
            ($slice:ident, $kind:ident) => {
                $slice
                    .chunks_mut(length)
                    .zip(&mut parts)
                    .for_each(|(chunk, part)| part.push((Slice::$kind(chunk), columns)))
            };
        }
        match slice {
            Slice::Single(slice) => part!(slice, Single),
            Slice::Double(slice) => part!(slice, Double),
            Slice::Index(slice) => part!(slice, Index),
        }
    }
    parts
}

/// Copies columns into rows of the outputs.
pub fn store(results: &[f32], count: usize, slices: &mut [(Slice<'_>, [usize; 2])]) {
    for (slice, [first, width]) in slices {
        let columns = &results[*first * count..][..*width * count];
        match slice {
            Slice::Single(rows) => transpose(columns, count, rows, |x| x),
            Slice::Double(rows) => transpose(columns, count, rows, f64::from),
            Slice::Index(rows) => transpose(columns, count, rows, |x| x as i8),
        }
    }
}

fn transpose<T>(columns: &[f32], count: usize, rows: &mut [T], convert: impl Fn(f32) -> T) {
    let width = columns.len() / count;
    if width == 3 {
        let [x, y, z] = [0, 1, 2].map(|c| &columns[c * count..][..count]);
        for (((row, x), y), z) in rows.as_chunks_mut().0.iter_mut().zip(x).zip(y).zip(z) {
            *row = [convert(*x), convert(*y), convert(*z)];
        }
        return;
    }
    for (c, column) in columns.chunks_exact(count).enumerate() {
        for (row, x) in rows.chunks_exact_mut(width).zip(column) {
            row[c] = convert(*x);
        }
    }
}
