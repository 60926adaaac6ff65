//! Arguments of a scene: names, indices, parameters that vary, and values at corners.

use super::arrays::Floats;
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use vellus::Parameter;
use vellus_scene::{Basis, Values, Wrap};

pub const BASES: [(&str, Basis); 4] = [
    ("linear", Basis::Linear),
    ("bspline", Basis::BSpline),
    ("catmull-rom", Basis::CatmullRom),
    ("bezier", Basis::Bezier),
];

pub const WRAPS: [(&str, Wrap); 4] =
    [("repeat", Wrap::Repeat), ("clamp", Wrap::Clamp), ("mirror", Wrap::Mirror), ("black", Wrap::Black)];

pub const LIGHTS: [(&str, ()); 7] =
    [("dome", ()), ("distant", ()), ("rect", ()), ("disk", ()), ("point", ()), ("sphere", ()), ("cylinder", ())];

/// The index if the scene has it.
pub fn position(all: usize, index: i128, what: &str) -> PyResult<usize> {
    let found = usize::try_from(index).ok().filter(|index| *index < all);
    found.ok_or_else(|| PyIndexError::new_err(format!("{what} = {index} does not exist: the scene has {all}")))
}

/// The values of a parameter: `strands` and `points` are the numbers of both.
pub fn varying(parameter: Parameter, given: &Floats, strands: usize, points: usize) -> PyResult<Values<[f32; 3]>> {
    let name = parameter.name();
    let channels = parameter.channels();
    let stored = |x: f32| if parameter.is_angle() { x.to_radians() } else { x };
    let (count, width) = match given.shape[..] {
        [] => (None, 1),
        [n] if n == channels && channels > 1 => (None, channels),
        [n] => (Some(n), 1),
        [n, w] if w == channels => (Some(n), w),
        _ => (Some(usize::MAX), 1),
    };
    let rows = given.values.chunks_exact(width).map(|row| std::array::from_fn(|c| stored(row[c.min(width - 1)])));
    let rows: Vec<[f32; 3]> = rows.collect();
    for (i, row) in rows.iter().enumerate() {
        parameter.check(*row).map_err(|e| PyValueError::new_err(format!("parameters[{name:?}], row {i}: {e}")))?;
    }
    match count {
        None => Ok(Values::Constant(rows[0])),
        Some(n) if n == strands => Ok(Values::PerStrand(rows)),
        Some(n) if n == points => Ok(Values::PerPoint(rows)),
        Some(_) => {
            let shape = crate::arrays::text(&given.shape);
            let of = |n: usize| if channels > 1 { format!("({n},) or ({n}, {channels})") } else { format!("({n},)") };
            let what =
                format!("parameters[{name:?}] has the shape {shape}: it must be (), {} for strands", of(strands));
            Err(PyValueError::new_err(format!("{what}, or {} for points", of(points))))
        }
    }
}

/// The parameter with this name.
pub fn parameter(name: &str) -> PyResult<Parameter> {
    Parameter::from_name(name).filter(|parameter| parameter.varies()).ok_or_else(|| {
        let known: Vec<&str> = Parameter::ALL.iter().filter(|p| p.varies()).map(|p| p.name()).collect();
        PyValueError::new_err(format!("parameter {name:?} is unknown: it must be one of {}", known.join(", ")))
    })
}

/// Values of the corners of triangles, from those or from values of the vertices.
pub fn corners<const N: usize>(
    given: Option<&Bound<'_, PyAny>>,
    name: &str,
    triangles: &[[u32; 3]],
    vertices: usize,
) -> PyResult<Option<Vec<[[f32; N]; 3]>>> {
    let Some(given) = given else { return Ok(None) };
    let mut given = Floats::new(given, name)?;
    if given.shape[..] == [triangles.len(), 3, N] {
        given.shape = vec![3 * triangles.len(), N];
        let rows = given.rows::<N>("corners")?;
        return Ok(Some(rows.as_chunks::<3>().0.to_vec()));
    }
    if given.shape[..] != [vertices, N] {
        let shape = crate::arrays::text(&given.shape);
        let what =
            format!("{name} has the shape {shape}: it must be ({vertices}, {N}) or ({}, 3, {N})", triangles.len());
        return Err(PyValueError::new_err(what));
    }
    let rows = given.rows_of::<N>(vertices)?;
    Ok(Some(triangles.iter().map(|t| t.map(|v| rows[v as usize])).collect()))
}
