//! The tables of the medulla as arrays.

use crate::error::value;
use numpy::{PyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use vellus::grid::{self, OutgoingAxis, g_at, offset_at, tau_at, theta_at};
use vellus::parts::{
    ABSORPTIONS, ENTRIES, ExitData, NODES, REACHES, ROWS, SHIPPED_EXITS, STATES, TAU_STEP, absorption_at, cell,
};
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

/// The tables of the medulla that ship with the model, as new arrays.
///
/// Light that the medulla scatters has the azimuthal density C^N and the longitudinal density C^M. Both are tables over
/// four axes, stored as sums of products: T[i, j, k, l] = Σ_r a[i, r] b[j, r] c[k, r] d[l, r].
///
/// Returns a dict of dicts. `azimuthal`, `backward` and `forward` have one factor for each axis, float32 of shape
/// (nodes, rank), and its nodes, float64, under the axis's name with `_nodes`:
///
/// - `azimuthal`, C^N: `tau`, `g`, `h`, `phi`; proportional to a density per radian.
/// - `backward`, C^M of the backward half: `tau`, `g`, `theta_o`, `theta_i`; proportional to a density.
/// - `forward`, C^M of the forward half: `tau`, `g`, `theta_o`, `delta`, where delta = θ_i + θ_o.
/// - `mean_path`: `value` of shape (tau, g, h), the mean path in radii of the medulla, and `tau_nodes`, `g_nodes`,
///   `h_nodes`.
/// - `exit`, first exits: `state` (tau, g, 24, 8), probability of each state; `path` (tau, g, 6, 8), effective path in
///   radii of the medulla; `entry_nodes` (8, 2), c = √(1 − h²) and sin²θ_t / 0.9; `absorption_nodes` (6,);
///   `state_cells` (24, 2, 2), ends of |θ′| and of |h| of each state; `turn` (tau, g, 4, 3), coefficients of h, h cos ψ
///   and (1 − h²) sin ψ in the fit to the offset at which light leaves the medulla, up to each of `reach_nodes` (4,). ψ
///   is the azimuth from straight on.
/// - `constants` of the axes: `tau_max`, `tau_growth` and `tau_scale` of ln(1 + kτ), `g_max`, `theta_max` in radians,
///   and of the cone of light that leaves `cones` and `shifts`, its numbers of nodes, and `most_eta`.
///
/// Axes: `tau` is the optical radius, spaced evenly in ln(1 + kτ); `g` the anisotropy, evenly in ln(1 − g); `h` the
/// offset in radii of the medulla, evenly in asin h; all angles in radians, evenly.
#[pyfunction]
fn tables(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let data = TableData::from_bytes(Tables::SHIPPED).map_err(value)?;
    let all = PyDict::new(py);
    let azimuthal = mixture(py, &data.azimuthal, ["tau", "g", "h", "phi"], offset_at, OutgoingAxis::AZIMUTH)?;
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
    all.set_item("exit", exits(py)?)?;
    let constants = PyDict::new(py);
    for (name, constant) in [
        ("tau_max", grid::TAU_MAX),
        ("tau_growth", grid::TAU_GROWTH),
        ("tau_scale", grid::TAU_SCALE),
        ("g_max", grid::G_MAX),
        ("theta_max", grid::THETA_MAX),
        ("most_eta", grid::MOST_ETA.into()),
    ] {
        constants.set_item(name, constant)?;
    }
    constants.set_item("cones", grid::CONES)?;
    constants.set_item("shifts", grid::SHIFTS)?;
    all.set_item("constants", constants)?;
    Ok(all)
}

/// The table of first exits.
fn exits(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let data = ExitData::from_bytes(SHIPPED_EXITS).map_err(value)?;
    let [tau, g] = data.nodes;
    let (mut states, mut paths) = (Vec::new(), Vec::new());
    for values in data.values.chunks_exact(ROWS * ENTRIES) {
        let (state, path) = values.split_at(STATES * ENTRIES);
        // As the model decodes it: half floats round, and all light must leave.
        let sums: [f32; ENTRIES] =
            std::array::from_fn(|entry| state.iter().skip(entry).step_by(ENTRIES).fold(0.0, |sum, x| sum + x));
        states.extend(state.iter().enumerate().map(|(i, x)| x / sums[i % ENTRIES]));
        paths.extend_from_slice(path);
    }
    let entry = PyDict::new(py);
    entry.set_item("state", PyArray::from_vec(py, states).reshape([tau, g, STATES, ENTRIES])?)?;
    entry.set_item("path", PyArray::from_vec(py, paths).reshape([tau, g, ABSORPTIONS, ENTRIES])?)?;
    entry.set_item("turn", PyArray::from_vec(py, data.turns).reshape([tau, g, REACHES.len(), 3])?)?;
    entry.set_item("reach_nodes", PyArray::from_slice(py, &REACHES))?;
    let taus: Vec<f64> = (0..tau).map(|i| tau_at(i as f64 * TAU_STEP)).collect();
    entry.set_item("tau_nodes", PyArray::from_vec(py, taus))?;
    entry.set_item("g_nodes", PyArray::from_vec(py, nodes(g, g_at)))?;
    entry.set_item("entry_nodes", PyArray::from_slice(py, NODES.as_flattened()).reshape([ENTRIES, 2])?)?;
    let absorptions: Vec<f64> = (0..ABSORPTIONS).map(absorption_at).collect();
    entry.set_item("absorption_nodes", PyArray::from_vec(py, absorptions))?;
    let cells: Vec<f64> = (0..STATES).flat_map(cell).flatten().collect();
    entry.set_item("state_cells", PyArray::from_vec(py, cells).reshape([STATES, 2, 2])?)?;
    Ok(entry)
}

/// Adds the function of this file.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(tables, module)?)
}
