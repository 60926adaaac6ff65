//! Writes scenes.

pub use crate::alembic::write::Flavor;
use crate::{Error, alembic};
use std::collections::BTreeSet;
use std::path::Path;
use vellus_scene::{Custom, Parameter, Scene, Values};

/// How a scene is written.
#[derive(Clone, Copy, Debug)]
pub struct Writing {
    /// Straight segments in a .hair file for each curved one, at least 1.
    pub pieces: usize,
    /// Names and types of attributes in an Alembic archive.
    pub flavor: Flavor,
}

impl Default for Writing {
    fn default() -> Self {
        Writing { pieces: 1, flavor: Flavor::Plain }
    }
}

/// Writes a scene: with the extension `hair` its strands, with `abc` its geometry and camera, otherwise the whole scene
/// as USD, `.usda` or `.usdc`.
///
/// # Errors
/// [`Error::SeveralStrands`] or [`Error::Unwritable`] if a .hair file cannot hold the strands. [`Error::Write`] or
/// [`Error::Usd`] if the file cannot be written.
pub fn write(scene: &Scene, path: impl AsRef<Path>, Writing { pieces, flavor }: Writing) -> Result<(), Error> {
    let path = path.as_ref();
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("hair") => {}
        Some("abc") => return alembic::write::write(scene, path, flavor),
        _ => return Ok(vellus_usd::write(scene, path)?),
    }
    let [strands] = &scene.strands[..] else { return Err(Error::SeveralStrands(scene.strands.len())) };
    let bytes = vellus_groom::write_hair(&vellus_groom::flatten(strands, pieces));
    let bytes = bytes.map_err(|error| Error::Unwritable { path: path.to_owned(), what: error.to_string() })?;
    vellus_io::write(path, &bytes).map_err(|source| Error::Write { path: path.to_owned(), source })
}

/// What a file that [`write()`] made does not have. A .hair file has positions, widths and colours only; an archive has
/// no fibres, units, lights and surfaces, and with [`Flavor::Unreal`] no meshes and no camera.
pub fn dropped(scene: &Scene, path: impl AsRef<Path>, flavor: Flavor) -> Vec<String> {
    let extension = path.as_ref().extension().and_then(|extension| extension.to_str());
    let lost = |lost: fn(&Custom) -> bool| {
        let names: BTreeSet<&str> = scene.custom.iter().filter(|c| lost(c)).map(|c| c.name.as_str()).collect();
        names.into_iter().map(|name| format!("the attribute {name}")).collect::<Vec<String>>()
    };
    if !matches!(extension, Some("hair" | "abc")) {
        return lost(|custom| !vellus_usd::fits(custom));
    }
    let is_hair = extension == Some("hair");
    let is_bare = is_hair || flavor == Flavor::Unreal;
    let count = |count: usize, one: &str, many: &str| match count {
        0 => None,
        1 => Some(one.to_owned()),
        count => Some(format!("the {count} {many}")),
    };
    let mut dropped: Vec<String> =
        scene.strands.iter().map(|strands| format!("the fibre {}", scene.looks[strands.look].name)).collect();
    if is_hair {
        dropped.extend(lost(|_| true));
    }
    for strands in scene.strands.iter().filter(|_| is_hair) {
        dropped.extend(strands.root_uv.as_ref().map(|_| "the uv of the roots".to_owned()));
        dropped.extend(strands.moved.as_ref().map(|_| "the motion".to_owned()));
        dropped.extend(strands.normals.as_ref().map(|_| "the normals".to_owned()));
        let is_kept = |(parameter, values): &&(Parameter, _)| {
            *parameter == Parameter::Reflectance && matches!(values, Values::PerPoint(_))
        };
        let varying = strands.varying.iter().filter(|varying| !is_kept(varying));
        dropped.extend(varying.map(|(parameter, _)| format!("values of {}", parameter.name())));
    }
    dropped.extend(scene.units.map(|_| "the units".to_owned()));
    dropped.extend(scene.camera.filter(|_| is_bare).map(|_| "the camera".to_owned()));
    let lens = scene.camera.filter(|camera| !is_bare && camera.lens_radius > 0.0);
    dropped.extend(lens.map(|_| "the depth of field".to_owned()));
    dropped.extend(count(if is_bare { scene.meshes.len() } else { 0 }, "the mesh", "meshes"));
    dropped.extend(count(if is_bare { 0 } else { scene.surfaces.len() }, "the surface", "surfaces"));
    dropped.extend(count(scene.lights.len(), "the light", "lights"));
    dropped.extend(count(if is_hair { scene.instances.len() } else { 0 }, "the instance", "instances"));
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
        write(&scene, &path, Writing { pieces: 2, ..Writing::default() }).unwrap();
        let read = open(&path, &Options::default()).unwrap().scene;
        assert_eq!(read.strands[0].len(), scene.strands[0].len());
        let dropped = super::dropped(&scene, &path, Flavor::Plain);
        for part in ["the fibre hair", "the units", "the camera"] {
            assert!(dropped.iter().any(|what| what == part), "{part}: {dropped:?}");
        }
        assert_eq!(super::dropped(&scene, "lock.usda", Flavor::Plain), [""; 0]);
        scene.strands[0].varying = vec![(Parameter::G, Values::Constant([0.5; 3]))];
        assert!(super::dropped(&scene, &path, Flavor::Plain).iter().any(|what| what == "values of g"));
        scene.strands.push(scene.strands[0].clone());
        assert!(matches!(write(&scene, &path, Writing::default()), Err(Error::SeveralStrands(2))));
        assert!(matches!(
            write(&read, folder.path().join("lock.hair/a.hair"), Writing::default()),
            Err(Error::Write { .. })
        ));
    }
}
