//! Writes a scene as text (.usda) or binary (.usdc).

pub(crate) mod crate_file;
pub(crate) mod custom;
pub(crate) mod encoder;
mod geometry;
mod look;
pub(crate) mod names;
pub(crate) mod text;
mod value;

use crate::error::Error;
use crate::image::{UDIM, encode_exr, encode_profile, split, tile_name};
use crate::write::encoder::{Encoder, Role};
use crate::write::geometry::{camera, instance, light, mesh, settings, strands};
use crate::write::look::{look, surface};
use crate::write::names::{Names, object_paths};
use crate::write::text::Text;
use crate::write::value::{Token, Value, Words};
use std::collections::HashSet;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use vellus_scene::{Custom, Fit, Scene, Wrap};

/// A format of USD.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Text, `.usda`.
    Text,
    /// Binary, `.usdc`: smaller and faster. OpenUSD calls it a crate file. Version 0.8, which OpenUSD 20.11 reads.
    Crate,
}

impl Format {
    /// The format that the extension of a file names: `usda` or `usdc`.
    pub fn of(file: &Path) -> Option<Self> {
        match file.extension()?.to_str()? {
            "usda" => Some(Format::Text),
            "usdc" => Some(Format::Crate),
            _ => None,
        }
    }
}

/// Writes a scene in the format that the extension names, and its textures as OpenEXR into the folder `NAME-textures`
/// next to it, profiles of lights as IES. An image of tiles becomes one file for each tile.
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
/// [`Error::Scene`] if the scene is not valid. [`Error::File`] if the name does not end in `.usda` or `.usdc`.
/// [`Error::Write`] if a file cannot be written.
pub fn write(scene: &Scene, file: &Path) -> Result<(), Error> {
    scene.validate()?;
    let format = Format::of(file).ok_or_else(|| Error::file(file, "the name must end in .usda or .usdc"))?;
    let names = Names::new(textures(scene, file)?, scene.textures.iter().map(|texture| texture.wrap).collect());
    vellus_io::write_with(file, |out| encode(scene, &names, format, out)).map_err(|error| Error::write(file, error))
}

/// Writes a scene without textures, as [`write()`] does.
///
/// # Errors
/// [`Error::Scene`] if the scene is not valid, and [`Error::Write`] with the errors of `out`, or for textures: they
/// have no place beside the stage.
pub fn write_to(scene: &Scene, format: Format, out: &mut dyn Write) -> Result<(), Error> {
    scene.validate()?;
    let written = match scene.textures.len() {
        0 => encode(scene, &Names::default(), format, out),
        count => Err(io::Error::new(io::ErrorKind::InvalidInput, format!("{count} textures need files of their own"))),
    };
    written.map_err(|error| Error::write(Path::new("the stage"), error))
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
    let profiles = scene.lights.iter().filter_map(|light| Some(light.shaping.as_ref()?.profile?.texture));
    let profiles: HashSet<usize> = profiles.collect();
    for (index, texture) in scene.textures.iter().enumerate() {
        let wish = Path::new(&texture.name).file_stem().map_or("texture".into(), |stem| stem.to_string_lossy());
        let tile = if matches!(texture.wrap, [Wrap::Tiles(_), _]) { format!(".{UDIM}") } else { String::new() };
        let wish = plain(wish.trim_end_matches(UDIM).trim_end_matches('.'));
        let kind = if profiles.contains(&index) { "ies" } else { "exr" };
        let mut name = format!("{wish}{tile}.{kind}");
        let mut number = 2;
        // Some file systems do not distinguish upper and lower case.
        while !taken.insert(name.to_lowercase()) {
            name = format!("{wish}_{number}{tile}.{kind}");
            number += 1;
        }
        if profiles.contains(&index) {
            let path = folder_path.join(&name);
            let text = encode_profile(texture);
            vellus_io::write(&path, text.as_bytes()).map_err(|error| Error::write(&path, error))?;
            names.push(format!("./{folder}/{name}"));
            continue;
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

fn encode(scene: &Scene, names: &Names, format: Format, out: &mut dyn Write) -> io::Result<()> {
    let fill = |encoder: &mut dyn Encoder| stage(scene, names.clone(), encoder);
    match format {
        Format::Text => fill(&mut Text::new(&mut *out))?,
        Format::Crate => crate_file::write(&mut *out, fill)?,
    }
    out.flush()
}

fn stage(scene: &Scene, mut names: Names, out: &mut dyn Encoder) -> io::Result<()> {
    let moves = scene.all_strands().any(|s| s.moved.is_some())
        || scene.meshes.iter().chain(scene.prototypes.iter().flat_map(|p| &p.meshes)).any(|m| m.moved.is_some())
        || scene.camera.is_some_and(|c| c.moved.is_some());
    let units = scene.units.as_ref();
    let up = Token(if units.is_some_and(|units| units.z_up) { "Z" } else { "Y" });
    let mut fields: Vec<(&str, &dyn Value)> =
        vec![("defaultPrim", &Token("Scene")), ("doc", &Words("Written by vellus")), ("upAxis", &up)];
    if let Some(units) = units {
        fields.push(("metersPerUnit", &units.meters_per_unit));
    }
    if moves {
        fields.extend([("startTimeCode", &0.0f64 as &dyn Value), ("endTimeCode", &1.0f64)]);
    }
    out.layer(&fields)?;
    out.open("Xform", &names.unused("", "Scene"), Role::Plain)?;
    out.open("Scope", &names.unused("/Scene", "Looks"), Role::Plain)?;
    for item in &scene.looks {
        let path = look(out, item, &mut names)?;
        names.looks.push(path);
    }
    for item in &scene.surfaces {
        let path = surface(out, item, &mut names)?;
        names.surfaces.push(path);
    }
    out.close()?;
    if let Some(item) = &scene.camera {
        camera(out, item, moves, &mut names)?;
        // The default of USD needs no words.
        if item.fit != Fit::Expand {
            settings(out, item.fit, &mut names)?;
        }
    }
    if scene.is_linked() {
        names.objects = object_paths(scene, names.clone());
    }
    for (item, group) in scene.lights.iter().zip(scene.light_group_names()) {
        light(out, item, &group, &mut names)?;
    }
    for item in &scene.meshes {
        mesh(out, "/Scene", item, &mut names)?;
    }
    for (i, item) in scene.strands.iter().enumerate() {
        let custom: Vec<&Custom> = scene.custom.iter().filter(|custom| custom.strands == i).collect();
        strands(out, "/Scene", item, &custom, &mut names)?;
    }
    let classes: Vec<String> = scene.prototypes.iter().map(|item| names.unused("", &item.name)).collect();
    for item in &scene.instances {
        let class = format!("/{}", classes[item.prototype]);
        instance(out, item, &scene.prototypes[item.prototype].name, &class, &mut names)?;
    }
    out.close()?;
    for (item, class) in scene.prototypes.iter().zip(&classes) {
        let path = format!("/{class}");
        out.open("", class, Role::Class)?;
        for item in &item.meshes {
            mesh(out, &path, item, &mut names)?;
        }
        for item in &item.strands {
            strands(out, &path, item, &[], &mut names)?;
        }
        out.close()?;
    }
    Ok(())
}
