//! Writes scenes.

use crate::Error;
use std::path::Path;
use vellus_scene::{Parameter, Scene, Values};

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

/// What a file that [`write()`] made does not have. A .hair file has positions, widths and colours only.
pub fn dropped(scene: &Scene, path: impl AsRef<Path>) -> Vec<String> {
    if path.as_ref().extension().is_none_or(|extension| extension != "hair") {
        return Vec::new();
    }
    let count = |count: usize, one: &str, many: &str| match count {
        0 => None,
        1 => Some(one.to_owned()),
        count => Some(format!("the {count} {many}")),
    };
    let mut dropped: Vec<String> =
        scene.strands.iter().map(|strands| format!("the fibre {}", scene.looks[strands.look].name)).collect();
    for strands in &scene.strands {
        dropped.extend(strands.root_uv.as_ref().map(|_| "the uv of the roots".to_owned()));
        dropped.extend(strands.moved.as_ref().map(|_| "the motion".to_owned()));
        let is_kept = |(parameter, values): &&(Parameter, _)| {
            *parameter == Parameter::Reflectance && matches!(values, Values::PerPoint(_))
        };
        let varying = strands.varying.iter().filter(|varying| !is_kept(varying));
        dropped.extend(varying.map(|(parameter, _)| format!("values of {}", parameter.name())));
    }
    dropped.extend(scene.units.map(|_| "the units".to_owned()));
    dropped.extend(scene.camera.map(|_| "the camera".to_owned()));
    dropped.extend(count(scene.meshes.len(), "the mesh", "meshes"));
    dropped.extend(count(scene.lights.len(), "the light", "lights"));
    dropped.extend(count(scene.instances.len(), "the instance", "instances"));
    dropped
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
        let dropped = super::dropped(&scene, &path);
        for part in ["the fibre hair", "the units", "the camera"] {
            assert!(dropped.iter().any(|what| what == part), "{part}: {dropped:?}");
        }
        assert_eq!(super::dropped(&scene, "lock.usda"), [""; 0]);
        scene.strands[0].varying = vec![(Parameter::G, Values::Constant([0.5; 3]))];
        assert!(super::dropped(&scene, &path).iter().any(|what| what == "values of g"));
        scene.strands.push(scene.strands[0].clone());
        assert!(matches!(write(&scene, &path, 2), Err(Error::SeveralStrands(2))));
        assert!(matches!(write(&read, folder.path().join("lock.hair/a.hair"), 1), Err(Error::Write { .. })));
    }
}
