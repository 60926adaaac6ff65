//! Writes a scene as .usda.

mod geometry;
mod look;
mod names;
pub(crate) mod text;

use crate::error::Error;
use crate::image::{UDIM, encode_exr, split, tile_name};
use crate::write::geometry::{camera, instance, light, mesh, settings, strands};
use crate::write::look::{look, surface};
use crate::write::names::{Names, object_paths};
use crate::write::text::{Literal, Text};
use std::collections::HashSet;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use vellus_scene::{Fit, Scene, Wrap};

/// Writes a scene as text (.usda), and its textures as OpenEXR into the folder `NAME-textures` next to it. An image of
/// tiles becomes one file for each tile.
///
/// [`crate::read()`] restores the same scene, except that:
/// - the last bit of angles and of the lens radius may differ;
/// - textures of lights have the wrap mode repeat;
/// - textures have the names of their files, and quotes, backslashes and control characters in names are replaced;
/// - prototypes are in the order of their first use, unused ones are missing, and names are those of their first
///   instance. [`crate::Options::instances`] must be set, otherwise instances become copies;
/// - [`Scene::background`] is missing: USD has no place for it;
/// - light groups are those of [`Scene::light_group_names`];
/// - looks, surfaces and textures are in the order of their first use, and unused ones are missing.
///
/// Motion is from time code 0 to 1, which is also the shutter of the camera. Without a camera, reading needs
/// [`crate::Options::shutter`]. Files are written by [`vellus_io::write()`], so a failure leaves the previous file.
/// Missing folders are created.
///
/// # Errors
/// [`Error::Scene`] if the scene is not valid. [`Error::File`] if the name does not end in `.usda`. [`Error::Write`] if
/// a file cannot be written.
pub fn write(scene: &Scene, file: &Path) -> Result<(), Error> {
    scene.validate()?;
    if file.extension().is_none_or(|extension| extension != "usda") {
        return Err(Error::file(file, "scenes are written as text: the name must end in .usda"));
    }
    let wraps = scene.textures.iter().map(|texture| texture.wrap).collect();
    let names = Names { textures: textures(scene, file)?, wraps, ..Names::default() };
    vellus_io::write_with(file, |out| stage(scene, names, Text::new(out))).map_err(|error| Error::write(file, error))
}

/// Writes a scene without textures as text (.usda), as [`write()`] does.
///
/// # Errors
/// [`Error::Scene`] if the scene is not valid, and [`Error::Write`] with the errors of `out`, or for textures: they
/// have no place beside the text.
pub fn write_text(scene: &Scene, out: &mut dyn Write) -> Result<(), Error> {
    scene.validate()?;
    let written = match scene.textures.len() {
        0 => stage(scene, Names::default(), Text::new(out)),
        count => Err(io::Error::new(io::ErrorKind::InvalidInput, format!("{count} textures need files of their own"))),
    };
    written.map_err(|error| Error::write(Path::new("the text"), error))
}

/// Writes the textures. Returns their paths relative to the stage.
fn textures(scene: &Scene, file: &Path) -> Result<Vec<String>, Error> {
    if scene.textures.is_empty() {
        return Ok(Vec::new());
    }
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    // These characters would end the path of an asset, or change its folder.
    let plain = |name: &str| name.replace(|c: char| "@/\\[]<>".contains(c) || c.is_control(), "_");
    let folder = format!("{}-textures", plain(&stem));
    let folder_path = file.with_file_name(&folder);
    std::fs::create_dir_all(&folder_path).map_err(|error| Error::write(&folder_path, error))?;
    let mut taken = HashSet::new();
    let mut names = Vec::new();
    for texture in &scene.textures {
        let wish = Path::new(&texture.name).file_stem().map_or("texture".into(), |stem| stem.to_string_lossy());
        let tile = if matches!(texture.wrap, [Wrap::Tiles(_), _]) { format!(".{UDIM}") } else { String::new() };
        let wish = plain(wish.trim_end_matches(UDIM).trim_end_matches('.'));
        let mut name = format!("{wish}{tile}.exr");
        let mut number = 2;
        // Some file systems do not distinguish upper and lower case.
        while !taken.insert(name.to_lowercase()) {
            name = format!("{wish}_{number}{tile}.exr");
            number += 1;
        }
        for (number, tile) in split(texture) {
            let path: PathBuf = folder_path.join(tile_name(&name, number));
            let bytes = encode_exr(&tile).map_err(|what| Error::file(&path, what))?;
            vellus_io::write(&path, &bytes).map_err(|error| Error::write(&path, error))?;
        }
        names.push(format!("./{folder}/{name}"));
    }
    Ok(names)
}

fn stage<W: Write>(scene: &Scene, mut names: Names, mut text: Text<W>) -> io::Result<()> {
    let moves = scene.all_strands().any(|s| s.moved.is_some())
        || scene.meshes.iter().chain(scene.prototypes.iter().flat_map(|p| &p.meshes)).any(|m| m.moved.is_some())
        || scene.camera.is_some_and(|c| c.moved.is_some());
    text.line("#usda 1.0")?;
    text.line("(")?;
    text.line("    defaultPrim = \"Scene\"")?;
    text.line("    doc = \"Written by vellus\"")?;
    if moves {
        text.line("    endTimeCode = 1")?;
    }
    if let Some(units) = &scene.units {
        text.line(&format!("    metersPerUnit = {}", units.meters_per_unit.text()))?;
    }
    if moves {
        text.line("    startTimeCode = 0")?;
    }
    let z_up = scene.units.is_some_and(|units| units.z_up);
    text.line(&format!("    upAxis = \"{}\"", if z_up { "Z" } else { "Y" }))?;
    text.line(")")?;
    text.line("")?;
    let root = text.name("", "Scene");
    text.open("Xform", &root, "")?;
    text.open("Scope", "Looks", "")?;
    for item in &scene.looks {
        let path = look(&mut text, item, &names)?;
        names.looks.push(path);
    }
    for item in &scene.surfaces {
        let path = surface(&mut text, item, &names)?;
        names.surfaces.push(path);
    }
    text.close()?;
    if let Some(item) = &scene.camera {
        camera(&mut text, item, moves)?;
        // The default of USD needs no words.
        if item.fit != Fit::Expand {
            settings(&mut text, item.fit)?;
        }
    }
    if !scene.links.is_empty() {
        names.objects = object_paths(scene);
    }
    for (i, (item, group)) in scene.lights.iter().zip(scene.light_group_names()).enumerate() {
        let shaping = scene.shapings.iter().find(|(index, _)| *index == i).map(|(_, shaping)| shaping);
        let link = scene.links.iter().find(|(index, _)| *index == i).map(|(_, link)| link);
        light(&mut text, item, &group, !scene.unseen_lights.contains(&i), shaping, link, &names)?;
    }
    for item in &scene.meshes {
        mesh(&mut text, "/Scene", item, &names)?;
    }
    for item in &scene.strands {
        strands(&mut text, "/Scene", item, &names)?;
    }
    let classes: Vec<String> = scene.prototypes.iter().map(|item| text.name("", &item.name)).collect();
    for item in &scene.instances {
        instance(&mut text, item, &scene.prototypes[item.prototype].name, &format!("/{}", classes[item.prototype]))?;
    }
    text.close()?;
    for (item, class) in scene.prototypes.iter().zip(&classes) {
        let path = format!("/{class}");
        text.open_class(class)?;
        for item in &item.meshes {
            mesh(&mut text, &path, item, &names)?;
        }
        for item in &item.strands {
            strands(&mut text, &path, item, &names)?;
        }
        text.close()?;
    }
    text.finish().map(|_| ())
}
