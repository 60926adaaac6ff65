//! The earlier models, by name.

use crate::bcsdf::{Call, SAMPLE, inner, samples, unpack};
use crate::error::value;
use crate::fiber::{self, Fiber};
use crate::query::{Batch, Task, colors};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use vellus::glam::Vec3;
use vellus::wide::f32x8;
use vellus::{Lobes, Sample, Scattering, Window, WindowSupport};
use vellus_models::{AnyHit, AnyModel, ModelKind};

/// A reflectance model of one fibre, by name. It has the methods of `Bcsdf`.
///
/// `name`: one of `vellus.models.NAMES`. Case and the year do not matter. `fiber`: a `Fiber` or the name of a preset.
/// A model ignores the parameters that it does not have.
///
/// A near-field model uses the middle of a window. A far-field model ignores `h` and `window`.
#[pyclass(frozen, module = "vellus.models", name = "Model")]
#[derive(Debug)]
pub struct Model {
    kind: ModelKind,
    fiber: vellus::Fiber,
    /// Python aligns its objects to 16 bytes, and this needs 32: it must not lie inside of one.
    pub model: Box<AnyModel>,
}

impl Batch for AnyModel {
    type Hit8<'a> = [AnyHit<'a>; 8];

    fn at8(&self, wo: [f32x8; 3], h: f32x8) -> [AnyHit<'_>; 8] {
        let ([x, y, z], h) = (wo.map(f32x8::to_array), h.to_array());
        std::array::from_fn(|i| vellus::Model::at(self, Vec3::new(x[i], y[i], z[i]), Window::near(h[i])))
    }

    fn eval8(hits: &[AnyHit<'_>; 8], wi: [f32x8; 3]) -> (Lobes<f32x8>, f32x8) {
        each(wi, |i, wi| hits[i].eval_pdf(wi))
    }

    fn energy8(hits: &[AnyHit<'_>; 8]) -> Lobes<f32x8> {
        each([f32x8::ZERO; 3], |i, _| (hits[i].energy(), 0.0)).0
    }

    fn sample8(hits: &[AnyHit<'_>; 8], u: [f32x8; 5]) -> [Option<Sample>; 8] {
        let u = u.map(f32x8::to_array);
        std::array::from_fn(|i| hits[i].sample(u.map(|u| u[i])))
    }

    fn eval8_of(hit: &AnyHit<'_>, wi: [f32x8; 3]) -> (Lobes<f32x8>, f32x8) {
        each(wi, |_, wi| hit.eval_pdf(wi))
    }
}

/// Eight queries, one after the other.
fn each(wi: [f32x8; 3], eval: impl Fn(usize, Vec3) -> (Lobes, f32)) -> (Lobes<f32x8>, f32x8) {
    let [x, y, z] = wi.map(f32x8::to_array);
    let (mut lobes, mut densities) = ([[[0.0; 8]; 3]; 6], [0.0; 8]);
    for i in 0..8 {
        let (f, pdf) = eval(i, Vec3::new(x[i], y[i], z[i]));
        densities[i] = pdf;
        for (lobe, f) in lobes.iter_mut().zip(f.0) {
            (0..3).for_each(|c| lobe[c][i] = f[c]);
        }
    }
    (Lobes(lobes.map(|lobe| lobe.map(f32x8::new))), f32x8::new(densities))
}

impl Model {
    fn run<'py>(
        &self,
        py: Python<'py>,
        call: &Call<'py>,
        parts: &[(Option<&[usize]>, usize)],
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let remake = |fiber: &vellus::Fiber| vellus::Model::with_fiber(&*self.model, fiber);
        call.run(py, &(&*self.model, &remake), &self.fiber, parts)
    }
}

#[pymethods]
impl Model {
    #[new]
    #[pyo3(signature = (name, fiber))]
    fn new(name: &str, fiber: &Bound<'_, PyAny>) -> PyResult<Self> {
        Model::of(name.parse().map_err(value)?, fiber::argument(fiber)?)
    }

    /// The name of the model.
    #[getter]
    fn name(&self) -> &'static str {
        self.kind.name()
    }

    /// The fibre.
    #[getter]
    fn fiber(&self) -> Fiber {
        Fiber(self.fiber)
    }

    /// The windows that the model supports: `near`, `far` or `any`.
    #[getter]
    fn field(&self) -> &'static str {
        match vellus::Model::field(&*self.model) {
            WindowSupport::Near => "near",
            WindowSupport::Far => "far",
            WindowSupport::Any => "any",
        }
    }

    /// f(ω_o, ω_i)·cos θᵢ, shape (..., 3), or (..., 6, 3) with `lobes`. Arguments as for `Bcsdf.eval`.
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

    /// The density of samples per solid angle, shape (...). Arguments as for `Bcsdf.eval`.
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

    /// Values and densities: two arrays, shapes as of `eval` and `pdf`. Arguments as for `Bcsdf.eval`.
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
        unpack(py, self.run(py, &call, &[(Some(inner(lobes)), 0), (Some(&[]), colors(lobes))])?)
    }

    /// Draws directions ω_i: `Samples`. Arguments as for `Bcsdf.sample`.
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

    /// The share of the light that is scattered, shape (..., 3), or (..., 6, 3) with `lobes`. Arguments as for
    /// `Bcsdf.energy`.
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
        Ok(format!("Model('{}', {})", self.name(), self.fiber().text()?))
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Model>().is_ok_and(|other| (self.kind, self.fiber) == (other.get().kind, other.get().fiber))
    }

    fn __hash__(&self) -> u64 {
        self.fiber().hash() ^ self.kind as u64
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> (Bound<'py, PyAny>, (&'static str, Fiber)) {
        (slf.get_type().into_any(), (slf.get().name(), slf.get().fiber()))
    }
}

impl Model {
    pub fn of(kind: ModelKind, fiber: vellus::Fiber) -> PyResult<Self> {
        Ok(Model { kind, fiber, model: Box::new(kind.model(&fiber).map_err(value)?) })
    }
}

/// The names of all models.
fn names(py: Python<'_>) -> PyResult<Bound<'_, PyTuple>> {
    PyTuple::new(py, ModelKind::ALL.iter().map(|kind| kind.name()))
}

/// Adds the class of this file.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("MODEL_NAMES", names(module.py())?)?;
    module.add_class::<Model>()
}
