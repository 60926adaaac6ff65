//! The far field of models, and the reference: a whole fibre, traced photon by photon.

use crate::arrays::Real;
use crate::checks::{self, out_of_range, whole, within};
use crate::error::value;
use crate::fiber;
use crate::threads;
use numpy::{PyArray, PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyTuple;
use rayon::prelude::*;
use vellus::{Model, WindowSupport};
use vellus_models::{Directions, ModelKind};
use vellus_reference::simulate::energies::{Fate, Offsets, energies};
use vellus_reference::simulate::profile::Cells;

/// The most cells of a simulated profile. Sixty-four histograms of them are in memory at a time.
const MOST_CELLS: usize = 500_000;

/// The most photons: days of work.
const MOST_PHOTONS: u64 = 100_000_000_000;

/// Angles along one axis, in degrees.
fn axis(name: &'static str, given: &Bound<'_, PyAny>, [low, high]: [f64; 2]) -> PyResult<Vec<f64>> {
    let given = Real::new(given, name)?;
    if given.shape().len() > 1 {
        let shape = crate::arrays::text(given.shape());
        return Err(PyValueError::new_err(format!("{name} has the shape {shape}: it must be (angles,)")));
    }
    let angles = given.doubles();
    match angles.iter().position(|x| !(low..=high).contains(x)) {
        Some(i) => Err(PyValueError::new_err(format!(
            "{name}[{i}] = {} is out of range: it must be in [{low}, {high}] degrees",
            angles[i]
        ))),
        None => Ok(angles),
    }
}

fn inclination(theta_o: f64) -> PyResult<()> {
    within("theta_o", theta_o, -90.0..=90.0)
}

/// The far field of a model: f·cos θᵢ averaged over the width of the fibre.
///
/// `fiber`: a `Fiber` or the name of a preset. `theta_o`: inclination of ω_o, in [-90, 90] degrees; its azimuth is 0.
/// `theta`, `phi`: inclinations in [-90, 90] and azimuths in [-360, 720] of ω_i, in degrees, shapes (T,) and (P,).
/// `model`: one of `vellus.models.NAMES`.
///
/// Returns float32 of shape (T, P, 3), RGB.
/// Raises `ValueError` for an angle out of range or an unknown model.
#[pyfunction]
#[pyo3(signature = (fiber, theta_o, theta, phi, *, model = "vellus"))]
fn profile<'py>(
    py: Python<'py>,
    fiber: &Bound<'py, PyAny>,
    theta_o: f64,
    theta: &Bound<'py, PyAny>,
    phi: &Bound<'py, PyAny>,
    model: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let kind: ModelKind = model.parse().map_err(value)?;
    let model = kind.model(&fiber::argument(fiber)?).map_err(value)?;
    inclination(theta_o)?;
    let theta = axis("theta", theta, [-90.0, 90.0])?;
    let phi = axis("phi", phi, [-360.0, 720.0])?;
    let mut values = vec![[0.0f32; 3]; theta.len() * phi.len()];
    if !values.is_empty() {
        // A near-field model shares work between all inclinations. Other models compute each direction alone.
        let rows = if model.field() == WindowSupport::Near { theta.len() } else { 1 };
        threads::run(py, |watch| {
            values.par_chunks_mut(rows * phi.len()).zip(theta.par_chunks(rows)).for_each(|(values, theta)| {
                if !watch.is_stopped() {
                    let angles: Vec<_> = theta.iter().flat_map(|t| phi.iter().map(move |p| [*t, *p])).collect();
                    model.far_field(theta_o, &Directions::new(&angles), values);
                }
            });
        })?;
    }
    Ok(PyArray1::from_slice(py, values.as_flattened()).reshape([theta.len(), phi.len(), 3])?.into_any())
}

/// The number of photons.
///
/// # Errors
/// `ValueError` that names its range.
pub fn photons(photons: i128) -> PyResult<u64> {
    whole("photons", photons, 2..=MOST_PHOTONS)
}

/// The centres of cells: ascending and equidistant.
fn centres(name: &str, angles: &[f64], size: Option<f64>) -> PyResult<f64> {
    let step = match (angles, size) {
        (_, Some(size)) if size > 0.0 && size <= 360.0 => size,
        (_, Some(size)) => {
            return Err(PyValueError::new_err(format!(
                "size of {name} = {size} is out of range: it must be in (0, 360]"
            )));
        }
        ([first, .., last], None) => (last - first) / (angles.len() - 1) as f64,
        _ => return Err(PyValueError::new_err(format!("{name} has fewer than two angles: give size"))),
    };
    let apart = angles.windows(2).find(|w| {
        let expected = (angles[angles.len() - 1] - angles[0]) / (angles.len() - 1) as f64;
        w[1] <= w[0] || (w[1] - w[0] - expected).abs() > 1e-4 * expected
    });
    match apart {
        Some(w) => Err(PyValueError::new_err(format!(
            "{name} has {} after {}: the angles must be ascending and equidistant",
            w[1], w[0]
        ))),
        None => Ok(step),
    }
}

/// Simulates the far field of a whole fibre, without a model: photons cross a rough cuticle with tilted scales, cortex
/// and medulla.
///
/// `fiber`: a `Fiber` or the name of a preset. `theta_o`: inclination at which light arrives, in (-90, 90) degrees.
/// `theta`, `phi`: centres of cells, degrees, ascending and equidistant, shapes (T,) and (P,). `size`: the width of a
/// cell in theta and phi, degrees; without it, the distance of the centres. `photons`: in [2, 1e11]. `seed`: the result
/// depends on it, but not on the number of threads. `progress(done, what)` gets reports, `done` in [0, 1].
///
/// Returns f·cos θᵢ averaged over each cell: float64 of shape (T, P, 3), RGB.
/// Raises `ValueError` for an argument out of range. Ctrl-C ends the simulation.
#[pyfunction]
#[pyo3(signature = (fiber, theta_o, theta, phi, *, size = None, photons = 1_000_000, seed = 1, progress = None))]
fn simulate<'py>(
    py: Python<'py>,
    fiber: &Bound<'py, PyAny>,
    theta_o: f64,
    theta: &Bound<'py, PyAny>,
    phi: &Bound<'py, PyAny>,
    size: Option<[f64; 2]>,
    photons: i128,
    seed: i128,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let fiber = fiber::argument(fiber)?;
    below_a_right_angle(theta_o)?;
    let (photons, seed) = (self::photons(photons)?, checks::seed(seed)?);
    let theta = axis("theta", theta, [-90.0, 90.0])?;
    let phi = axis("phi", phi, [-360.0, 720.0])?;
    let shape = [theta.len(), phi.len(), 3];
    if theta.is_empty() || phi.is_empty() {
        return Ok(PyArrayDyn::<f64>::zeros(py, shape.to_vec(), false).into_any());
    }
    if theta.len().saturating_mul(phi.len()) > MOST_CELLS {
        let count = theta.len() * phi.len();
        return Err(PyValueError::new_err(format!("{count} cells of theta and phi are more than {MOST_CELLS}")));
    }
    let size = [centres("theta", &theta, size.map(|s| s[0]))?, centres("phi", &phi, size.map(|s| s[1]))?];
    let radians = |angles: Vec<f64>| angles.into_iter().map(f64::to_radians).collect();
    let cells = Cells { theta: radians(theta), phi: radians(phi), size: size.map(f64::to_radians) };
    let values = threads::run_reporting(py, progress, |watch| {
        vellus_reference::simulate::profile::profile(&fiber, theta_o.to_radians(), &cells, photons, seed, watch)
    })?;
    Ok(PyArray1::from_slice(py, values.map_err(value)?.as_flattened()).reshape(shape)?.into_any())
}

fn below_a_right_angle(theta_o: f64) -> PyResult<()> {
    if theta_o.abs() < 90.0 { Ok(()) } else { Err(out_of_range("theta_o", theta_o, "in (-90, 90) degrees")) }
}

/// Simulates the energies of the paths through a whole fibre with a smooth cuticle and flat scales.
///
/// `fiber`: a `Fiber` or the name of a preset. `theta_o`: inclination at which light arrives, in (-90, 90) degrees.
/// `h`: the offset in [-1, 1], or `None` for the whole width. `photons`, `seed`, `progress`: as for `simulate`.
///
/// Returns `SimulatedEnergies`: shares of the light that hits the fibre, with standard errors.
/// Raises `ValueError` for an argument out of range. Ctrl-C ends the simulation.
#[pyfunction]
#[pyo3(signature = (fiber, theta_o, h = None, *, photons = 1_000_000, seed = 1, progress = None))]
fn simulate_energies<'py>(
    py: Python<'py>,
    fiber: &Bound<'py, PyAny>,
    theta_o: f64,
    h: Option<f64>,
    photons: i128,
    seed: i128,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    static CLASS: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let class = CLASS
        .get_or_try_init(py, || PyResult::Ok(py.import("vellus._types")?.getattr("SimulatedEnergies")?.unbind()))?;
    let fiber = fiber::argument(fiber)?;
    below_a_right_angle(theta_o)?;
    let (photons, seed) = (self::photons(photons)?, checks::seed(seed)?);
    let offsets = h.map_or(Offsets::Whole, Offsets::At);
    let simulated = threads::run_reporting(py, progress, |watch| {
        energies(&fiber, theta_o.to_radians(), offsets, photons, seed, watch)
    })?
    .map_err(value)?;
    let table = |rows: &[[f64; 3]; 6]| PyArray::from_slice(py, rows.as_flattened()).reshape([6, 3]);
    let [total, total_error] = simulated.total.map(|rgb| PyArray::from_slice(py, &rgb));
    class.bind(py).call1((table(&simulated.mean)?, table(&simulated.error)?, total, total_error))
}

/// Adds the functions of this file.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("FATES", PyTuple::new(module.py(), Fate::ALL.map(Fate::key))?)?;
    module.add_function(wrap_pyfunction!(profile, module)?)?;
    module.add_function(wrap_pyfunction!(simulate, module)?)?;
    module.add_function(wrap_pyfunction!(simulate_energies, module)?)
}
