//! Fits of a fibre to measured profiles.

use crate::checks::{self, whole};
use crate::error::value;
use crate::fiber::{self, Fiber};
use crate::plots::{Drawing, Plot};
use crate::profile::{Profile, rows};
use crate::threads;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::Arc;
use vellus_fit::{Forward, Options, Part};
use vellus_models::ModelKind;
use vellus_plot::fit::{Measured, Summary};

/// A profile and its name in messages.
type Given = (PathBuf, Arc<vellus_fit::Profile>);

/// A fit and its profiles.
#[derive(Debug)]
pub struct Fitted {
    profiles: Vec<Given>,
    fit: vellus_fit::Fit,
}

impl Fitted {
    pub fn summary(&self) -> Summary<'_> {
        let measured = self.profiles.iter().map(|(path, profile)| Measured { path, profile });
        Summary { measured: measured.collect(), fit: &self.fit }
    }

    /// The result for the first profile.
    fn first(&self) -> &Part {
        &self.fit.parts[0]
    }
}

/// A class of `vellus._types`, looked up once.
fn class<'py>(py: Python<'py>, cell: &'static PyOnceLock<Py<PyAny>>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    let class = cell.get_or_try_init(py, || PyResult::Ok(py.import("vellus._types")?.getattr(name)?.unbind()))?;
    Ok(class.bind(py).clone())
}

/// The result of `fit`.
#[pyclass(frozen, module = "vellus", name = "Fit")]
#[derive(Debug)]
pub struct Fit(Arc<Fitted>);

#[pymethods]
impl Fit {
    /// The fitted fibre, that of the first profile.
    #[getter]
    fn fiber(&self) -> Fiber {
        Fiber(self.0.fit.specimen.fiber)
    }

    /// The profile that it was fitted to, the first of several.
    #[getter]
    fn profile(&self) -> Profile {
        Profile(self.0.profiles[0].1.clone())
    }

    /// The profiles that it was fitted to.
    #[getter]
    fn profiles(&self) -> Vec<Profile> {
        self.0.profiles.iter().map(|(_, profile)| Profile(profile.clone())).collect()
    }

    /// The result for each profile: a list of `FitPart`.
    #[getter]
    fn parts<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        static CLASS: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
        let class = class(py, &CLASS, "FitPart")?;
        let part = |(part, (_, profile)): (&Part, &Given)| {
            let Part { specimen, theta_o, scale, background, fitted, nrmse, log_nrmse } = part;
            let fitted = rows(py, fitted.iter().copied(), profile.channels)?;
            class.call1((Fiber(specimen.fiber), *theta_o, *scale, *background, fitted, *nrmse, *log_nrmse))
        };
        self.0.fit.parts.iter().zip(&self.0.profiles).map(part).collect()
    }

    /// The name of the model.
    #[getter]
    fn model(&self) -> &'static str {
        self.0.fit.model.name()
    }

    /// Inclination of the fixed direction of the first profile, degrees.
    #[getter]
    fn theta_o(&self) -> f64 {
        self.0.first().theta_o
    }

    /// The factor on the values of the model, for the first profile.
    #[getter]
    fn scale(&self) -> f64 {
        self.0.first().scale
    }

    /// All parameters of the model: name → `Estimate`. Angles are in degrees. If several profiles have values of their
    /// own, the names end in their numbers from 1 on: `scale[2]`.
    #[getter]
    fn estimates<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        static CLASS: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
        let class = class(py, &CLASS, "Estimate")?;
        let dict = PyDict::new(py);
        for e in &self.0.fit.estimates {
            let state = match e.state {
                vellus_fit::State::Fitted => "fitted",
                vellus_fit::State::AtBound => "at bound",
                vellus_fit::State::Fixed => "fixed",
                vellus_fit::State::Tied(_) => "tied",
            };
            let unit = if e.unit.is_empty() { "" } else { "degrees" };
            let interval = e.interval.map(|[low, high]| (low, high));
            dict.set_item(&e.name, class.call1((e.value, e.error, interval, unit, state, e.determined))?)?;
        }
        Ok(dict)
    }

    /// The value of the model for each point of the first profile: float64 of shape (N, channels).
    #[getter]
    fn fitted<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        rows(py, self.0.first().fitted.iter().copied(), self.0.profiles[0].1.channels)
    }

    /// RMS error divided by the range of the measured values, for all profiles together.
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
    /// curves. `profile`: the index of the profile.
    ///
    /// Raises `ValueError` for another kind, or an index that does not exist.
    #[pyo3(signature = (kind = "profile", profile = 0))]
    fn plot(&self, kind: &str, profile: i128) -> PyResult<Plot> {
        let index = whole("profile", profile, 0..=self.0.profiles.len() - 1)?;
        match kind {
            "profile" => Ok(Plot(Drawing::FitProfile(self.0.clone(), index))),
            "slices" => Ok(Plot(Drawing::FitSlices(self.0.clone(), index))),
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

/// The profiles of the argument `profile`.
fn profiles(argument: &Bound<'_, PyAny>) -> PyResult<Vec<Given>> {
    if let Ok(one) = argument.cast::<Profile>() {
        return Ok(vec![(PathBuf::from("profile"), one.get().0.clone())]);
    }
    let wrong = |found: &Bound<'_, PyAny>| {
        PyTypeError::new_err(format!("profile must be a Profile or several of them, not {}", found.get_type()))
    };
    let mut all = Vec::new();
    for item in argument.try_iter().map_err(|_| wrong(argument))? {
        let item = item?;
        let profile = item.cast::<Profile>().map_err(|_| wrong(&item))?;
        all.push((PathBuf::from(format!("profile {}", all.len() + 1)), profile.get().0.clone()));
    }
    if all.is_empty() {
        return Err(PyValueError::new_err("profile is empty: it must have at least one Profile"));
    }
    Ok(all)
}

/// Fits the parameters of a model to one profile or more, with standard errors and intervals.
///
/// `profile`: a `Profile`, or several of the same fibre, which are fitted together. Each then has its own scale, θ_o
/// and background. Channels of a measurement (`Profile.channel`) share these, and each has its own absorption. `model`:
/// `vellus`, `yan2015`, `chiang2016` or `marschner2003`. `starts`: descents from different fibres, at least 1. `seed`:
/// of these fibres. `huber`: residuals above this many times the noise count for less, at least 1. `exit`: `open` or
/// `reflecting`; without it, that of the model. `fix`: name → value, or a sequence of one value for each channel,
/// angles in degrees. `tie`: name → name whose value it gets. `free`: names to fit that are usually fixed: `theta_o`,
/// `medulla_air` and `background`. `separate`: names of parameters of the fibre that each profile has for itself,
/// such as `sigma_ca` at several wavelengths. `share`: names of `scale`, `theta_o` and `background` that all profiles
/// have in common.
/// `progress(done, what)` gets reports, `done` in [0, 1].
///
/// Raises `ValueError` for an argument out of range, or a profile that cannot be fitted. Ctrl-C ends the fit.
#[pyfunction]
#[pyo3(signature = (profile, *, model = "vellus", starts = 64, seed = 1, huber = 4.0, exit = None, fix = None,
    tie = None, free = None, separate = None, share = None, progress = None))]
fn fit(
    py: Python<'_>,
    profile: &Bound<'_, PyAny>,
    model: &str,
    starts: i128,
    seed: i128,
    huber: f64,
    exit: Option<&str>,
    fix: Option<&Bound<'_, PyDict>>,
    tie: Option<&Bound<'_, PyDict>>,
    free: Option<Vec<String>>,
    separate: Option<Vec<String>>,
    share: Option<Vec<String>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Fit> {
    let profiles = profiles(profile)?;
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
    let requests = &mut options.requests;
    for (names, list) in [(free, &mut requests.free), (separate, &mut requests.separate), (share, &mut requests.share)]
    {
        for name in names.into_iter().flatten() {
            list.push(name.parse().map_err(value)?);
        }
    }
    let all: Vec<_> = profiles.iter().map(|(_, profile)| vellus_fit::Profile::clone(profile)).collect();
    let fit = threads::run_reporting(py, progress, |watch| vellus_fit::fit(&all, forward, &options, watch))?;
    Ok(Fit(Arc::new(Fitted { profiles, fit: fit.map_err(value)? })))
}

/// Adds the class and the function of this file.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Fit>()?;
    module.add_function(wrap_pyfunction!(fit, module)?)
}
