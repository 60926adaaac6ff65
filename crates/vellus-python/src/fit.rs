//! Measured profiles, and fits of a fibre to them.

use crate::arrays::{Real, Rows, broadcast};
use crate::checks::{self, out_of_range, whole};
use crate::error::value;
use crate::fiber::{self, Fiber};
use crate::plots::{Drawing, Plot};
use crate::simulate;
use crate::threads;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use vellus_fit::simulate::Source;
use vellus_fit::{Forward, Options, Point, Quantity, Reading, Synthetic};
use vellus_models::ModelKind;
use vellus_plot::fit::Summary;

/// Light scattered by one fibre, averaged over its width, between one fixed direction and many others.
///
/// `theta`, `phi`: the directions, degrees: θ in (-90, 90) from the normal plane, φ from the azimuth of the fixed
/// direction. `values`: RGB with a last axis of 3, or grey without it, in any unit. The leading shapes of all three are
/// broadcast, so a grid is `theta[:, None], phi[None, :], values`. A value of NaN or 0 is missing. `theta_o`:
/// inclination of the fixed direction, in (-90, 90) degrees. `quantity`: `f-cos` if values are proportional to f·cos θ,
/// or `f`. `channels`: 1 or 3; without it, 3 if the last axis of `values` has 3 numbers that `theta` and `phi` lack.
///
/// Raises `ValueError` for an angle or value out of range.
#[pyclass(frozen, module = "vellus", name = "Profile")]
#[derive(Clone, Debug)]
pub struct Profile(Arc<vellus_fit::Profile>);

fn quantity(name: Option<&str>) -> PyResult<Option<Quantity>> {
    name.map(|name| name.parse().map_err(|e| PyValueError::new_err(format!("quantity = '{name}': {e}")))).transpose()
}

/// The number of channels.
fn grey_or_rgb(channels: i128) -> PyResult<usize> {
    match channels {
        1 => Ok(1),
        3 => Ok(3),
        n => Err(out_of_range("channels", n, "1 or 3")),
    }
}

/// All rows of an argument, broadcast to `shape`.
fn all(rows: &Rows<'_>, real: &Real<'_>, shape: &[usize]) -> Vec<Vec<f64>> {
    // Single precision is not enough for values of 1e-40, so positions are gathered instead of numbers.
    let numbers = real.doubles();
    let count: usize = shape.iter().product();
    (0..count)
        .map(|i| {
            let first = rows.row(shape, i) * rows.width;
            numbers[first..first + rows.width].to_vec()
        })
        .collect()
}

#[pymethods]
impl Profile {
    #[new]
    #[pyo3(signature = (theta, phi, values, *, theta_o, quantity = None, channels = None))]
    fn new(
        theta: &Bound<'_, PyAny>,
        phi: &Bound<'_, PyAny>,
        values: &Bound<'_, PyAny>,
        theta_o: f64,
        quantity: Option<&str>,
        channels: Option<i128>,
    ) -> PyResult<Self> {
        let [theta, phi, values] =
            [(theta, "theta"), (phi, "phi"), (values, "values")].map(|(given, name)| Real::new(given, name));
        let (theta, phi, values) = (theta?, phi?, values?);
        let axes = theta.shape().len().max(phi.shape().len());
        let channels = match channels {
            Some(n) => grey_or_rgb(n)?,
            None if values.shape().len() > axes && values.shape().last() == Some(&3) => 3,
            None => 1,
        };
        let rgb = (channels == 3).then_some((3, "red, green, blue"));
        let (mut t, mut p, mut v) = (theta.rows("theta", None)?, phi.rows("phi", None)?, values.rows("values", rgb)?);
        let shape = broadcast(&mut [&mut t, &mut p, &mut v])?;
        let (mut points, mut missing) = (Vec::new(), Vec::new());
        let angles = all(&t, &theta, &shape).into_iter().zip(all(&p, &phi, &shape));
        for ((t, p), v) in angles.zip(all(&v, &values, &shape)) {
            let (theta, phi) = (t[0], p[0]);
            if v.iter().any(|x| x.is_nan() || *x == 0.0) {
                missing.push([theta, phi]);
            } else {
                points.push(Point { theta, phi, value: std::array::from_fn(|c| v[c % channels]) });
            }
        }
        let quantity = self::quantity(quantity)?.unwrap_or_default();
        let (negative, simulated) = (0, Vec::new());
        Profile::checked(vellus_fit::Profile { theta_o, quantity, channels, points, missing, negative, simulated })
    }

    /// Reads a profile from the file `path`: `.txt`, `.csv`, `.npy` or `.exr`, as the book says in "Fitting".
    ///
    /// `theta_o`: inclination of the fixed direction, degrees, if the file does not have it. `angles`: `fiber` or
    /// `gantry`. `quantity`: `f-cos` or `f`. `theta`, `phi`: first and last angle of the rows and columns of an image.
    ///
    /// Raises `ValueError` that names the file, the line and the problem.
    #[staticmethod]
    #[pyo3(signature = (path, *, theta_o = None, angles = None, quantity = None, theta = None, phi = None))]
    fn read(
        path: PathBuf,
        theta_o: Option<f64>,
        angles: Option<&str>,
        quantity: Option<&str>,
        theta: Option<[f64; 2]>,
        phi: Option<[f64; 2]>,
    ) -> PyResult<Self> {
        let angles = angles
            .map(|name| name.parse().map_err(|e| PyValueError::new_err(format!("angles = '{name}': {e}"))))
            .transpose()?;
        let axis = |[first, last]: [f64; 2]| vellus_fit::Axis { first, last };
        let axes = match (theta, phi) {
            (Some(theta), Some(phi)) => Some([axis(theta), axis(phi)]),
            (None, None) => None,
            _ => return Err(PyTypeError::new_err("theta and phi must be given together")),
        };
        let reading = Reading { theta_o, angles, quantity: self::quantity(quantity)?, axes };
        vellus_fit::read(&path, &reading).map(|profile| Profile(Arc::new(profile))).map_err(value)
    }

    /// Makes a synthetic measurement of a fibre, for tests and examples.
    ///
    /// `fiber`: a `Fiber` or the name of a preset. `theta_o`: inclination of the fixed direction, -30 without it.
    /// `theta`, `phi`: first and last angle; 10 to 50 and -20 to 200 without them. `step`: steps over theta and
    /// phi, 2 degrees without it. `noise`: standard deviation of
    /// the logarithm of each value, in [0, 1]. `gaps`: share of missing directions, in [0, 0.9]. `scale`: factor on the
    /// values. `channels`: 1 or 3. `seed`: another seed gives other noise. `photons`: traces a whole fibre with so many
    /// photons, in [2, 1e11], instead of a model. `model`: `vellus`, `yan2015`, `chiang2016` or `marschner2003`.
    /// `progress(done, what)` gets reports.
    ///
    /// Raises `ValueError` for an argument out of range.
    #[staticmethod]
    #[pyo3(signature = (fiber, *, theta_o = -30.0, theta = [10.0, 50.0], phi = [-20.0, 200.0], step = [2.0, 2.0],
        noise = 0.02, gaps = 0.1, scale = 1.0, channels = 1, seed = 1, photons = None, model = "vellus",
        progress = None))]
    fn measure(
        py: Python<'_>,
        fiber: &Bound<'_, PyAny>,
        theta_o: f64,
        theta: [f64; 2],
        phi: [f64; 2],
        step: [f64; 2],
        noise: f64,
        gaps: f64,
        scale: f64,
        channels: i128,
        seed: i128,
        photons: Option<i128>,
        model: &str,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let fiber = fiber::argument(fiber)?;
        fiber.validate().map_err(value)?;
        let (channels, seed) = (grey_or_rgb(channels)?, checks::seed(seed)?);
        let gantry = Synthetic { theta_o, theta, phi, step, noise, gaps, scale, channels, seed };
        let kind: ModelKind = model.parse().map_err(value)?;
        let source = match photons {
            Some(photons) => Source::Reference(fiber, simulate::photons(photons)?),
            None => Source::Model(Forward::new(kind).map_err(value)?, fiber.into()),
        };
        let profile = threads::run_reporting(py, progress, |watch| source.measure(&gantry, watch))?;
        profile.map(|profile| Profile(Arc::new(profile))).map_err(value)
    }

    /// Inclination of the fixed direction, degrees.
    #[getter]
    fn theta_o(&self) -> f64 {
        self.0.theta_o
    }

    /// `f-cos` or `f`.
    #[getter]
    fn quantity(&self) -> &'static str {
        self.0.quantity.name()
    }

    /// Number of channels: 1 or 3.
    #[getter]
    fn channels(&self) -> usize {
        self.0.channels
    }

    /// θ of each value, degrees: float64 of shape (N,).
    #[getter]
    fn theta<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.0.points.iter().map(|p| p.theta))
    }

    /// φ of each value, degrees: float64 of shape (N,).
    #[getter]
    fn phi<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.0.points.iter().map(|p| p.phi))
    }

    /// The values: float64 of shape (N, channels).
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        rows(py, self.0.points.iter().map(|p| p.value), self.0.channels)
    }

    /// θ and φ of the directions without a value: float64 of shape (M, 2).
    #[getter]
    fn missing<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let numbers = PyArray1::from_slice(py, self.0.missing.as_flattened());
        Ok(numbers.reshape([self.0.missing.len(), 2])?.into_any())
    }

    /// Names and values of the parameters that were simulated, if this is a synthetic measurement.
    #[getter]
    fn simulated<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        self.0.simulated.iter().try_for_each(|(name, x)| dict.set_item(name, x))?;
        Ok(dict)
    }

    /// The profile as CSV, with the columns theta, phi, and value or r, g, b.
    fn to_csv(&self) -> String {
        vellus_fit::csv(&self.0, &[])
    }

    /// Writes the profile to the file `path`: `.txt` in the coordinates of a gantry, or `.csv`.
    ///
    /// Raises `ValueError` for another name, and `OSError` if it cannot be written.
    fn write(&self, path: PathBuf) -> PyResult<()> {
        let text = vellus_fit::writer(&path).map_err(value)?(&self.0, &[]);
        std::fs::write(&path, text).map_err(|e| PyErr::from(e).into_named(&path))
    }

    fn __len__(&self) -> usize {
        self.0.points.len()
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Profile>().is_ok_and(|other| self.0 == other.get().0)
    }

    fn __repr__(&self) -> String {
        let p = &self.0;
        let color = if p.channels == 1 { "grey" } else { "RGB" };
        let (count, missing) = (p.points.len(), p.missing.len());
        format!("<Profile: {count} directions, {missing} missing, {color}, theta_o={}>", p.theta_o)
    }

    /// For pickle.
    #[allow(clippy::type_complexity)]
    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(
        Bound<'py, PyAny>,
        (Vec<[f64; 5]>, Vec<[f64; 2]>, usize, Vec<(String, f64)>, f64, &'static str, usize),
    )> {
        let p = &slf.get().0;
        let points = p.points.iter().map(|Point { theta, phi, value: [r, g, b] }| [*theta, *phi, *r, *g, *b]).collect();
        let (missing, simulated) = (p.missing.clone(), p.simulated.clone());
        let state = (points, missing, p.negative, simulated, p.theta_o, p.quantity.name(), p.channels);
        Ok((slf.get_type().getattr("_from_state")?, state))
    }

    #[staticmethod]
    fn _from_state(
        points: Vec<[f64; 5]>,
        missing: Vec<[f64; 2]>,
        negative: usize,
        simulated: Vec<(String, f64)>,
        theta_o: f64,
        quantity: &str,
        channels: usize,
    ) -> PyResult<Self> {
        let points = points.into_iter().map(|[theta, phi, r, g, b]| Point { theta, phi, value: [r, g, b] }).collect();
        let quantity = quantity.parse().map_err(value)?;
        let channels = if channels == 1 { 1 } else { 3 };
        Profile::checked(vellus_fit::Profile { theta_o, quantity, channels, points, missing, negative, simulated })
    }
}

/// Adds the name of a file to an error of the operating system.
trait IntoNamed {
    fn into_named(self, path: &Path) -> PyErr;
}

impl IntoNamed for PyErr {
    fn into_named(self, path: &Path) -> PyErr {
        pyo3::exceptions::PyOSError::new_err(format!("{}: {self}", path.display()))
    }
}

impl Profile {
    fn checked(profile: vellus_fit::Profile) -> PyResult<Self> {
        profile.validate().map_err(value)?;
        Ok(Profile(Arc::new(profile)))
    }
}

/// RGB or grey rows.
fn rows<'py>(py: Python<'py>, values: impl Iterator<Item = [f64; 3]>, channels: usize) -> PyResult<Bound<'py, PyAny>> {
    let numbers: Vec<f64> = values.flat_map(|value| value.into_iter().take(channels)).collect();
    let count = numbers.len() / channels;
    Ok(PyArray1::from_vec(py, numbers).reshape([count, channels])?.into_any())
}

/// A fit and its profile.
#[derive(Debug)]
pub struct Fitted {
    pub profile: Arc<vellus_fit::Profile>,
    pub fit: vellus_fit::Fit,
}

impl Fitted {
    pub fn summary(&self) -> Summary<'_> {
        Summary { path: Path::new("profile"), profile: &self.profile, fit: &self.fit }
    }
}

/// The result of `fit`.
#[pyclass(frozen, module = "vellus", name = "Fit")]
#[derive(Debug)]
pub struct Fit(Arc<Fitted>);

#[pymethods]
impl Fit {
    /// The fitted fibre.
    #[getter]
    fn fiber(&self) -> Fiber {
        Fiber(self.0.fit.specimen.fiber)
    }

    /// The profile that it was fitted to.
    #[getter]
    fn profile(&self) -> Profile {
        Profile(self.0.profile.clone())
    }

    /// The name of the model.
    #[getter]
    fn model(&self) -> &'static str {
        self.0.fit.model.name()
    }

    /// Inclination of the fixed direction, degrees.
    #[getter]
    fn theta_o(&self) -> f64 {
        self.0.fit.theta_o
    }

    /// The factor on the values of the model.
    #[getter]
    fn scale(&self) -> f64 {
        self.0.fit.scale
    }

    /// All parameters of the model: name → `Estimate`. Angles are in degrees.
    #[getter]
    fn estimates<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        static CLASS: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
        let class =
            CLASS.get_or_try_init(py, || PyResult::Ok(py.import("vellus._types")?.getattr("Estimate")?.unbind()))?;
        let dict = PyDict::new(py);
        for e in &self.0.fit.estimates {
            let state = match e.state {
                vellus_fit::State::Fitted => "fitted",
                vellus_fit::State::AtBound => "at bound",
                vellus_fit::State::Fixed => "fixed",
                vellus_fit::State::Tied(_) => "tied",
            };
            let unit = if e.unit.is_empty() { "" } else { "degrees" };
            dict.set_item(&e.name, class.bind(py).call1((e.value, e.error, unit, state, e.determined))?)?;
        }
        Ok(dict)
    }

    /// The value of the model for each point of the profile: float64 of shape (N, channels).
    #[getter]
    fn fitted<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        rows(py, self.0.fit.fitted.iter().copied(), self.0.profile.channels)
    }

    /// RMS error divided by the range of the measured values.
    #[getter]
    fn nrmse(&self) -> f64 {
        self.0.fit.nrmse
    }

    /// The same for the logarithms, which the fit minimises.
    #[getter]
    fn log_nrmse(&self) -> f64 {
        self.0.fit.log_nrmse
    }

    /// The reason why the fit says nothing about the fibre, or None if it does.
    #[getter]
    fn no_fit(&self) -> Option<String> {
        self.0.summary().no_fit()
    }

    /// Warnings, one sentence each.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.0.summary().warnings()
    }

    /// Everything as JSON.
    fn to_json(&self) -> String {
        self.0.summary().json().to_string()
    }

    /// A picture of measured and fitted values. `kind`: `profile` for all directions and their ratio, `slices` for
    /// curves.
    #[pyo3(signature = (kind = "profile"))]
    fn plot(&self, kind: &str) -> PyResult<Plot> {
        match kind {
            "profile" => Ok(Plot(Drawing::FitProfile(self.0.clone()))),
            "slices" => Ok(Plot(Drawing::FitSlices(self.0.clone()))),
            _ => Err(PyValueError::new_err(format!("kind = '{kind}' is unknown: known are profile, slices"))),
        }
    }

    fn __str__(&self) -> String {
        self.0.summary().table()
    }

    fn __repr__(&self) -> PyResult<String> {
        Ok(format!("<Fit: {}, NRMSE {:.2} %>", self.fiber().text()?, 100.0 * self.nrmse()))
    }
}

/// Fits the parameters of a model to a profile, with standard errors.
///
/// `profile`: a `Profile`. `model`: `vellus`, `yan2015`, `chiang2016` or `marschner2003`. `starts`: descents from
/// different fibres, at least 1. `seed`: of these fibres. `huber`: residuals above so many times the noise count for
/// less, at least 1. `exit`: `open` or `reflecting`; without it, that of the model. `fix`: name → value, or a sequence
/// of one value for each channel, angles in degrees. `tie`: name → name whose value it gets. `free`: names to fit that
/// are usually fixed. `progress(done, what)` gets reports, `done` in [0, 1].
///
/// Raises `ValueError` for an argument out of range, or a profile that cannot be fitted. Ctrl-C ends the fit.
#[pyfunction]
#[pyo3(signature = (profile, *, model = "vellus", starts = 64, seed = 1, huber = 4.0, exit = None, fix = None,
    tie = None, free = None, progress = None))]
fn fit(
    py: Python<'_>,
    profile: &Bound<'_, Profile>,
    model: &str,
    starts: i128,
    seed: i128,
    huber: f64,
    exit: Option<&str>,
    fix: Option<&Bound<'_, PyDict>>,
    tie: Option<&Bound<'_, PyDict>>,
    free: Option<Vec<String>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Fit> {
    let (starts, seed) = (whole("starts", starts, 1..=100_000)?, checks::seed(seed)?);
    if huber.is_nan() || huber < 1.0 {
        return Err(PyValueError::new_err(format!("huber = {huber} is out of range: it must be at least 1")));
    }
    let exit = exit.map(|exit| exit.parse().map_err(value)).transpose()?;
    let kind: ModelKind = model.parse().map_err(value)?;
    let forward = Forward::new(kind).map_err(value)?;
    let mut options = Options { starts, seed, huber, exit, ..Options::default() };
    for (name, given) in fix.into_iter().flatten() {
        let name: String = name.extract()?;
        let numbers = fiber::numbers(&name, &given)?.into_iter().map(fiber::shortest).collect();
        options.requests.fix.push((name.parse().map_err(value)?, numbers));
    }
    for (name, leader) in tie.into_iter().flatten() {
        let [name, leader]: [String; 2] = [name.extract()?, leader.extract()?];
        options.requests.tie.push((name.parse().map_err(value)?, leader.parse().map_err(value)?));
    }
    for name in free.into_iter().flatten() {
        options.requests.free.push(name.parse().map_err(value)?);
    }
    let profile = profile.get().0.clone();
    let fit = threads::run_reporting(py, progress, |watch| vellus_fit::fit(&profile, forward, &options, watch))?;
    Ok(Fit(Arc::new(Fitted { profile, fit: fit.map_err(value)? })))
}

/// Adds the classes and the function of this file.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Profile>()?;
    module.add_class::<Fit>()?;
    module.add_function(wrap_pyfunction!(fit, module)?)
}
