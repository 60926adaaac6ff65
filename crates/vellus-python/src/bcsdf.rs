//! The model of one fibre, for arrays of queries.

use crate::arrays::{Real, Rows, broadcast};
use crate::error::value;
use crate::fiber::{self, Fiber};
use crate::output::Output;
use crate::query::{Batch, Batches, Of, Task};
use crate::varying::Parameters;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyString, PyTuple};

/// The reflectance model of one fibre (Yan, Jensen and Ramamoorthi 2017), for arrays of queries.
///
/// `fiber`: a `Fiber` or the name of a preset. `fine_windows`: as many segments in each window as the most difficult
/// fibres need; results are more accurate and take up to three times as long.
///
/// Directions are unit vectors in the fibre's frame that point away from the fibre: x runs along it from root to tip,
/// the inclination is theta = asin x, the azimuth phi = atan2(z, y). The offset h in [-1, 1] belongs to ω_o: the
/// surface normal at the hit has the azimuth phi_o - asin h. Values are f·cos θᵢ, and densities are per solid angle.
/// The model is not reciprocal, because h belongs to ω_o. So queries of both directions take `wi` and `wo` by name.
///
/// Arrays are float32 or float64. The model computes in single precision; results are float32 if all arrays are, and
/// float64 otherwise. A query with NaN in any argument gives NaN, and `lobe` -1. Queries run on all cores, without the
/// interpreter's lock, and the results do not depend on the number of threads.
#[pyclass(frozen, module = "vellus", name = "Bcsdf")]
#[derive(Debug)]
pub struct Bcsdf {
    /// Python aligns its objects to 16 bytes, and this needs 32: it must not lie inside of one.
    model: Box<vellus::Bcsdf<'static>>,
    fine: bool,
}

const VECTOR: Option<(usize, &str)> = Some((3, "x, y, z"));
const ENDS: Option<(usize, &str)> = Some((2, "the two ends of the window"));

/// The argument `h` or `window`.
pub enum Where<'py> {
    Offset(Real<'py>),
    Window(Real<'py>),
}

/// Both ends of the far field.
const FAR: [f64; 2] = [-1.0, 1.0];

impl<'py> Where<'py> {
    /// Reads `h` and `window`, of which exactly one must be given.
    pub fn new(h: Option<&Bound<'py, PyAny>>, window: Option<&Bound<'py, PyAny>>) -> PyResult<Self> {
        match (h, window) {
            (Some(h), None) => Real::new(h, "h").map(Where::Offset),
            (None, Some(window)) => match window.cast::<PyString>() {
                Ok(name) if name == "far" => Ok(Where::Window(Real::Pair(FAR))),
                Ok(name) => Err(PyValueError::new_err(format!(
                    "window = '{name}' is unknown: it must be 'far' or an array of offsets"
                ))),
                Err(_) => Real::new(window, "window").map(Where::Window),
            },
            (None, None) => Err(PyTypeError::new_err("h or window is missing: one of them must be given")),
            (Some(_), Some(_)) => Err(PyTypeError::new_err("h and window are both given: only one may be")),
        }
    }

    pub fn real(&self) -> &Real<'py> {
        let (Where::Offset(real) | Where::Window(real)) = self;
        real
    }

    pub fn rows(&self) -> PyResult<Rows<'_>> {
        match self {
            Where::Offset(real) => real.rows("h", None),
            Where::Window(real) => real.rows("window", ENDS),
        }
    }
}

/// The arguments of queries, and the outputs that they need.
pub struct Call<'py> {
    wo: Real<'py>,
    at: Where<'py>,
    query: Option<Real<'py>>,
    parameters: Parameters<'py>,
    task: Task,
    check: bool,
}

impl<'py> Call<'py> {
    pub fn new(
        task: Task,
        query: Option<&Bound<'py, PyAny>>,
        wo: &Bound<'py, PyAny>,
        (h, window): (Option<&Bound<'py, PyAny>>, Option<&Bound<'py, PyAny>>),
        parameters: Option<&Bound<'py, PyAny>>,
        check: bool,
    ) -> PyResult<Self> {
        let name = if task == Task::Sample { "u" } else { "wi" };
        let query = query.map(|query| Real::new(query, name)).transpose()?;
        let parameters = Parameters::new(parameters)?;
        Ok(Call { wo: Real::new(wo, "wo")?, at: Where::new(h, window)?, query, parameters, task, check })
    }

    /// Computes. `parts`: the shape of each result after the leading axes, and its first column; `None` is a column of
    /// integers.
    pub fn run<B: Batch>(
        &self,
        py: Python<'py>,
        model: &Of<'_, B>,
        base: &vellus::Fiber,
        parts: &[(Option<&[usize]>, usize)],
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let mut wo = self.wo.rows("wo", VECTOR)?;
        let mut window = self.at.rows()?;
        let mut query = match (&self.query, self.task) {
            (None, _) => None,
            (Some(u), Task::Sample) if window.width == 1 => Some(u.uniform()?),
            (Some(u), Task::Sample) => Some(u.rows("u", Some((5, "uniform in [0, 1)")))?),
            (Some(wi), _) => Some(wi.rows("wi", VECTOR)?),
        };
        let mut varying = self.parameters.rows(base)?;
        let mut all: Vec<&mut Rows<'_>> = vec![&mut wo, &mut window];
        all.extend(query.as_mut());
        all.extend(varying.rows.iter_mut().map(|(_, rows)| rows));
        let shape = broadcast(&mut all)?;
        let mut given = vec![&self.wo, self.at.real()];
        given.extend(&self.query);
        given.extend(self.parameters.arrays());
        // As in NumPy: plain numbers do not decide, and without any array there is double precision.
        let double = given.iter().any(|real| real.is_double()) || !given.iter().any(|real| real.has_type());
        let outputs: Vec<Output<'py>> = parts
            .iter()
            .map(|(inner, first)| match inner {
                Some(inner) => Output::new(py, &shape, inner, *first, double),
                None => Output::index(py, &shape, *first),
            })
            .collect();
        let varying = (!varying.rows.is_empty()).then_some(varying);
        let batches = Batches { shape, wo, window, query, varying, check: self.check };
        batches.run(py, model, self.task, &outputs)?;
        Ok(outputs.into_iter().map(Output::into_any).collect())
    }
}

/// The shape of values: RGB, or RGB of six lobes.
pub fn inner(lobes: bool) -> &'static [usize] {
    if lobes { &[6, 3] } else { &[3] }
}

/// One result, or several as a tuple.
pub fn unpack<'py>(py: Python<'py>, mut results: Vec<Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
    match results.pop() {
        Some(only) if results.is_empty() => Ok(only),
        last => {
            results.extend(last);
            Ok(PyTuple::new(py, results)?.into_any())
        }
    }
}

impl Bcsdf {
    fn run<'py>(
        &self,
        py: Python<'py>,
        call: &Call<'py>,
        parts: &[(Option<&[usize]>, usize)],
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let remake = |fiber: &vellus::Fiber| {
            let model = vellus::Bcsdf::new(fiber)?;
            Ok(if self.fine { model.with_fine_windows() } else { model })
        };
        call.run(py, &(&*self.model, &remake), self.model.fiber(), parts)
    }
}

#[pymethods]
impl Bcsdf {
    #[new]
    #[pyo3(signature = (fiber, *, fine_windows = false))]
    fn new(fiber: &Bound<'_, PyAny>, fine_windows: bool) -> PyResult<Self> {
        let model = vellus::Bcsdf::new(&fiber::argument(fiber)?).map_err(value)?;
        let model = Box::new(if fine_windows { model.with_fine_windows() } else { model });
        Ok(Bcsdf { model, fine: fine_windows })
    }

    /// The fibre.
    #[getter]
    fn fiber(&self) -> Fiber {
        Fiber(*self.model.fiber())
    }

    /// f(ω_o, ω_i)·cos θᵢ, RGB.
    ///
    /// `wi`: directions toward the light, shape (..., 3).
    /// `wo`: directions that the paths came from (the camera), shape (..., 3). `h`: offsets in [-1, 1], shape (...).
    /// `window`: instead of `h`, the ends of windows of offsets, shape (..., 2), or `far`. All leading shapes are
    /// broadcast. `check`: whether to check lengths and ranges. Without the check, results of bad numbers mean nothing.
    /// `parameters`: parameters of the fibre that differ from query to query, by name: arrays of shape (...), and of
    /// colours (..., 3). They are broadcast, too. Neighbours with the same parameters share the work of a fibre.
    ///
    /// Returns shape (..., 3), or with `lobes` each lobe of `vellus.LOBES`: shape (..., 6, 3).
    /// Raises `ValueError` that names the number and its range, or shapes that do not fit; `TypeError` for a dtype.
    #[pyo3(signature = (*, wi, wo, h = None, window = None, lobes = false, parameters = None, check = true))]
    fn eval<'py>(
        &self,
        py: Python<'py>,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
        h: Option<&Bound<'py, PyAny>>,
        window: Option<&Bound<'py, PyAny>>,
        lobes: bool,
        parameters: Option<&Bound<'py, PyAny>>,
        check: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let call = Call::new(Task::Eval { lobes }, Some(wi), wo, (h, window), parameters, check)?;
        unpack(py, self.run(py, &call, &[(Some(inner(lobes)), 0)])?)
    }

    /// The density per solid angle with which `sample` draws `wi`. Arguments as for `eval`.
    ///
    /// Returns shape (...).
    #[pyo3(signature = (*, wi, wo, h = None, window = None, parameters = None, check = true))]
    fn pdf<'py>(
        &self,
        py: Python<'py>,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
        h: Option<&Bound<'py, PyAny>>,
        window: Option<&Bound<'py, PyAny>>,
        parameters: Option<&Bound<'py, PyAny>>,
        check: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let call = Call::new(Task::Pdf, Some(wi), wo, (h, window), parameters, check)?;
        unpack(py, self.run(py, &call, &[(Some(&[]), 0)])?)
    }

    /// `eval` and `pdf` together, at the cost of one. Arguments as for `eval`.
    ///
    /// Returns both arrays: shapes (..., 3), or (..., 6, 3) with `lobes`, and (...).
    #[pyo3(signature = (*, wi, wo, h = None, window = None, lobes = false, parameters = None, check = true))]
    fn eval_pdf<'py>(
        &self,
        py: Python<'py>,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
        h: Option<&Bound<'py, PyAny>>,
        window: Option<&Bound<'py, PyAny>>,
        lobes: bool,
        parameters: Option<&Bound<'py, PyAny>>,
        check: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let call = Call::new(Task::EvalPdf { lobes }, Some(wi), wo, (h, window), parameters, check)?;
        let pdf = crate::query::colors(lobes);
        unpack(py, self.run(py, &call, &[(Some(inner(lobes)), 0), (Some(&[]), pdf)])?)
    }

    /// Draws directions ω_i.
    ///
    /// `u`: uniform numbers in [0, 1), shape (..., 5). The near field does not use the last, and takes (..., 4) too.
    /// `wo`: directions that the paths came from (the camera), shape (..., 3). `h`: offsets in [-1, 1], shape (...).
    /// `window`: instead of `h`, the ends of windows of offsets, shape (..., 2), or `far`. All leading shapes are
    /// broadcast. `check`: whether to check lengths and ranges. Without the check, results of bad numbers mean nothing.
    /// `parameters`: parameters of the fibre that differ from query to query, by name: arrays of shape (...), and of
    /// colours (..., 3). They are broadcast, too. Neighbours with the same parameters share the work of a fibre.
    ///
    /// Returns `Samples`: `wi` (..., 3), `pdf` (...), `weight` (..., 3) and `lobe` (...). Where the density underflows,
    /// nothing is drawn: `wi`, `pdf` and `weight` are 0, and `lobe` is -1.
    #[pyo3(signature = (wo, u, h = None, *, window = None, parameters = None, check = true))]
    fn sample<'py>(
        &self,
        py: Python<'py>,
        wo: &Bound<'py, PyAny>,
        u: &Bound<'py, PyAny>,
        h: Option<&Bound<'py, PyAny>>,
        window: Option<&Bound<'py, PyAny>>,
        parameters: Option<&Bound<'py, PyAny>>,
        check: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let call = Call::new(Task::Sample, Some(u), wo, (h, window), parameters, check)?;
        let results = self.run(py, &call, SAMPLE)?;
        samples(py)?.call1(PyTuple::new(py, results)?)
    }

    /// The share of the light that the fibre scatters, RGB, in [0, 1]: the integral of f·cos θᵢ over all ω_i.
    ///
    /// `wo`: directions that the paths came from (the camera), shape (..., 3). `h`: offsets in [-1, 1], shape (...).
    /// `window`: instead of `h`, the ends of windows of offsets, shape (..., 2), or `far`. All leading shapes are
    /// broadcast. `check`: whether to check lengths and ranges. Without the check, results of bad numbers mean nothing.
    /// `parameters`: parameters of the fibre that differ from query to query, by name: arrays of shape (...), and of
    /// colours (..., 3). They are broadcast, too. Neighbours with the same parameters share the work of a fibre.
    ///
    /// Returns shape (..., 3), or with `lobes` each lobe of `vellus.LOBES`: shape (..., 6, 3).
    #[pyo3(signature = (wo, h = None, *, window = None, lobes = false, parameters = None, check = true))]
    fn energy<'py>(
        &self,
        py: Python<'py>,
        wo: &Bound<'py, PyAny>,
        h: Option<&Bound<'py, PyAny>>,
        window: Option<&Bound<'py, PyAny>>,
        lobes: bool,
        parameters: Option<&Bound<'py, PyAny>>,
        check: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let call = Call::new(Task::Energy { lobes }, None, wo, (h, window), parameters, check)?;
        unpack(py, self.run(py, &call, &[(Some(inner(lobes)), 0)])?)
    }

    fn __repr__(&self) -> PyResult<String> {
        let fine = if self.fine { ", fine_windows=True" } else { "" };
        Ok(format!("Bcsdf({}{fine})", self.fiber().text()?))
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        let same = |other: &Bcsdf| self.model.fiber() == other.model.fiber() && self.fine == other.fine;
        other.cast::<Bcsdf>().is_ok_and(|other| same(other.get()))
    }

    fn __hash__(&self) -> u64 {
        self.fiber().hash() ^ u64::from(self.fine)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (Fiber, bool))> {
        Ok((slf.get_type().getattr("_from_state")?, (slf.get().fiber(), slf.get().fine)))
    }

    #[staticmethod]
    fn _from_state(fiber: &Bound<'_, PyAny>, fine: bool) -> PyResult<Self> {
        Bcsdf::new(fiber, fine)
    }
}

/// The results of a sample: direction, density, weight, lobe.
pub const SAMPLE: &[(Option<&[usize]>, usize)] = &[(Some(&[3]), 0), (Some(&[]), 3), (Some(&[3]), 4), (None, 7)];

/// The named tuple `vellus.Samples`.
pub fn samples(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    static SAMPLES: pyo3::sync::PyOnceLock<Py<PyAny>> = pyo3::sync::PyOnceLock::new();
    let class =
        SAMPLES.get_or_try_init(py, || PyResult::Ok(py.import("vellus._types")?.getattr("Samples")?.unbind()))?;
    Ok(class.bind(py).clone())
}
