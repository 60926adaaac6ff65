//! Writes scenes.

use crate::Error;
use std::path::Path;
use vellus_scene::Scene;

/// Writes a scene: with the extension `hair` its strands, otherwise the whole scene as USD, `.usda` or
/// `.usdc`.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Options, open};

    #[test]
    fn strands_are_read_as_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lock.hair");
        let mut scene = open("hair-lock", &Options { small: true, ..Options::default() }).unwrap().scene;
        write(&scene, &path, 2).unwrap();
        let read = open(&path, &Options::default()).unwrap().scene;
        assert_eq!(read.strands[0].len(), scene.strands[0].len());
        scene.strands.push(scene.strands[0].clone());
        assert!(matches!(write(&scene, &path, 2), Err(Error::SeveralStrands(2))));
        assert!(matches!(write(&read, folder.path().join("lock.hair/a.hair"), 1), Err(Error::Write { .. })));
    }
}
