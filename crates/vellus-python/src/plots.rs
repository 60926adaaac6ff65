//! Pictures: of lobes, profiles, energies, models and fits.

use crate::checks::within;
use crate::error::value;
use crate::fiber;
use crate::fit::Fitted;
use crate::threads;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyString};
use std::path::PathBuf;
use std::sync::Arc;
use vellus_models::ModelKind;
use vellus_plot::fit::{Profiles, Slices};
use vellus_plot::{Draw, Named, energy, lobes, models, profile, windows};

/// The data of a picture.
pub enum Drawing {
    Lobes(lobes::Picture),
    Profile(profile::Picture),
    Energy(energy::Picture),
    Models(models::Picture),
    Windows(windows::Picture),
    /// A fit, and the index of its profile.
    FitProfile(Arc<Fitted>, usize),
    FitSlices(Arc<Fitted>, usize),
}

/// A picture. Notebooks show it.
#[pyclass(frozen, module = "vellus.plots", name = "Plot")]
pub struct Plot(pub Drawing);

/// What to do with a picture.
trait Use {
    type Result;
    fn with(self, picture: &impl Draw) -> vellus_plot::Result<Self::Result>;
}

struct Png;
struct Svg;
struct Save(PathBuf);
struct Size;

impl Use for Png {
    type Result = Vec<u8>;
    fn with(self, picture: &impl Draw) -> vellus_plot::Result<Vec<u8>> {
        vellus_plot::png(picture)
    }
}

impl Use for Svg {
    type Result = String;
    fn with(self, picture: &impl Draw) -> vellus_plot::Result<String> {
        vellus_plot::svg(picture)
    }
}

impl Use for Save {
    type Result = ();
    fn with(self, picture: &impl Draw) -> vellus_plot::Result<()> {
        vellus_plot::save(picture, &[self.0])
    }
}

impl Use for Size {
    type Result = (u32, u32);
    fn with(self, picture: &impl Draw) -> vellus_plot::Result<(u32, u32)> {
        Ok(picture.size())
    }
}

impl Plot {
    fn with<U: Use + Send>(&self, py: Python<'_>, to: U) -> PyResult<U::Result>
    where
        U::Result: Send,
    {
        let drawing = &self.0;
        let result = crate::threads::run(py, |_| match drawing {
            Drawing::Lobes(picture) => to.with(picture),
            Drawing::Profile(picture) => to.with(picture),
            Drawing::Energy(picture) => to.with(picture),
            Drawing::Models(picture) => to.with(picture),
            Drawing::Windows(picture) => to.with(picture),
            Drawing::FitProfile(fitted, k) => to.with(&Profiles(&fitted.summary(), *k)),
            Drawing::FitSlices(fitted, k) => to.with(&Slices(&fitted.summary(), *k)),
        })?;
        result.map_err(|e| match e {
            vellus_plot::Error::Write { path, source } => {
                pyo3::exceptions::PyOSError::new_err(format!("{}: {source}", path.display()))
            }
            e => value(e),
        })
    }
}

#[pymethods]
impl Plot {
    /// The bytes of a PNG file.
    #[getter]
    fn png<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &self.with(py, Png)?))
    }

    /// The text of an SVG file.
    #[getter]
    fn svg(&self, py: Python<'_>) -> PyResult<String> {
        self.with(py, Svg)
    }

    /// Width and height, pixels.
    #[getter]
    fn size(&self, py: Python<'_>) -> PyResult<(u32, u32)> {
        self.with(py, Size)
    }

    /// Writes the picture to the file `path`, whose name ends in `.png` or `.svg`.
    ///
    /// Raises `ValueError` for another name, and `OSError` if it cannot be written.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        self.with(py, Save(path))
    }

    /// The picture in a notebook.
    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        self.png(py)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let (width, height) = self.size(py)?;
        Ok(format!("<Plot: {width} x {height} pixels>"))
    }
}

/// A fibre with its name, and models of it.
fn named(given: &Bound<'_, PyAny>, model: &str) -> PyResult<(vellus::Fiber, Named)> {
    let fiber = fiber::argument(given)?;
    let kind: ModelKind = model.parse().map_err(value)?;
    let name = name_of(given);
    Ok((fiber, Named::new(name, kind, kind.model(&fiber).map_err(value)?)))
}

/// The name of a preset, or "fibre".
fn name_of(given: &Bound<'_, PyAny>) -> String {
    given.cast::<PyString>().map_or_else(|_| "fibre".to_owned(), |name| name.to_string())
}

fn in_range(name: &str, x: f64, [low, high]: [f64; 2]) -> PyResult<()> {
    within(name, x, low..=high)
}

const DEGREES: [f64; 2] = [-90.0, 90.0];

/// The azimuthal lobes of one hit, integrated over inclinations.
///
/// `fiber`: a `Fiber` or the name of a preset. `theta_o`: inclination of ω_o, in [-90, 90] degrees. `h`: the offset in
/// [-1, 1]; far-field models ignore it. `model`: one of `vellus.models.NAMES`.
#[pyfunction]
#[pyo3(signature = (fiber, theta_o = 0.0, h = 0.3, *, model = "vellus"))]
fn plot_lobes(py: Python<'_>, fiber: &Bound<'_, PyAny>, theta_o: f64, h: f64, model: &str) -> PyResult<Plot> {
    let (fiber, named) = named(fiber, model)?;
    in_range("theta_o", theta_o, DEGREES)?;
    in_range("h", h, [-1.0, 1.0])?;
    let picture = threads::run(py, |_| lobes::Picture::new(&fiber, &named, theta_o, h))?;
    Ok(Plot(Drawing::Lobes(picture)))
}

/// The far field over θ_i and φ.
///
/// `fiber`: a `Fiber` or the name of a preset. `theta_o`: inclination of ω_o, in [-90, 90] degrees. `theta`, `phi`:
/// first and last angle, degrees. `model`: one of `vellus.models.NAMES`.
#[pyfunction]
#[pyo3(signature = (fiber, theta_o = 0.0, *, theta = [-90.0, 90.0], phi = [0.0, 360.0], model = "vellus"))]
fn plot_profile(
    py: Python<'_>,
    fiber: &Bound<'_, PyAny>,
    theta_o: f64,
    theta: [f64; 2],
    phi: [f64; 2],
    model: &str,
) -> PyResult<Plot> {
    let (_, named) = named(fiber, model)?;
    in_range("theta_o", theta_o, DEGREES)?;
    for (name, [low, high], range) in [("theta", theta, DEGREES), ("phi", phi, [-360.0, 720.0])] {
        in_range(name, low, range)?;
        in_range(name, high, range)?;
        if low >= high {
            return Err(PyValueError::new_err(format!("{name} from {low} to {high} is no range of angles")));
        }
    }
    let area = profile::Area { theta, phi };
    let panel = threads::run(py, |_| profile::Panel::new(&named, theta_o, area))?;
    Ok(Plot(Drawing::Profile(profile::Picture { panels: vec![panel], theta_o })))
}

/// The energies of the lobes over the offset, and over the inclination.
///
/// `fiber`: a `Fiber` or the name of a preset. `theta_o`: inclination of ω_o, in [-90, 90] degrees. `model`: one of
/// `vellus.models.NAMES`.
#[pyfunction]
#[pyo3(signature = (fiber, theta_o = 0.0, *, model = "vellus"))]
fn plot_energy(py: Python<'_>, fiber: &Bound<'_, PyAny>, theta_o: f64, model: &str) -> PyResult<Plot> {
    let (_, named) = named(fiber, model)?;
    in_range("theta_o", theta_o, DEGREES)?;
    Ok(Plot(Drawing::Energy(threads::run(py, |_| energy::Picture::new(&named, theta_o))?)))
}

/// The far fields of several models of one fibre.
///
/// `fiber`: a `Fiber` or the name of a preset. `theta_o`: inclination of ω_o, in [-90, 90] degrees. `models`: names of
/// models, all without it.
#[pyfunction]
#[pyo3(signature = (fiber, theta_o = 0.0, *, models = None))]
fn plot_models(py: Python<'_>, fiber: &Bound<'_, PyAny>, theta_o: f64, models: Option<Vec<String>>) -> PyResult<Plot> {
    let (name, fiber) = (name_of(fiber), fiber::argument(fiber)?);
    in_range("theta_o", theta_o, DEGREES)?;
    if models.as_ref().is_some_and(Vec::is_empty) {
        return Err(PyValueError::new_err("models is empty: it must have at least one name of vellus.models.NAMES"));
    }
    let kinds = ModelKind::list(&models.unwrap_or_else(|| vec!["all".to_owned()])).map_err(value)?;
    let named: Vec<Named> = kinds
        .into_iter()
        .map(|kind| Ok(Named::new(&name, kind, kind.model(&fiber).map_err(value)?)))
        .collect::<PyResult<_>>()?;
    let picture = threads::run(py, |_| models::Picture::new(&name, &named, theta_o))?;
    Ok(Plot(Drawing::Models(picture)))
}

/// The near field, and its average over a window of offsets.
///
/// `fiber`: a `Fiber` or the name of a preset. `window`: its two ends, in [-1, 1]. `theta_o`: inclination of ω_o, in
/// [-90, 90] degrees.
#[pyfunction]
#[pyo3(signature = (fiber, window, theta_o = 0.0))]
fn plot_windows(py: Python<'_>, fiber: &Bound<'_, PyAny>, window: [f64; 2], theta_o: f64) -> PyResult<Plot> {
    let (name, fiber) = (name_of(fiber), fiber::argument(fiber)?);
    in_range("theta_o", theta_o, DEGREES)?;
    window.iter().try_for_each(|h| in_range("window", *h, [-1.0, 1.0]))?;
    let picture = threads::run(py, |_| windows::Picture::new(&name, &fiber, theta_o, window))?;
    Ok(Plot(Drawing::Windows(picture.map_err(value)?)))
}

/// Adds the class and the functions of this file.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Plot>()?;
    module.add_function(wrap_pyfunction!(plot_lobes, module)?)?;
    module.add_function(wrap_pyfunction!(plot_profile, module)?)?;
    module.add_function(wrap_pyfunction!(plot_energy, module)?)?;
    module.add_function(wrap_pyfunction!(plot_models, module)?)?;
    module.add_function(wrap_pyfunction!(plot_windows, module)?)
}
