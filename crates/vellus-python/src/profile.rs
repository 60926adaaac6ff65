//! Measured profiles.

use crate::arrays::{Real, Rows, broadcast};
use crate::checks::{self, out_of_range};
use crate::error::{value, with_causes};
use crate::fiber;
use crate::simulate;
use crate::threads;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use vellus_fit::simulate::Source;
use vellus_fit::{Forward, Point, Quantity, Reading, Synthetic};
use vellus_models::ModelKind;

/// Light scattered by one fibre, averaged over its width, between one fixed direction and many others.
///
/// `theta`, `phi`: the directions, degrees: θ in (-90, 90) from the normal plane, φ from the azimuth of the fixed
/// direction. `values`: RGB with a last axis of 3, or grey without it, in any unit. The leading shapes of all three are
/// broadcast, so a grid is `theta[:, None], phi[None, :], values`. A value of NaN or 0 is missing. `theta_o`:
/// inclination of the fixed direction, in (-90, 90) degrees. `sigma`: the standard deviation of each value, above 0, in
/// the same unit and broadcast like `values`. `blur`: full width of the cell over which each value is an average, in
/// [0, 30] degrees: one number for θ and φ, or two; 0 without it. `quantity`: `f-cos` if values are proportional to
/// f·cos θ, or `f`. `channels`: 1 or 3; without it, 3 if the last axis of `values` has 3 numbers that `theta` and `phi`
/// lack. `channel`: the name of the channel, such as a wavelength, if grey values are one of several channels of a
/// measurement. A fit then gives each its own absorption.
///
/// Raises `ValueError` for an angle or value out of range.
#[pyclass(frozen, module = "vellus", name = "Profile")]
#[derive(Clone, Debug)]
pub struct Profile(pub Arc<vellus_fit::Profile>);

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

/// The argument `blur`: the widths of a cell over θ and φ.
fn widths(given: Option<&Bound<'_, PyAny>>) -> PyResult<Option<[f64; 2]>> {
    let Some(given) = given else { return Ok(None) };
    let widths = Real::new(given, "blur")?.doubles();
    match widths[..] {
        [both] => Ok(Some([both; 2])),
        [theta, phi] => Ok(Some([theta, phi])),
        _ => Err(PyValueError::new_err(format!("blur has {} numbers: it must have one or two", widths.len()))),
    }
}

/// The arguments of readers.
fn reading(
    theta_o: Option<f64>,
    angles: Option<&str>,
    quantity: Option<&str>,
    axes: Option<[vellus_fit::Axis; 2]>,
    blur: Option<&Bound<'_, PyAny>>,
) -> PyResult<Reading> {
    let angles = angles
        .map(|name| name.parse().map_err(|e| PyValueError::new_err(format!("angles = '{name}': {e}"))))
        .transpose()?;
    Ok(Reading { theta_o, angles, quantity: self::quantity(quantity)?, axes, blur: widths(blur)? })
}

/// What pickle keeps: points, their standard deviations, missing directions, how many of these are negative, what was
/// simulated, theta_o, quantity, channels, the name of the channel and blur.
type State = (
    Vec<[f64; 5]>,
    Option<Vec<[f64; 3]>>,
    Vec<[f64; 2]>,
    usize,
    Vec<(String, f64)>,
    f64,
    String,
    usize,
    String,
    [f64; 2],
);

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
    #[pyo3(signature = (theta, phi, values, *, theta_o, sigma = None, blur = None, quantity = None, channels = None,
        channel = ""))]
    fn new(
        theta: &Bound<'_, PyAny>,
        phi: &Bound<'_, PyAny>,
        values: &Bound<'_, PyAny>,
        theta_o: f64,
        sigma: Option<&Bound<'_, PyAny>>,
        blur: Option<&Bound<'_, PyAny>>,
        quantity: Option<&str>,
        channels: Option<i128>,
        channel: &str,
    ) -> PyResult<Self> {
        let [theta, phi, values] =
            [(theta, "theta"), (phi, "phi"), (values, "values")].map(|(given, name)| Real::new(given, name));
        let (theta, phi, values) = (theta?, phi?, values?);
        let sigma = sigma.map(|given| Real::new(given, "sigma")).transpose()?;
        let axes = theta.shape().len().max(phi.shape().len());
        let channels = match channels {
            Some(n) => grey_or_rgb(n)?,
            None if values.shape().len() > axes && values.shape().last() == Some(&3) => 3,
            None => 1,
        };
        let rgb = (channels == 3).then_some((3, "red, green, blue"));
        let (mut t, mut p, mut v) = (theta.rows("theta", None)?, phi.rows("phi", None)?, values.rows("values", rgb)?);
        let mut s = sigma.as_ref().map(|sigma| sigma.rows("sigma", rgb)).transpose()?;
        let mut arguments = vec![&mut t, &mut p, &mut v];
        arguments.extend(s.as_mut());
        let shape = broadcast(&mut arguments)?;
        let sigmas = s.as_ref().zip(sigma.as_ref()).map(|(rows, real)| all(rows, real, &shape));
        let (mut points, mut missing) = (Vec::new(), Vec::new());
        let angles = all(&t, &theta, &shape).into_iter().zip(all(&p, &phi, &shape));
        for (i, ((t, p), v)) in angles.zip(all(&v, &values, &shape)).enumerate() {
            let (theta, phi) = (t[0], p[0]);
            if v.iter().any(|x| x.is_nan() || *x == 0.0) {
                missing.push([theta, phi]);
            } else {
                let three = |v: &[f64]| -> [f64; 3] { std::array::from_fn(|c| v[c % channels]) };
                let sigma = sigmas.as_ref().map(|sigmas| three(&sigmas[i]));
                points.push(Point { theta, phi, value: three(&v), sigma });
            }
        }
        let quantity = self::quantity(quantity)?.unwrap_or_default();
        let blur = widths(blur)?.unwrap_or_default();
        let (channel, negative, simulated) = (channel.to_owned(), 0, Vec::new());
        Profile::checked(vellus_fit::Profile {
            theta_o,
            quantity,
            channels,
            channel,
            blur,
            points,
            missing,
            negative,
            simulated,
        })
    }

    /// Reads a profile from the file `path`: `.txt`, `.csv`, `.npy` or `.exr`, as the book says in "Fitting".
    ///
    /// `theta_o`: inclination of the fixed direction, degrees, if the file does not have it. `angles`: `fiber` or
    /// `gantry`. `quantity`: `f-cos` or `f`. `theta`, `phi`: first and last angle of the rows and columns of an image.
    /// `blur`: as for `Profile`, if the file does not have it.
    ///
    /// Raises `FileNotFoundError` or `PermissionError` for a file that cannot be opened, and `ValueError` that names
    /// the file, the line and the problem.
    #[staticmethod]
    #[pyo3(signature = (path, *, theta_o = None, angles = None, quantity = None, theta = None, phi = None,
        blur = None))]
    fn read(
        path: PathBuf,
        theta_o: Option<f64>,
        angles: Option<&str>,
        quantity: Option<&str>,
        theta: Option<[f64; 2]>,
        phi: Option<[f64; 2]>,
        blur: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let axis = |[first, last]: [f64; 2]| vellus_fit::Axis { first, last };
        let axes = match (theta, phi) {
            (Some(theta), Some(phi)) => Some([axis(theta), axis(phi)]),
            (None, None) => None,
            _ => return Err(PyTypeError::new_err("theta and phi must be given together")),
        };
        let reading = reading(theta_o, angles, quantity, axes, blur)?;
        vellus_fit::read(&path, &reading).map(|profile| Profile(Arc::new(profile))).map_err(|e| with_causes(&e))
    }

    /// Reads the profiles of all channels of the CSV file `path`: a list with a grey `Profile` for each column
    /// `value_NAME`. `fit` takes the list. Arguments as for `read`.
    ///
    /// Raises what `read` raises.
    #[staticmethod]
    #[pyo3(signature = (path, *, theta_o = None, angles = None, quantity = None, blur = None))]
    fn read_channels(
        path: PathBuf,
        theta_o: Option<f64>,
        angles: Option<&str>,
        quantity: Option<&str>,
        blur: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Vec<Self>> {
        let reading = reading(theta_o, angles, quantity, None, blur)?;
        let profiles = vellus_fit::read_channels(&path, &reading).map_err(|e| with_causes(&e))?;
        Ok(profiles.into_iter().map(|profile| Profile(Arc::new(profile))).collect())
    }

    /// Makes a synthetic measurement of a fibre, for tests and examples.
    ///
    /// `fiber`: a `Fiber` or the name of a preset. `theta_o`: inclination of the fixed direction, -30 without it.
    /// `theta`, `phi`: first and last angle; 10 to 50 and -20 to 200 without them. `step`: steps over theta and
    /// phi, 2 degrees without it. `noise`: standard deviation of
    /// the logarithm of each value, in [0, 1]. `gaps`: share of missing directions, in [0, 0.9]. `scale`: factor on the
    /// values. `background`: what is then added to them, at least 0. `blur`: as for `Profile`; without it, a traced
    /// fibre has cells of the size of `step`. `channels`: 1 or 3. `seed`: another seed gives other noise. `photons`:
    /// traces a whole fibre with this many photons, in [2, 1e11], instead of a model. `model`: `vellus`, `yan2015`,
    /// `chiang2016` or `marschner2003`. `progress(done, what)` gets reports.
    ///
    /// Raises `ValueError` for an argument out of range.
    #[staticmethod]
    #[pyo3(signature = (fiber, *, theta_o = -30.0, theta = [10.0, 50.0], phi = [-20.0, 200.0], step = [2.0, 2.0],
        noise = 0.02, gaps = 0.1, scale = 1.0, background = 0.0, blur = None, channels = 1, seed = 1, photons = None,
        model = "vellus", progress = None))]
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
        background: f64,
        blur: Option<&Bound<'_, PyAny>>,
        channels: i128,
        seed: i128,
        photons: Option<i128>,
        model: &str,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let fiber = fiber::argument(fiber)?;
        fiber.validate().map_err(value)?;
        let (channels, seed) = (grey_or_rgb(channels)?, checks::seed(seed)?);
        let blur = widths(blur)?;
        if photons.is_some() && blur.is_some() {
            let text = "blur is only for models: a traced fibre has cells of the size of step";
            return Err(PyValueError::new_err(text));
        }
        let blur = blur.unwrap_or_default();
        let gantry = Synthetic { theta_o, theta, phi, step, noise, gaps, scale, background, blur, channels, seed };
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

    /// The name of the channel of grey values that are one of several channels, or an empty text.
    #[getter]
    fn channel(&self) -> &str {
        &self.0.channel
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

    /// The standard deviations of the values: float64 of shape (N, channels). None if they are not known.
    #[getter]
    fn sigma<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        sigmas(&self.0).map(|sigmas| rows(py, sigmas.into_iter(), self.0.channels)).transpose()
    }

    /// Full widths over θ and φ of the cell over which each value is an average, degrees.
    #[getter]
    fn blur(&self) -> (f64, f64) {
        self.0.blur.into()
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

    /// The profile as CSV, with the columns theta, phi, and value or r, g, b; with standard deviations also sigma, or
    /// sigma_r, sigma_g, sigma_b.
    fn to_csv(&self) -> String {
        vellus_fit::csv(&self.0, &[])
    }

    /// Writes the profile to the file `path`: `.txt` in the coordinates of a gantry and without `sigma`, or `.csv`.
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
        let color = match (p.channel.as_str(), p.channels) {
            ("", 1) => "grey".to_owned(),
            ("", _) => "RGB".to_owned(),
            (name, _) => format!("channel {name}"),
        };
        let (count, missing) = (p.points.len(), p.missing.len());
        format!("<Profile: {count} directions, {missing} missing, {color}, theta_o={}>", p.theta_o)
    }

    /// For pickle.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (State,))> {
        let p = &slf.get().0;
        let points = p.points.iter().map(|p| [p.theta, p.phi, p.value[0], p.value[1], p.value[2]]).collect();
        let (missing, simulated) = (p.missing.clone(), p.simulated.clone());
        let quantity = p.quantity.name().to_owned();
        let (sigmas, channel) = (sigmas(p), p.channel.clone());
        let state = (points, sigmas, missing, p.negative, simulated, p.theta_o, quantity, p.channels, channel, p.blur);
        Ok((slf.get_type().getattr("_from_state")?, (state,)))
    }

    #[staticmethod]
    fn _from_state(state: State) -> PyResult<Self> {
        let (points, sigmas, missing, negative, simulated, theta_o, quantity, channels, channel, blur) = state;
        let point = |(i, [theta, phi, r, g, b]): (usize, [f64; 5])| {
            let sigma = sigmas.as_ref().and_then(|sigmas| sigmas.get(i).copied());
            Point { theta, phi, value: [r, g, b], sigma }
        };
        let points = points.into_iter().enumerate().map(point).collect();
        let quantity = quantity.parse().map_err(value)?;
        let channels = if channels == 1 { 1 } else { 3 };
        Profile::checked(vellus_fit::Profile {
            theta_o,
            quantity,
            channels,
            channel,
            blur,
            points,
            missing,
            negative,
            simulated,
        })
    }
}

/// The standard deviations of all values.
fn sigmas(profile: &vellus_fit::Profile) -> Option<Vec<[f64; 3]>> {
    profile.points.iter().map(|p| p.sigma).collect()
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
pub fn rows<'py>(
    py: Python<'py>,
    values: impl Iterator<Item = [f64; 3]>,
    channels: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let numbers: Vec<f64> = values.flat_map(|value| value.into_iter().take(channels)).collect();
    let count = numbers.len() / channels;
    Ok(PyArray1::from_vec(py, numbers).reshape([count, channels])?.into_any())
}
