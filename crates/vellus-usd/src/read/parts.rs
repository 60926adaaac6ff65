//! Parts of a mesh with materials of their own (UsdGeomSubset).

use crate::error::Error;
use crate::read::context::Reader;
use crate::read::network::bound_material;
use crate::read::surface::surface;
use crate::stage::When;

/// Where the faces of a mesh belong.
#[derive(Debug)]
pub(crate) struct Parts {
    /// The surface of each part. `None` if it is invisible.
    pub surfaces: Vec<Option<usize>>,
    /// The part of each face; empty if there is one part.
    pub faces: Vec<usize>,
}

/// Reads the parts of a mesh with this many faces. A face that is in no subset with a material has that of the mesh.
pub(crate) fn parts(reader: &mut Reader, prim: &str, faces: usize, base: When) -> Result<Parts, Error> {
    let mut parts = Parts { surfaces: vec![surface(reader, prim)?], faces: Vec::new() };
    let own = bound_material(reader, prim)?;
    let children = reader.stage.children(prim).map_err(|what| Error::prim(prim, what))?;
    for subset in children.iter().map(|name| format!("{prim}/{name}")) {
        if reader.stage.type_name(&subset)? != "GeomSubset" || bound_material(reader, &subset)? == own {
            continue;
        }
        let kind = reader.stage.words(&subset, "elementType")?.unwrap_or_default();
        let indices = reader.stage.integers(&subset, "indices", base)?.unwrap_or_default();
        let has_faces = kind.first().is_none_or(|kind| kind == "face");
        let known: Option<Vec<usize>> =
            indices.iter().map(|&i| usize::try_from(i).ok().filter(|face| *face < faces)).collect();
        let Some(known) = known.filter(|_| has_faces) else {
            let what = "its material is ignored: its indices must be faces of the mesh";
            reader.warnings.add(&subset, what);
            continue;
        };
        let part = parts.surfaces.len();
        parts.surfaces.push(surface(reader, &subset)?);
        parts.faces.resize(faces, 0);
        known.into_iter().for_each(|face| parts.faces[face] = part);
    }
    Ok(parts)
}
