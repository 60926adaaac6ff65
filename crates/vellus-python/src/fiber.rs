//! The fibre: its parameters by name, its colour, presets.

use crate::error::{value, with_causes};
use pyo3::exceptions::{PyTypeError, PyUserWarning, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyTuple};
use std::ffi::CString;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::PathBuf;
use vellus::{Error, FiberBuilder, Parameter, Species};
use vellus_open::{FiberFormat, FiberSource};

/// The parameters of one fibre. It does not change; `replace` makes another.
///
/// `preset`: the name of a species, such as `red-fox`, or of its published fit, `red-fox-published`; a hair without
/// medulla and without absorption if there is none. All other arguments replace a parameter of the preset:
///
/// - `kappa`: radius of the medulla over that of the fibre, in [0, 0.99]. 0 is a hair without medulla.
/// - `eta`: refractive index of cortex and medulla, in [1, 3].
/// - `alpha`: shift of the R highlight toward the root, in [-45, 45] degrees. It is not the tilt of the cuticle's
///   scales: scales that are tilted by δ shift R by 2δ at h = 0, and by about 1.33δ in the far field.
/// - `beta_m`, `beta_n`: longitudinal and azimuthal roughness, standard deviations in [0.1, 90] degrees.
/// - `sigma_ca`, `sigma_ma`: absorption in cortex and medulla per fibre radius, RGB or one number, in [0, 1000].
/// - `sigma_ms`: scattering in the medulla per fibre radius, in [0, 1000].
/// - `g`: anisotropy of that scattering, in [0, 0.95].
/// - `layers`: layers of the cuticle, in [0, 20]. 0.5 is nearly one dielectric interface.
/// - `wet`: share of water around the fibre, in [0, 1]. Colours are those of dry fur.
/// - `aspect_ratio`: shorter axis of the section over the longer one, in [0.4, 1]. The longer axis is y of the fibre's
///   frame.
/// - `medulla_air`: share of air in the medulla, in [0, 1], whose index is 1 + (1 - medulla_air)(eta - 1).
/// - `exit`: how scattered light leaves the fibre, `reflecting` or `open`. `open` is the paper's model.
/// - `medulla_pigment`: absorption in the medulla over that in the cortex for the three colours below, in [0, 10].
///
/// At most one of `sigma_ca` and these gives the colour:
///
/// - `reflectance`: colour of the coat in white light, RGB, one number, or a name or `#rrggbb`, in [0.001, 0.999]: see
///   `Scene.open`. `Bcsdf` and `coat_color` take a dense coat. A colour that no
///   pigment reaches gives the nearest one, and a warning.
/// - `melanin`: concentrations of eumelanin and pheomelanin, in [0, 100]. One number is eumelanin. Also by name:
///   `eumelanin`, `pheomelanin`.
/// - `hair_reflectance`: colour of hair without medulla by Chiang et al. 2016, in [0.001, 0.999].
///
/// Angles are in degrees, as in files. The model computes in single precision, and parameters are stored in it.
///
/// Raises `ValueError` that names parameter, value and range; `TypeError` for an unknown parameter or a wrong type.
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
fn built(py: Python<'_>, base: vellus::Fiber, parameters: Option<&Bound<'_, PyDict>>) -> PyResult<vellus::Fiber> {
    let mut builder = FiberBuilder::new(base);
    for (name, given) in parameters.into_iter().flatten() {
        let name: String = name.extract()?;
        if given.is_none() {
            continue;
        }
        if Parameter::from_name(&name).is_some_and(|parameter| !parameter.choices().is_empty()) {
            let word: String = given.extract().map_err(|_| PyTypeError::new_err(format!("{name} must be a string")))?;
            builder.set_word(&name, &word).map_err(value)?;
            continue;
        }
        let is_word = given.is_instance_of::<PyString>() && name.ends_with("reflectance");
        let numbers = match is_word {
            true => vellus_open::color(&given.extract::<String>()?).map_err(PyValueError::new_err)?.to_vec(),
            false => numbers(&name, &given)?,
        };
        builder.set(&name, &numbers).map_err(|e| match e {
            Error::UnknownParameter { .. } => PyTypeError::new_err(e.to_string()),
            e => value(e),
        })?;
    }
    let fiber = builder.build().map_err(value)?;
    if let Some(color) = builder.out_of_reach().map_err(value)? {
        warn(py, &color.to_string())?;
    }
    Ok(fiber)
}

/// Warns the caller of the function that Python called.
fn warn(py: Python<'_>, text: &str) -> PyResult<()> {
    let text = CString::new(text)?;
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, 1)
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
#[allow(clippy::wrong_self_convention, reason = "methods of Python take a reference")]
impl Fiber {
    #[new]
    #[pyo3(signature = (preset = None, /, **parameters))]
    fn new(py: Python<'_>, preset: Option<&str>, parameters: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let base = preset.map_or(Ok(vellus::Fiber::hair()), vellus::Fiber::named).map_err(value)?;
        built(py, base, parameters).map(Fiber)
    }

    /// Radius of the medulla over that of the fibre.
    #[getter]
    fn kappa(&self) -> f64 {
        shortest(self.0.kappa)
    }

    /// Refractive index of cortex and medulla.
    #[getter]
    fn eta(&self) -> f64 {
        shortest(self.0.eta)
    }

    /// Shift of the R highlight toward the root, degrees.
    #[getter]
    fn alpha(&self) -> PyResult<f64> {
        number(&self.0, Parameter::Alpha)
    }

    /// Longitudinal roughness, a standard deviation in degrees.
    #[getter]
    fn beta_m(&self) -> PyResult<f64> {
        number(&self.0, Parameter::BetaM)
    }

    /// Azimuthal roughness, a standard deviation in degrees.
    #[getter]
    fn beta_n(&self) -> PyResult<f64> {
        number(&self.0, Parameter::BetaN)
    }

    /// Absorption in the cortex, RGB, per fibre radius.
    #[getter]
    fn sigma_ca(&self) -> (f64, f64, f64) {
        color(self.0.sigma_ca).into()
    }

    /// Scattering in the medulla, per fibre radius.
    #[getter]
    fn sigma_ms(&self) -> f64 {
        shortest(self.0.sigma_ms)
    }

    /// Absorption in the medulla, RGB, per fibre radius.
    #[getter]
    fn sigma_ma(&self) -> (f64, f64, f64) {
        color(self.0.sigma_ma).into()
    }

    /// Anisotropy of the scattering in the medulla.
    #[getter]
    fn g(&self) -> f64 {
        shortest(self.0.g)
    }

    /// Layers of the cuticle.
    #[getter]
    fn layers(&self) -> f64 {
        shortest(self.0.layers)
    }

    /// Share of water around the fibre.
    #[getter]
    fn wet(&self) -> f64 {
        shortest(self.0.wet)
    }

    /// Shorter axis of the section over the longer one.
    #[getter]
    fn aspect_ratio(&self) -> f64 {
        shortest(self.0.aspect_ratio)
    }

    /// Share of air in the medulla.
    #[getter]
    fn medulla_air(&self) -> f64 {
        shortest(self.0.medulla_air)
    }

    /// Absorption in the medulla over that in the cortex, for colours.
    #[getter]
    fn medulla_pigment(&self) -> f64 {
        shortest(self.0.medulla_pigment)
    }

    /// How scattered light leaves the fibre: `reflecting` or `open`.
    #[getter]
    fn exit(&self) -> &'static str {
        self.0.exit.name()
    }

    /// The same fibre with other parameters: the keyword arguments of `Fiber`.
    #[pyo3(signature = (**parameters))]
    fn replace(&self, py: Python<'_>, parameters: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        built(py, self.0, parameters).map(Fiber)
    }

    /// The fibre in air that scatters light as this one does in its water: `wet` is then 0.
    fn in_air(&self) -> Self {
        Fiber(self.0.in_air())
    }

    /// The same fibre without absorption in cortex and medulla: for white fur and furnace tests.
    fn without_absorption(&self) -> Self {
        Fiber(self.0.without_absorption())
    }

    /// The colour of a dense coat of such fibres in white light: RGB, a reflectance in [0, 1].
    fn coat_color(&self) -> PyResult<(f64, f64, f64)> {
        self.0.coat_color().map(|rgb| color(rgb).into()).map_err(value)
    }

    /// The fibre as JSON, as files have it: angles in degrees.
    fn to_json(&self) -> PyResult<String> {
        serde_json::to_string(&self.0).map_err(value)
    }

    /// A fibre from JSON. `text`: parameters by name, and `preset`.
    ///
    /// Raises `ValueError` for text that is no fibre, or a parameter out of range.
    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        serde_json::from_str(text).map(Fiber).map_err(value)
    }

    /// The parameters by name. RGB values are tuples. `Fiber(**fiber.to_dict())` makes the fibre again.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for parameter in Parameter::ALL.into_iter().filter(|p| p.get(&self.0).is_some()) {
            let stored = parameter.get(&self.0).unwrap_or_default();
            match (parameter.word(stored[0]), parameter.channels()) {
                (Some(word), _) => dict.set_item(parameter.name(), word)?,
                (None, 3) => dict.set_item(parameter.name(), color(stored))?,
                (None, _) => dict.set_item(parameter.name(), number(&self.0, parameter)?)?,
            }
        }
        Ok(dict)
    }

    /// The fibre as TOML.
    fn to_toml(&self) -> PyResult<String> {
        FiberFormat::Toml.write(&self.0).map_err(value)
    }

    /// Reads a fibre from the file `path`: `.toml`, `.json`, or a material of a MaterialX document, `FILE.mtlx#NAME`.
    ///
    /// `settings`: parameters as `NAME=VALUE` or `NAME=R,G,B` that replace those of the file.
    ///
    /// Raises `FileNotFoundError` or `PermissionError` for a file that cannot be opened, and `ValueError` that names
    /// the file or the parameter.
    #[staticmethod]
    #[pyo3(signature = (path, *settings))]
    fn read(py: Python<'_>, path: PathBuf, settings: Vec<String>) -> PyResult<Self> {
        let source = FiberSource { path, set: settings };
        let (fiber, warnings) = source.read_with_warnings().map_err(|e| with_causes(&e))?;
        warnings.iter().try_for_each(|warning| warn(py, warning))?;
        Ok(Fiber(fiber))
    }

    /// A table of the parameters, with the colour of a coat of such fibres.
    fn _repr_html_(&self) -> PyResult<String> {
        let serde_json::Value::Object(map) = file(&self.0)? else { return Ok(String::new()) };
        let rows: String = map
            .iter()
            .map(|(name, number)| {
                let unit = Parameter::from_name(name).map_or("", |p| p.unit().suffix());
                let number = match number {
                    serde_json::Value::String(text) => text.clone(),
                    serde_json::Value::Array(rgb) => rgb.iter().map(ToString::to_string).collect::<Vec<_>>().join(", "),
                    number => number.to_string(),
                };
                format!("<tr><th style=\"text-align:left\">{name}</th><td>{number}{unit}</td></tr>")
            })
            .collect();
        // The picture of a colour has the transfer function of sRGB.
        let shown = |x: f32| {
            let x = x.clamp(0.0, 1.0);
            let y = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
            (255.0 * y).round() as u8
        };
        let color = self.0.coat_color().map_err(value)?;
        let [r, g, b] = color.map(shown);
        let swatch =
            format!("<span style=\"display:inline-block;width:4em;height:1em;background:rgb({r},{g},{b})\"></span>");
        let [x, y, z] = color;
        let coat = format!("<tr><th style=\"text-align:left\">coat</th><td>{swatch} {x:.3}, {y:.3}, {z:.3}</td></tr>");
        Ok(format!("<table>{rows}{coat}</table>"))
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
        let reflectance = slf.get().0.reflectance.into_pyobject(py)?;
        Ok((make, PyTuple::new(py, [slf.get().state().into_pyobject(py)?, reflectance])?))
    }

    #[staticmethod]
    #[pyo3(signature = (state, reflectance = None))]
    fn _from_state(state: Vec<[f32; 3]>, reflectance: Option<[f32; 3]>) -> PyResult<Self> {
        let mut fiber = vellus::Fiber::hair();
        stored().zip(state).try_for_each(|(parameter, x)| parameter.set(&mut fiber, x)).map_err(value)?;
        fiber.reflectance = reflectance;
        fiber.validate().map_err(value)?;
        Ok(Fiber(fiber))
    }
}

/// What a fibre stores, but for the reflectance that its absorption came from.
fn stored() -> impl Iterator<Item = Parameter> {
    Parameter::ALL.into_iter().filter(|parameter| parameter.default_value().is_some())
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
        for value in self.state().into_iter().flatten() {
            // 0 and −0 are equal.
            (value + 0.0).to_bits().hash(&mut hasher);
        }
        self.0.reflectance.map(|color| color.map(f32::to_bits)).hash(&mut hasher);
        hasher.finish()
    }

    /// All values of [`stored`], in the units of the crate.
    fn state(&self) -> Vec<[f32; 3]> {
        stored().filter_map(|parameter| parameter.get(&self.0)).collect()
    }
}

/// The names of the presets.
#[pyfunction]
fn species() -> Vec<&'static str> {
    Species::ALL.map(Species::name).to_vec()
}

/// The table of parameters: name → symbol, unit, range, channels, label, choices (the words, if it is no number),
/// description.
#[pyfunction]
fn parameters(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let table = PyDict::new(py);
    for parameter in Parameter::ALL {
        let row = PyDict::new(py);
        row.set_item("symbol", parameter.symbol())?;
        row.set_item("unit", parameter.unit().suffix().trim())?;
        row.set_item("range", (parameter.range().low, parameter.range().high))?;
        row.set_item("channels", parameter.channels())?;
        row.set_item("label", parameter.label())?;
        row.set_item("choices", parameter.choices())?;
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
