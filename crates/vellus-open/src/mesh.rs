//! Meshes to grow on, and the images of what grows.

use crate::{Error, Format, Opened, Options, Warning, alembic, read};
use std::path::Path;
use vellus_groom::{Coat, Group};
use vellus_io::Sources;
use vellus_scene::{Look, Mesh, Scene, Surface, Texture};

/// The reflectance of a mesh whose file has no colours.
const SKIN: [f32; 3] = [0.18; 3];

/// Opens a scene with meshes: a USD file, an Alembic archive or an .obj file.
///
/// Strands without widths are left out, and a warning names them. The meshes of an .obj file get the surface `skin`.
///
/// # Errors
/// [`Error::Read`], [`Error::Strands`], [`Error::Usd`], [`Error::Alembic`] or [`Error::Empty`] if the file cannot be
/// read or is invalid.
pub fn open_mesh(path: impl AsRef<Path>) -> Result<Opened, Error> {
    let path = path.as_ref();
    if is_obj(path) {
        let mut sources = Sources::new();
        let meshes = vellus_groom::read_obj(&read(path, ".obj", &mut sources)?, &path.display().to_string())?;
        let scene = Scene {
            meshes,
            surfaces: vec![Surface { skin: true, ..Surface::diffuse("skin", SKIN) }],
            ..Scene::default()
        };
        return Ok(Opened { scene, sources, ..Opened::default() });
    }
    let (mut scene, mut warnings, sources) = if matches!(Format::of(path), Ok(Format::Alembic)) {
        let Opened { scene, warnings, sources, .. } = alembic::open(path, &Options::default(), Some(0.0))?;
        (scene, warnings, sources)
    } else {
        let options = vellus_usd::Options { default_width: Some(0.0), ..Default::default() };
        let vellus_usd::Reading { scene, warnings, sources, .. } = vellus_usd::read(path, &options)?;
        (scene, warnings.into_iter().map(Warning::Usd).collect::<Vec<_>>(), sources)
    };
    scene.strands.retain(|strands| {
        let has_width = strands.points.iter().any(|p| p.w > 0.0);
        if !has_width {
            warnings.push(Warning::NoWidths(strands.name.clone()));
        }
        has_width
    });
    Ok(Opened { scene, sources, warnings, ..Opened::default() })
}

/// Whether a file has the extension of Wavefront's format.
pub(crate) fn is_obj(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("obj"))
}

/// The indices of meshes by their names, or by the ends of their paths; in order, each once. Without names, the scene
/// must have exactly one mesh.
///
/// # Errors
/// [`Error::NoMesh`], [`Error::SeveralMeshes`], [`Error::UnknownMesh`].
pub fn choose_meshes(scene: &Scene, names: &[String]) -> Result<Vec<usize>, Error> {
    let known = || scene.meshes.iter().map(|mesh| mesh.name.as_str()).collect::<Vec<_>>().join(", ");
    if names.is_empty() {
        return match scene.meshes.len() {
            0 => Err(Error::NoMesh),
            1 => Ok(vec![0]),
            count => Err(Error::SeveralMeshes { count, known: known() }),
        };
    }
    let find = |name: &String| {
        let is_it = |mesh: &Mesh| mesh.name == *name || mesh.name.ends_with(&format!("/{name}"));
        let index = scene.meshes.iter().position(is_it);
        index.ok_or_else(|| Error::UnknownMesh { name: name.clone(), known: known() })
    };
    let mut chosen: Vec<usize> = names.iter().map(find).collect::<Result<_, _>>()?;
    chosen.sort_unstable();
    chosen.dedup();
    Ok(chosen)
}

/// A group of strands with its fibre, its images, and what a user should know about these images.
///
/// # Errors
/// [`Error::Usd`] if an image cannot be read or is invalid.
pub fn open_coat(group: Group, look: Look) -> Result<(Coat, Vec<Warning>), Error> {
    let mut warnings = Vec::new();
    let mut keep = |(image, warning): (Texture, Option<vellus_usd::Warning>)| {
        warnings.extend(warning.map(Warning::Usd));
        image
    };
    let density = group.density_map.as_deref().map(vellus_usd::load_map).transpose()?.map(&mut keep);
    let length = group.length_map.as_deref().map(vellus_usd::load_map).transpose()?.map(&mut keep);
    let color = group.color.as_deref().map(vellus_usd::load_texture).transpose()?.map(&mut keep);
    Ok((Coat { look, density, length, color, group }, warnings))
}
