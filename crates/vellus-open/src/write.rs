//! Writes scenes.

use crate::Error;
use std::path::Path;
use vellus_scene::Scene;

/// Writes a scene: with the extension `hair` its strands, otherwise the whole scene as USD, `.usda`.
///
/// A .hair file has straight segments: `pieces` of them for each curved one, at least 1.
///
/// # Errors
/// [`Error::SeveralStrands`] or [`Error::Unwritable`] if a .hair file cannot hold the strands. [`Error::Write`] or
/// [`Error::Usd`] if the file cannot be written.
pub fn write(scene: &Scene, path: impl AsRef<Path>, pieces: usize) -> Result<(), Error> {
    let path = path.as_ref();
    if path.extension().is_none_or(|extension| extension != "hair") {
        return Ok(vellus_usd::write(scene, path)?);
    }
    let [strands] = &scene.strands[..] else { return Err(Error::SeveralStrands(scene.strands.len())) };
    let bytes = vellus_groom::write_hair(&vellus_groom::flatten(strands, pieces));
    let bytes = bytes.map_err(|error| Error::Unwritable { path: path.to_owned(), what: error.to_string() })?;
    vellus_io::write(path, &bytes).map_err(|source| Error::Write { path: path.to_owned(), source })
}
