//! The buffers of the shader library as arrays.

use crate::error::value;
use crate::fiber::Fiber;
use numpy::{PyArray, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use vellus::{Bcsdf, Tables, packed};

type Array<'py> = PyResult<Bound<'py, PyArray2<f32>>>;

/// Rows of four numbers.
fn array(py: Python<'_>, rows: Vec<[f32; 4]>) -> Array<'_> {
    let count = rows.len();
    PyArray::from_vec(py, rows.into_flattened()).reshape([count, 4])
}

#[pymethods]
impl Fiber {
    /// The record of the fibre in shaders: what the buffer that `vellus_row` reads has for it. A buffer holds the
    /// records of its fibres one after another.
    ///
    /// Returns float32 of shape (rows, 4). All fibres have the same number of rows.
    fn shader_record<'py>(&self, py: Python<'py>) -> Array<'py> {
        packed::supports(&self.0).map_err(value)?;
        array(py, packed::fiber(&Bcsdf::new(&self.0).map_err(value)?).to_vec())
    }

    /// What the fibre needs beside its record for other absorption at each hit, `vellus_hit_colored`: rows in the
    /// buffer of the records, whose first one the shader gets.
    ///
    /// Returns float32 of shape (rows, 4). All fibres have the same number of rows.
    fn shader_color<'py>(&self, py: Python<'py>) -> Array<'py> {
        packed::supports(&self.0).map_err(value)?;
        array(py, packed::color(&Bcsdf::new(&self.0).map_err(value)?).to_vec())
    }

    /// The far field of the fibre in shaders: a table that `vellus_far_row` reads.
    ///
    /// Returns float32 of shape (rows, 4). The number of rows depends on the fibre: 18 MB at most.
    fn shader_far_table<'py>(&self, py: Python<'py>) -> Array<'py> {
        packed::supports(&self.0).map_err(value)?;
        let bcsdf = Bcsdf::new(&self.0).map_err(value)?;
        array(py, py.detach(|| packed::far(&bcsdf)).rows)
    }
}

/// The tables that all fibres share in shaders: the buffer that `vellus_table` reads. The shaders must be those of the
/// same version: `vellus.__version__`.
///
/// Returns float32 of shape (rows, 4): 1.8 MB.
#[pyfunction]
fn shader_tables(py: Python<'_>) -> Array<'_> {
    array(py, packed::tables(Tables::shipped()).rows)
}

/// Adds the function of this file.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(shader_tables, module)?)
}
