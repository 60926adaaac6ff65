//! Reads primvars: values of a prim, its strands or faces, or its points (UsdGeomPrimvar).

use crate::error::Error;
use crate::read::color::{has_color, space_name};
use crate::stage::{Numbers, Stage, When};

/// The elements that values belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Interpolation {
    /// The prim.
    Constant,
    /// A strand or a face.
    Uniform,
    /// A knot between segments of a strand, or a point of a mesh.
    Varying,
    /// A point.
    Vertex,
    /// A corner of a face.
    FaceVarying,
}

/// Values and their interpolation.
#[derive(Clone, Debug)]
pub(crate) struct Primvar {
    pub values: Numbers,
    pub interpolation: Interpolation,
    /// The name of the colour space of colours.
    pub space: Option<String>,
}

/// Reads an attribute with its interpolation (`fallback` if it has none), and resolves its indices.
pub(crate) fn primvar(
    stage: &Stage,
    prim: &str,
    name: &str,
    fallback: Interpolation,
    when: When,
) -> Result<Option<Primvar>, Error> {
    let Some(mut values) = stage.numbers(prim, name, when)? else { return Ok(None) };
    let interpolation = match stage.metadata(prim, name, "interpolation")?.as_deref() {
        None => fallback,
        Some("constant") => Interpolation::Constant,
        Some("uniform") => Interpolation::Uniform,
        Some("varying") => Interpolation::Varying,
        Some("vertex") => Interpolation::Vertex,
        Some("faceVarying") => Interpolation::FaceVarying,
        Some(other) => {
            let allowed = "constant, uniform, varying, vertex or faceVarying";
            return Err(Error::prim(prim, format!("{name} has the interpolation {other}: it must be {allowed}")));
        }
    };
    if let Some(indices) = stage.integers(prim, &format!("{name}:indices"), when)? {
        let mut expanded = Vec::with_capacity(indices.len() * values.lanes);
        for (i, &index) in indices.iter().enumerate() {
            let row = usize::try_from(index).ok().filter(|&index| index < values.len()).ok_or_else(|| {
                Error::prim(prim, format!("{name}:indices[{i}] is {index}, but there are {} values", values.len()))
            })?;
            expanded.extend_from_slice(values.row(row));
        }
        values.values = expanded;
    }
    let space = space_name(stage, prim, name, has_color(stage, prim, name)?)?;
    Ok(Some(Primvar { values, interpolation, space }))
}

/// The primvar of the prim itself, or a constant primvar of the nearest ancestor.
pub(crate) fn inherited(stage: &Stage, prim: &str, name: &str, when: When) -> Result<Option<Primvar>, Error> {
    if let Some(own) = primvar(stage, prim, name, Interpolation::Constant, when)? {
        return Ok(Some(own));
    }
    for ancestor in ancestors(prim).skip(1) {
        if let Some(theirs) = primvar(stage, ancestor, name, Interpolation::Constant, when)?
            && theirs.interpolation == Interpolation::Constant
        {
            return Ok(Some(theirs));
        }
    }
    Ok(None)
}

/// The path of the prim, of its parent, and so on.
pub(crate) fn ancestors(prim: &str) -> impl Iterator<Item = &str> {
    std::iter::successors(Some(prim), |path| path.rsplit_once('/').map(|(parent, _)| parent)).filter(|p| !p.is_empty())
}
