//! Arguments that are arrays of real numbers, and their broadcasting.

use numpy::{
    PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods, dtype,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{IntoPyDict, PyFloat, PyInt};

/// An argument: an array in row-major order, or a plain number.
pub enum Real<'py> {
    Single(PyReadonlyArrayDyn<'py, f32>),
    Double(PyReadonlyArrayDyn<'py, f64>),
    /// A number of Python. It does not decide the type of the result.
    Number([f64; 1]),
    /// Two of them.
    Pair([f64; 2]),
}

/// `numpy.NAME`, looked up once.
fn numpy<'py>(py: Python<'py>, cell: &'static PyOnceLock<Py<PyAny>>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    let function = cell.get_or_try_init(py, || PyResult::Ok(py.import("numpy")?.getattr(name)?.unbind()))?;
    Ok(function.bind(py).clone())
}

/// `numpy.asarray(value)`.
fn as_array<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    static ASARRAY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    numpy(value.py(), &ASARRAY, "asarray")?.call1((value,))
}

/// An aligned copy in row-major order, in the machine's byte order.
fn copied<'py>(value: &Bound<'py, PyAny>, kind: &str) -> PyResult<Bound<'py, PyAny>> {
    static ARRAY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let options = [("dtype", kind), ("order", "C")].into_py_dict(value.py())?;
    numpy(value.py(), &ARRAY, "array")?.call((value,), Some(&options))
}

impl<'py> Real<'py> {
    /// Reads the argument `name`.
    ///
    /// # Errors
    /// `TypeError` if it is not an array of real numbers, or of lists that make one.
    pub fn new(value: &Bound<'py, PyAny>, name: &str) -> PyResult<Self> {
        if value.is_instance_of::<PyFloat>() || value.is_instance_of::<PyInt>() {
            // NumPy's float64 is a float, too: it counts as a plain number.
            let number = value.extract::<f64>();
            return number.map(|x| Real::Number([x])).map_err(|e| PyValueError::new_err(format!("{name}: {e}")));
        }
        let array = match value.cast::<PyUntypedArray>() {
            Ok(array) => array.clone(),
            Err(_) => as_array(value)
                .and_then(|array| Ok(array.cast_into::<PyUntypedArray>()?))
                .map_err(|e| PyTypeError::new_err(format!("{name} is not an array of real numbers: {e}")))?,
        };
        let py = value.py();
        let kind = array.dtype();
        let is_usable = array.is_c_contiguous() && aligned(&array);
        if kind.is_equiv_to(&dtype::<f32>(py)) {
            let array = if is_usable { array.into_any() } else { copied(&array, "f4")? };
            return Ok(Real::Single(array.cast::<PyArrayDyn<f32>>()?.try_readonly()?));
        }
        if kind.is_equiv_to(&dtype::<f64>(py)) && is_usable {
            return Ok(Real::Double(array.cast::<PyArrayDyn<f64>>()?.try_readonly()?));
        }
        let copy = match kind.kind() {
            b'f' if kind.itemsize() <= 4 => copied(&array, "f4")?,
            b'f' | b'i' | b'u' => copied(&array, "f8")?,
            _ => {
                return Err(PyTypeError::new_err(format!(
                    "{name} has the dtype {kind}: it must be float32 or float64"
                )));
            }
        };
        if let Ok(single) = copy.cast::<PyArrayDyn<f32>>() {
            return Ok(Real::Single(single.try_readonly()?));
        }
        Ok(Real::Double(copy.cast::<PyArrayDyn<f64>>()?.try_readonly()?))
    }

    pub fn shape(&self) -> &[usize] {
        match self {
            Real::Single(array) => array.shape(),
            Real::Double(array) => array.shape(),
            Real::Number(_) => &[],
            Real::Pair(_) => &[2],
        }
    }

    /// Whether the result must be in double precision because of this argument.
    pub fn is_double(&self) -> bool {
        matches!(self, Real::Double(_))
    }

    /// Whether the argument decides the type of the result.
    pub fn has_type(&self) -> bool {
        !matches!(self, Real::Number(_) | Real::Pair(_))
    }

    /// The argument as rows of numbers: `axis` says what a row has. Without it, each number is a row of its own.
    ///
    /// # Errors
    /// `ValueError` if the last axis has another length.
    pub fn rows(&self, name: &'static str, axis: Option<(usize, &str)>) -> PyResult<Rows<'_>> {
        let shape = self.shape();
        let (shape, width) = match (axis, shape.split_last()) {
            (None, _) => (shape, 1),
            (Some((width, _)), Some((last, leading))) if *last == width => (leading, width),
            (Some((width, what)), _) => {
                let shape = text(shape);
                return Err(PyValueError::new_err(format!(
                    "{name} has the shape {shape}: its last axis must have {width} numbers ({what})"
                )));
            }
        };
        let not_contiguous = |e: &dyn std::fmt::Display| PyValueError::new_err(format!("{name}: {e}"));
        let data = match self {
            Real::Single(array) => Data::Single(array.as_slice().map_err(|e| not_contiguous(&e))?),
            Real::Double(array) => Data::Double(array.as_slice().map_err(|e| not_contiguous(&e))?),
            Real::Number(x) => Data::Double(x),
            Real::Pair(x) => Data::Double(x),
        };
        Ok(Rows { name, data, width, shape: shape.to_vec(), strides: Vec::new() })
    }
}

impl Real<'_> {
    /// All numbers in double precision, in row-major order.
    pub fn doubles(&self) -> Vec<f64> {
        match self {
            Real::Single(array) => array.as_array().iter().map(|x| f64::from(*x)).collect(),
            Real::Double(array) => array.as_array().iter().copied().collect(),
            Real::Number(x) => x.to_vec(),
            Real::Pair(x) => x.to_vec(),
        }
    }

    /// All numbers in single precision, in row-major order.
    pub fn floats(&self) -> Vec<f32> {
        match self {
            Real::Single(array) => array.as_array().iter().copied().collect(),
            Real::Double(array) => array.as_array().iter().map(|x| *x as f32).collect(),
            Real::Number(x) => x.iter().map(|x| *x as f32).collect(),
            Real::Pair(x) => x.iter().map(|x| *x as f32).collect(),
        }
    }

    /// The uniform numbers of near-field samples: four, or five of which the last is unused.
    ///
    /// # Errors
    /// As [`Real::rows`].
    pub fn uniform(&self) -> PyResult<Rows<'_>> {
        let four = self.shape().last() == Some(&4);
        self.rows("u", Some((if four { 4 } else { 5 }, "uniform in [0, 1)")))
    }
}

/// Whether the numbers lie where the processor expects them. An array inside a record may not be.
fn aligned(array: &Bound<'_, PyUntypedArray>) -> bool {
    let flags = array.getattr("flags").and_then(|flags| flags.getattr("aligned"));
    flags.and_then(|aligned| aligned.extract::<bool>()).unwrap_or(false)
}

/// A shape as Python writes it.
pub fn text(shape: &[usize]) -> String {
    let numbers: Vec<String> = shape.iter().map(usize::to_string).collect();
    if shape.len() == 1 { format!("({},)", numbers[0]) } else { format!("({})", numbers.join(", ")) }
}

#[derive(Clone, Copy)]
enum Data<'a> {
    Single(&'a [f32]),
    Double(&'a [f64]),
}

/// An argument, as rows of `width` numbers that are broadcast to a shape.
#[derive(Clone)]
pub struct Rows<'a> {
    pub name: &'static str,
    data: Data<'a>,
    pub width: usize,
    shape: Vec<usize>,
    /// The distance, in rows, between neighbours along each axis of the shape that it is broadcast to.
    strides: Vec<usize>,
}

/// Broadcasts arguments to their common shape, by NumPy's rules.
///
/// # Errors
/// `ValueError` if they do not fit together.
pub fn broadcast(arguments: &mut [&mut Rows<'_>]) -> PyResult<Vec<usize>> {
    let axes = arguments.iter().map(|rows| rows.shape.len()).max().unwrap_or(0);
    let mut common = vec![1; axes];
    for rows in &*arguments {
        for (size, length) in common[axes - rows.shape.len()..].iter_mut().zip(&rows.shape) {
            if *size == 1 {
                *size = *length;
            } else if *length != 1 && *length != *size {
                let shapes: Vec<String> =
                    arguments.iter().map(|rows| format!("{} {}", rows.name, text(&rows.shape))).collect();
                let shapes = shapes.join(", ");
                return Err(PyValueError::new_err(format!("the leading shapes do not fit together: {shapes}")));
            }
        }
    }
    for rows in arguments {
        let mut strides = vec![0; axes];
        let mut step = 1;
        for (stride, length) in strides.iter_mut().rev().zip(rows.shape.iter().rev()) {
            *stride = if *length == 1 { 0 } else { step };
            step *= length;
        }
        rows.strides = strides;
    }
    Ok(common)
}

impl Rows<'_> {
    /// Over how many neighbouring rows the argument stays the same.
    pub fn run(&self, shape: &[usize]) -> usize {
        let constant =
            shape.iter().zip(&self.strides).rev().take_while(|(length, stride)| **length == 1 || **stride == 0);
        constant.map(|(length, _)| length).product()
    }

    /// Copies `count` rows from `start` on, each number into its own column of `columns`.
    pub fn gather(&self, shape: &[usize], start: usize, count: usize, columns: &mut [f32]) {
        match self.data {
            Data::Single(data) => self.gather_from(data, |x| x, shape, [start, count], columns),
            Data::Double(data) => self.gather_from(data, |x| x as f32, shape, [start, count], columns),
        }
    }

    fn gather_from<T: Copy>(
        &self,
        data: &[T],
        convert: impl Fn(T) -> f32,
        shape: &[usize],
        [start, count]: [usize; 2],
        columns: &mut [f32],
    ) {
        let width = self.width;
        let last = shape.len().saturating_sub(1);
        let (length, step) = if shape.is_empty() { (1, 0) } else { (shape[last], self.strides[last]) };
        let mut done = 0;
        while done < count {
            let row = start + done;
            let along = row % length;
            let many = (length - along).min(count - done);
            let first = self.outer(shape, row / length) + along * step;
            if step != 0 && width == 3 {
                let (x, rest) = columns.split_at_mut(count);
                let (y, z) = rest.split_at_mut(count);
                let columns = x[done..].iter_mut().zip(&mut y[done..]).zip(&mut z[done..]).take(many);
                for (((x, y), z), row) in columns.zip(data[first * 3..].as_chunks::<3>().0) {
                    (*x, *y, *z) = (convert(row[0]), convert(row[1]), convert(row[2]));
                }
                done += many;
                continue;
            }
            for c in 0..width {
                let column = &mut columns[c * count + done..][..many];
                if step == 0 {
                    column.fill(convert(data[first * width + c]));
                } else {
                    for (x, row) in column.iter_mut().zip(data[first * width..].chunks_exact(width)) {
                        *x = convert(row[c]);
                    }
                }
            }
            done += many;
        }
    }

    /// The row of this argument for a position in the shape.
    pub fn row(&self, shape: &[usize], position: usize) -> usize {
        let (Some(length), Some(step)) = (shape.last(), self.strides.last()) else { return 0 };
        self.outer(shape, position / length) + position % length * step
    }

    /// The row where the last axis starts, for a position over all other axes.
    fn outer(&self, shape: &[usize], mut position: usize) -> usize {
        let mut row = 0;
        for axis in (0..shape.len().saturating_sub(1)).rev() {
            row += position % shape[axis] * self.strides[axis];
            position /= shape[axis];
        }
        row
    }

    /// The index of a row in this argument: `wi[3, 0]`.
    pub fn index(&self, shape: &[usize], mut position: usize) -> String {
        let mut index = vec![0; shape.len()];
        for axis in (0..shape.len()).rev() {
            index[axis] = if self.strides[axis] == 0 { 0 } else { position % shape[axis] };
            position /= shape[axis];
        }
        let own = &index[shape.len() - self.shape.len()..];
        if own.is_empty() {
            return self.name.to_owned();
        }
        let numbers: Vec<String> = own.iter().map(usize::to_string).collect();
        format!("{}[{}]", self.name, numbers.join(", "))
    }
}
