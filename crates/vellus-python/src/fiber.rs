//! The fibre: its parameters by name, its colour, presets.

use crate::error::value;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyTuple};
use std::hash::{DefaultHasher, Hash, Hasher};
use vellus::{Error, Exit, FiberBuilder, Parameter, Species};

/// A fibre. The stub and the book document it.
#[pyclass(frozen, eq, module = "vellus", name = "Fiber")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fiber(pub vellus::Fiber);

/// One number, or several.
pub fn numbers(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<f32>> {
    let wrong = |_| {
        let kind = value.get_type();
        PyTypeError::new_err(format!("{name} must be a number or a sequence of numbers, not {kind}"))
    };
    if value.is_instance_of::<PyString>() {
        return Err(wrong(()));
    }
    if let Ok(x) = value.extract::<f64>() {
        return Ok(vec![x as f32]);
    }
    let several = value.try_iter().map_err(|_| wrong(()))?;
    several.map(|x| x?.extract::<f64>().map(|x| x as f32).map_err(|_| wrong(()))).collect()
}

/// The fibre with these parameters by name.
fn built(base: vellus::Fiber, parameters: Option<&Bound<'_, PyDict>>) -> PyResult<vellus::Fiber> {
    let mut builder = FiberBuilder::new(base);
    for (name, given) in parameters.into_iter().flatten() {
        let name: String = name.extract()?;
        if given.is_none() {
            continue;
        }
        if name == "exit" {
            let exit: String = given.extract().map_err(|_| PyTypeError::new_err("exit must be a string"))?;
            builder.set_exit(exit.parse().map_err(value)?);
            continue;
        }
        builder.set(&name, &numbers(&name, &given)?).map_err(|e| match e {
            Error::UnknownParameter { .. } => PyTypeError::new_err(e.to_string()),
            e => value(e),
        })?;
    }
    builder.build().map_err(value)
}

/// A parameter as files have it: angles in degrees.
fn number(fiber: &vellus::Fiber, parameter: Parameter) -> PyResult<f64> {
    Ok(file(fiber)?.get(parameter.name()).and_then(serde_json::Value::as_f64).unwrap_or_else(|| {
        // Written only if it differs from its default.
        parameter.get(fiber).map_or(f64::NAN, |[x, ..]| f64::from(x))
    }))
}

/// The fibre as in a file. It is read back from the text, which has the shortest decimal numbers.
fn file(fiber: &vellus::Fiber) -> PyResult<serde_json::Value> {
    serde_json::to_string(fiber).and_then(|text| serde_json::from_str(&text)).map_err(value)
}

/// RGB as files have it: the shortest decimal numbers.
fn color(rgb: [f32; 3]) -> [f64; 3] {
    rgb.map(shortest)
}

/// The f64 with the decimal digits of the f32: 0.1, not 0.10000000149011612.
pub fn shortest(x: f32) -> f64 {
    x.to_string().parse().unwrap_or(f64::from(x))
}

#[pymethods]
impl Fiber {
    #[new]
    #[pyo3(signature = (preset = None, /, **parameters))]
    fn new(preset: Option<&str>, parameters: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let base = preset.map_or(Ok(vellus::Fiber::hair()), vellus::Fiber::named).map_err(value)?;
        built(base, parameters).map(Fiber)
    }

    #[getter]
    fn kappa(&self) -> f64 {
        shortest(self.0.kappa)
    }

    #[getter]
    fn eta(&self) -> f64 {
        shortest(self.0.eta)
    }

    #[getter]
    fn alpha(&self) -> PyResult<f64> {
        number(&self.0, Parameter::Alpha)
    }

    #[getter]
    fn beta_m(&self) -> PyResult<f64> {
        number(&self.0, Parameter::BetaM)
    }

    #[getter]
    fn beta_n(&self) -> PyResult<f64> {
        number(&self.0, Parameter::BetaN)
    }

    #[getter]
    fn sigma_ca(&self) -> (f64, f64, f64) {
        color(self.0.sigma_ca).into()
    }

    #[getter]
    fn sigma_ms(&self) -> f64 {
        shortest(self.0.sigma_ms)
    }

    #[getter]
    fn sigma_ma(&self) -> (f64, f64, f64) {
        color(self.0.sigma_ma).into()
    }

    #[getter]
    fn g(&self) -> f64 {
        shortest(self.0.g)
    }

    #[getter]
    fn layers(&self) -> f64 {
        shortest(self.0.layers)
    }

    #[getter]
    fn medulla_pigment(&self) -> f64 {
        shortest(self.0.medulla_pigment)
    }

    #[getter]
    fn exit(&self) -> &'static str {
        self.0.exit.name()
    }

    #[pyo3(signature = (**parameters))]
    fn replace(&self, parameters: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        built(self.0, parameters).map(Fiber)
    }

    fn without_absorption(&self) -> Self {
        Fiber(self.0.without_absorption())
    }

    fn coat_color(&self) -> PyResult<(f64, f64, f64)> {
        self.0.coat_color().map(|rgb| color(rgb).into()).map_err(value)
    }

    fn to_json(&self) -> PyResult<String> {
        serde_json::to_string(&self.0).map_err(value)
    }

    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        serde_json::from_str(text).map(Fiber).map_err(value)
    }

    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for parameter in Parameter::ALL.into_iter().filter(|p| p.get(&self.0).is_some()) {
            let number = match parameter {
                Parameter::SigmaCa => color(self.0.sigma_ca).into_pyobject(py)?.into_any(),
                Parameter::SigmaMa => color(self.0.sigma_ma).into_pyobject(py)?.into_any(),
                _ => number(&self.0, parameter)?.into_pyobject(py)?.into_any(),
            };
            dict.set_item(parameter.name(), number)?;
        }
        dict.set_item("exit", self.exit())?;
        Ok(dict)
    }

    fn __repr__(&self) -> PyResult<String> {
        self.text()
    }

    fn __hash__(&self) -> u64 {
        self.hash()
    }

    /// For pickle: exact, where degrees would be rounded.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let py = slf.py();
        let make = slf.get_type().getattr("_from_state")?;
        let state = slf.get().state().map(f64::from);
        Ok((make, PyTuple::new(py, [state.into_pyobject(py)?.into_any(), slf.get().exit().into_pyobject(py)?.into_any()])?))
    }

    #[staticmethod]
    fn _from_state(state: [f64; 15], exit: &str) -> PyResult<Self> {
        let state = state.map(|x| x as f32);
        let [kappa, eta, alpha, beta_m, beta_n, r, g, b, sigma_ms, x, y, z, anisotropy, layers, medulla_pigment] = state;
        let fiber = vellus::Fiber {
            eta,
            kappa,
            alpha,
            beta_m,
            beta_n,
            sigma_ca: [r, g, b],
            sigma_ms,
            sigma_ma: [x, y, z],
            g: anisotropy,
            layers,
            exit: exit.parse::<Exit>().map_err(value)?,
            medulla_pigment,
        };
        fiber.validate().map_err(value)?;
        Ok(Fiber(fiber))
    }
}

impl Fiber {
    /// The expression that makes this fibre, as Python writes it.
    pub fn text(&self) -> PyResult<String> {
        let mut parts = Vec::new();
        if let serde_json::Value::Object(map) = file(&self.0)? {
            for (name, number) in map {
                parts.push(match number {
                    serde_json::Value::String(text) => format!("{name}='{text}'"),
                    serde_json::Value::Array(rgb) => {
                        let rgb: Vec<String> = rgb.iter().map(ToString::to_string).collect();
                        format!("{name}=({})", rgb.join(", "))
                    }
                    number => format!("{name}={number}"),
                });
            }
        }
        Ok(format!("Fiber({})", parts.join(", ")))
    }

    pub fn hash(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        for value in self.state() {
            // 0 and −0 are equal.
            (value + 0.0).to_bits().hash(&mut hasher);
        }
        self.0.exit.hash(&mut hasher);
        hasher.finish()
    }

    /// All numbers, in the units of the crate.
    fn state(&self) -> [f32; 15] {
        let f = &self.0;
        let ([r, g, b], [x, y, z]) = (f.sigma_ca, f.sigma_ma);
        [f.kappa, f.eta, f.alpha, f.beta_m, f.beta_n, r, g, b, f.sigma_ms, x, y, z, f.g, f.layers, f.medulla_pigment]
    }
}

/// The names of the presets.
#[pyfunction]
fn species() -> Vec<&'static str> {
    Species::ALL.map(Species::name).to_vec()
}

/// The table of parameters: name → unit, range, channels, description.
#[pyfunction]
fn parameters(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let table = PyDict::new(py);
    for parameter in Parameter::ALL {
        let row = PyDict::new(py);
        row.set_item("symbol", parameter.symbol())?;
        row.set_item("unit", parameter.unit().suffix().trim())?;
        row.set_item("range", (parameter.range().low, parameter.range().high))?;
        row.set_item("channels", parameter.channels())?;
        row.set_item("description", parameter.description())?;
        table.set_item(parameter.name(), row)?;
    }
    Ok(table)
}

/// Adds the functions of this file.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Fiber>()?;
    module.add_function(wrap_pyfunction!(species, module)?)?;
    module.add_function(wrap_pyfunction!(parameters, module)?)
}

/// A fibre from an argument: a [`Fiber`], or the name of a preset.
pub fn argument(value_or_name: &Bound<'_, PyAny>) -> PyResult<vellus::Fiber> {
    if let Ok(fiber) = value_or_name.cast::<Fiber>() {
        return Ok(fiber.get().0);
    }
    if let Ok(name) = value_or_name.extract::<String>() {
        return vellus::Fiber::named(&name).map_err(value);
    }
    let kind = value_or_name.get_type();
    Err(PyTypeError::new_err(format!("fiber must be a Fiber or the name of a preset, not {kind}")))
}
