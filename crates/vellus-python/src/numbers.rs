//! Functions of single numbers, for whole arrays: windows of pixels, and colours of coats.

use crate::arrays::{Real, Rows, broadcast};
use crate::error::value;
use crate::fiber::{self, Fiber};
use crate::query::SLACK;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use vellus::{CoatColors, Window};

/// Applies a function to numbers that are broadcast together.
fn each<'py, const N: usize, const M: usize>(
    py: Python<'py>,
    arguments: [(&'static str, &Bound<'py, PyAny>); N],
    inner: &[usize],
    function: impl Fn([f32; N]) -> Result<[f32; M], String>,
) -> PyResult<Bound<'py, PyAny>> {
    let reals: Vec<Real<'_>> = arguments.iter().map(|(name, given)| Real::new(given, name)).collect::<PyResult<_>>()?;
    let mut rows: Vec<Rows<'_>> =
        reals.iter().zip(arguments).map(|(real, (name, _))| real.rows(name, None)).collect::<PyResult<_>>()?;
    let shape = broadcast(&mut rows.iter_mut().collect::<Vec<_>>())?;
    let count = shape.iter().product();
    let mut columns = vec![vec![0.0f32; count]; N];
    for (rows, column) in rows.iter().zip(&mut columns) {
        rows.gather(&shape, 0, count, column);
    }
    let mut results = Vec::with_capacity(M * count);
    for i in 0..count {
        let numbers: [f32; N] = std::array::from_fn(|k| columns[k][i]);
        if numbers.iter().any(|x| x.is_nan()) {
            results.extend([f32::NAN; M]);
        } else {
            results.extend(function(numbers).map_err(PyValueError::new_err)?);
        }
    }
    let shape = [&shape, inner].concat();
    let double = reals.iter().any(Real::is_double) || !reals.iter().any(Real::has_type);
    Ok(if double {
        let results: Vec<f64> = results.into_iter().map(f64::from).collect();
        PyArray1::from_vec(py, results).reshape(shape)?.into_any()
    } else {
        PyArray1::from_vec(py, results).reshape(shape)?.into_any()
    })
}

fn not_negative(width: f32) -> Result<(), String> {
    if width >= 0.0 { Ok(()) } else { Err(out(("width", width), "at least 0")) }
}

/// An offset. Rounding may put it a little outside of its range; it is then clamped.
fn offset(h: f32) -> Result<f32, String> {
    if h.abs() <= 1.0 + SLACK { Ok(h.clamp(-1.0, 1.0)) } else { Err(out(("h", h), "in [-1, 1]")) }
}

fn out((name, x): (&str, f32), range: &str) -> String {
    format!("{name} = {x} is out of range: it must be {range}")
}

/// The windows of pixels: centred on `h`, `width` fibre radii wide, cut off at the silhouettes (Yan17 Eq. 27).
///
/// `h`, `width`: offsets and widths, any shapes that fit together. `width` is the diameter of the pixel at the hit,
/// divided by the fibre's radius; 0 is the near field, 4 or more the far field.
/// Returns the two ends of each window: shape (..., 2), for the argument `window` of queries.
///
/// Raises `ValueError` for an offset out of range, or a width below 0.
#[pyfunction]
fn pixel_window<'py>(py: Python<'py>, h: &Bound<'py, PyAny>, width: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    each(py, [("h", h), ("width", width)], &[2], |[h, width]| {
        let h = offset(h)?;
        not_negative(width)?;
        Ok(Window::pixel(h, width).ends())
    })
}

/// The windows of pixels without bias: the cell of this width, shifted by `u`, that contains `h`.
///
/// Hits that are spread evenly over the width average to the far field, for any width of the cells.
///
/// `h`, `width`: as for `pixel_window`; a width of 2 or more is the far field. `u`: uniform in [0, 1).
/// Returns the two ends of each window: shape (..., 2), for the argument `window` of queries.
///
/// Raises `ValueError` for an offset or `u` out of range, or a width below 0.
#[pyfunction]
fn cell_window<'py>(
    py: Python<'py>,
    h: &Bound<'py, PyAny>,
    width: &Bound<'py, PyAny>,
    u: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    each(py, [("h", h), ("width", width), ("u", u)], &[2], |[h, width, u]| {
        let h = offset(h)?;
        not_negative(width)?;
        if !(0.0..=1.0).contains(&u) {
            return Err(out(("u", u), "in [0, 1)"));
        }
        Ok(Window::cell(h, width, u.min(1.0f32.next_down())).ends())
    })
}

/// The unit vector with inclination `theta` and azimuth `phi`, in degrees.
///
/// x runs along the fibre from root to tip, theta = asin x, and phi = atan2(z, y). Any shapes that fit together.
/// Returns shape (..., 3).
///
/// Raises `ValueError` if `theta` is not in [-90, 90], or `phi` not finite.
#[pyfunction]
fn direction<'py>(py: Python<'py>, theta: &Bound<'py, PyAny>, phi: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    each(py, [("theta", theta), ("phi", phi)], &[3], |[theta, phi]| {
        if theta.abs() > 90.0 {
            return Err(out(("theta", theta), "in [-90, 90] degrees"));
        }
        if phi.is_infinite() {
            return Err(out(("phi", phi), "finite"));
        }
        Ok(vellus_models::direction(f64::from(theta), f64::from(phi)).to_array())
    })
}

/// Converts between the absorption of a fibre and the colour of a dense coat of such fibres in white light.
///
/// Each channel is converted by itself. The conversion depends on all parameters of the fibre except its absorption.
/// The medulla gets `fiber.medulla_pigment` times the absorption of the cortex.
#[pyclass(frozen, module = "vellus", name = "CoatColors")]
pub struct Coat {
    fiber: vellus::Fiber,
    colors: CoatColors,
}

#[pymethods]
impl Coat {
    #[new]
    fn new(fiber: &Bound<'_, PyAny>) -> PyResult<Self> {
        let fiber = fiber::argument(fiber)?;
        Ok(Coat { fiber, colors: CoatColors::new(&fiber).map_err(value)? })
    }

    /// The darkest and the brightest colour that pigment can give to the coat.
    #[getter]
    fn range(&self) -> (f64, f64) {
        self.colors.range().map(fiber::shortest).into()
    }

    /// The absorption of the cortex, per fibre radius, that gives the coat this `color`, a reflectance in [0, 1].
    ///
    /// Any shape; the result has the same. Colours out of reach give the absorption of the nearest colour.
    /// Raises `ValueError` for a colour that is not in [0, 1].
    fn absorption<'py>(&self, py: Python<'py>, color: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        each(py, [("color", color)], &[], |[color]| {
            if !(0.0..=1.0).contains(&color) {
                return Err(out(("color", color), "in [0, 1]"));
            }
            Ok([self.colors.absorption(color)])
        })
    }

    /// The colour of a coat whose fibres have this `absorption` of the cortex, at least 0, per fibre radius.
    ///
    /// Any shape; the result has the same, in [0, 1]. Raises `ValueError` for a negative or infinite number.
    fn color<'py>(&self, py: Python<'py>, absorption: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        each(py, [("absorption", absorption)], &[], |[absorption]| {
            if absorption < 0.0 || absorption.is_infinite() {
                return Err(out(("absorption", absorption), "at least 0, and finite"));
            }
            Ok([self.colors.color(absorption)])
        })
    }

    fn __repr__(&self) -> PyResult<String> {
        Ok(format!("CoatColors({})", Fiber(self.fiber).text()?))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> (Bound<'py, PyAny>, (Fiber,)) {
        (slf.get_type().into_any(), (Fiber(slf.get().fiber),))
    }
}

/// Adds the functions of this file.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Coat>()?;
    module.add_function(wrap_pyfunction!(pixel_window, module)?)?;
    module.add_function(wrap_pyfunction!(cell_window, module)?)?;
    module.add_function(wrap_pyfunction!(direction, module)?)
}
