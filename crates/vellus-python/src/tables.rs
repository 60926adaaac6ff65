//! The tables of the medulla as arrays.

use crate::error::value;
use numpy::{PyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use vellus::grid::{OutgoingAxis, g_at, offset_at, tau_at, theta_at};
use vellus::{FactorTable, TableData, Tables};

/// Positions of `nodes` nodes along an axis.
fn nodes(nodes: usize, at: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..nodes).map(|i| at(i as f64 / (nodes - 1) as f64)).collect()
}

fn outgoing(axis: OutgoingAxis, count: usize) -> Vec<f64> {
    nodes(count, |position| axis.first + position * (axis.last - axis.first))
}

/// Four factors and the nodes of their axes.
fn mixture<'py>(
    py: Python<'py>,
    table: &FactorTable,
    names: [&str; 4],
    third: impl Fn(f64) -> f64,
    last: OutgoingAxis,
) -> PyResult<Bound<'py, PyDict>> {
    let entry = PyDict::new(py);
    for (mode, name) in names.into_iter().enumerate() {
        let factor = &table.factors[mode];
        let count = factor.len() / table.rank;
        let axis = match mode {
            0 => nodes(count, tau_at),
            1 => nodes(count, g_at),
            2 => nodes(count, &third),
            _ => outgoing(last, count),
        };
        entry.set_item(name, PyArray::from_slice(py, factor).reshape([count, table.rank])?)?;
        entry.set_item(format!("{name}_nodes"), PyArray::from_vec(py, axis))?;
    }
    Ok(entry)
}

/// The tables of the medulla. The stub and the book document their axes.
#[pyfunction]
fn tables(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let data = TableData::from_bytes(Tables::SHIPPED).map_err(value)?;
    let all = PyDict::new(py);
    let azimuthal =
        mixture(py, &data.azimuthal, ["tau", "g", "h", "phi"], offset_at, OutgoingAxis::AZIMUTH)?;
    let backward = OutgoingAxis::BACKWARD;
    let forward = OutgoingAxis::FORWARD;
    all.set_item("azimuthal", azimuthal)?;
    all.set_item("backward", mixture(py, &data.backward, ["tau", "g", "theta_o", "theta_i"], theta_at, backward)?)?;
    all.set_item("forward", mixture(py, &data.forward, ["tau", "g", "theta_o", "delta"], theta_at, forward)?)?;
    let path = PyDict::new(py);
    let [tau, g, h] = data.mean_path_nodes;
    path.set_item("value", PyArray::from_slice(py, &data.mean_path).reshape([tau, g, h])?)?;
    path.set_item("tau_nodes", PyArray::from_vec(py, nodes(tau, tau_at)))?;
    path.set_item("g_nodes", PyArray::from_vec(py, nodes(g, g_at)))?;
    path.set_item("h_nodes", PyArray::from_vec(py, nodes(h, offset_at)))?;
    all.set_item("mean_path", path)?;
    Ok(all)
}

/// Adds the function of this file.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(tables, module)?)
}
