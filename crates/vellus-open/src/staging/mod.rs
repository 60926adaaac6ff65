//! Staging: camera, lights and background for files without them.

mod options;
mod studio;

pub use options::{Backdrop, Lighting, Staging};

use crate::mesh::is_obj;
use crate::{Error, Opened, Warning, open_mesh, read};
use glam::Vec3;
use std::path::Path;
use studio::Studio;
use vellus_scene::{Scene, Tint, View};

/// A mesh more than this many times larger than the groom counts as a set, and brings its own ground.
const SET: f32 = 3.0;

/// Width over height of a picture if nothing says it.
const ASPECT: f32 = 1.5;

/// The reflectance of a grey card, and the background where the camera sees past the ground.
const GREY: [f32; 3] = [0.18; 3];

/// Adds a body, a camera, lights and a background to a scene that was opened. The bounds of `still`, or of the scene
/// itself, place camera and lights.
///
/// # Errors
/// [`Error::Read`], [`Error::Strands`] or [`Error::Usd`] if the body or an image cannot be read or is invalid.
pub(crate) fn stage(opened: &mut Opened, staging: &Staging, built_in: bool, still: Option<Scene>) -> Result<(), Error> {
    let mut still = still.map(|scene| Opened { scene, ..Opened::default() });
    if let Some(body) = &staging.body {
        add_body(opened, body)?;
        still.as_mut().map_or(Ok(()), |still| add_body(still, body))?;
    }
    let scene = &mut opened.scene;
    // The still keeps its own camera, which may move, so lights and backdrop are placed for its view.
    let still = still.map(|still| still.scene);
    if built_in && staging.background.is_some() {
        remove_ground(scene);
    }
    let is_lit = is_lit(scene);
    let light = staging.light.clone().or((!is_lit).then_some(Lighting::Studio));
    let subject = still.as_ref().unwrap_or(scene);
    let (up, front) = (subject.up(), subject.front());
    let camera = scene.camera.filter(|_| staging.view.is_none());
    let view = staging.view.unwrap_or_default();
    let resolution = opened.settings.and_then(|settings| settings.size).map(|[w, h]| w as f32 / h as f32);
    let aspect = staging.aspect.or(resolution);
    let framed = subject.framing_along(view.toward_camera(front, up), aspect.unwrap_or(ASPECT)).map(|mut camera| {
        camera.film_width /= view.zoom;
        camera.film_height /= view.zoom;
        camera
    });
    let Some(camera) = camera.or(framed) else { return Ok(()) };
    let had_camera = scene.camera.is_some();
    let studio =
        Studio::new(subject, &subject.camera.filter(|_| had_camera && staging.view.is_none()).unwrap_or(camera));
    scene.camera = Some(camera);
    if let Some(light) = &light {
        scene.lights.clear();
        studio.light(scene, light);
        if let Lighting::Image(path) = light {
            read(path, "light", &mut opened.sources)?;
            let (image, warnings) = vellus_usd::load_sky(path)?;
            opened.warnings.extend(warnings.into_iter().map(Warning::Usd));
            studio.image(&mut opened.scene, image);
        } else if staging.background.is_none() {
            scene.background = Some(Tint { color: GREY, texture: None });
            if !has_set(scene) {
                studio.add_cyclorama(scene, &camera, aspect.unwrap_or(camera.aspect()));
            }
        }
        opened.is_metered = true;
    }
    match &staging.background {
        Some(Backdrop::Color(color)) => opened.scene.background = Some(Tint { color: *color, texture: None }),
        Some(Backdrop::Transparent) => opened.scene.background = Some(Tint { color: [0.0; 3], texture: None }),
        Some(Backdrop::Image(path)) => {
            read(path, "background", &mut opened.sources)?;
            let (image, warning) = vellus_usd::load_texture(path)?;
            opened.warnings.extend(warning.map(Warning::Usd));
            let texture = Some(opened.scene.textures.len());
            opened.scene.textures.push(image);
            opened.scene.background = Some(Tint { color: [1.0; 3], texture });
        }
        None => {}
    }
    if !built_in && (!had_camera || !is_lit) {
        opened.staged = Some(describe((!had_camera).then_some((view, front)), light.filter(|_| !is_lit)));
    }
    Ok(())
}

/// Whether lights or meshes emit light.
fn is_lit(scene: &Scene) -> bool {
    !scene.lights.is_empty() || scene.surfaces.iter().any(|s| s.emission.iter().any(|&e| e > 0.0))
}

impl Staging {
    /// Whether a scene from a file gets a camera or lights.
    pub(crate) fn is_needed(&self, scene: &Scene) -> bool {
        scene.camera.is_none() || self.view.is_some() || self.light.is_some() || !is_lit(scene)
    }
}

/// One line about what was added to a file without a camera or lights.
fn describe(camera: Option<(View, Vec3)>, light: Option<Lighting>) -> String {
    let axes = [(Vec3::X, "x"), (Vec3::Y, "y"), (Vec3::Z, "z")];
    let axis = |v: Vec3| axes.iter().find(|(a, _)| a.dot(v).abs() > 0.5).map_or("z", |(_, name)| name);
    let camera = camera.map(|(View { yaw, pitch, .. }, front)| {
        let sign = if front.element_sum() < 0.0 { '-' } else { '+' };
        format!("no camera: it looks from {yaw},{pitch} at the front, {sign}{} (--view)", axis(front))
    });
    let light = light.map(|light| format!("no lights: the light is {light} (--light)"));
    format!("the file has {}", camera.into_iter().chain(light).collect::<Vec<_>>().join(", and "))
}

/// Adds the meshes of a file to a scene, with their surfaces. Everything else in the file is left out.
fn add_body(opened: &mut Opened, path: &Path) -> Result<(), Error> {
    let body = open_mesh(path)?;
    let scene = &mut opened.scene;
    let (surfaces, textures) = (scene.surfaces.len(), scene.textures.len());
    scene.meshes.extend(body.scene.meshes.into_iter().map(|mut mesh| {
        mesh.surface += surfaces;
        mesh
    }));
    scene.surfaces.extend(body.scene.surfaces.into_iter().map(|mut surface| {
        for texture in [&mut surface.color.texture, &mut surface.opacity.texture] {
            *texture = texture.map(|index| index + textures);
        }
        if let Some(map) = &mut surface.normals {
            map.texture += textures;
        }
        surface
    }));
    scene.textures.extend(body.scene.textures);
    // A USD file brings warnings about its strands and lights, too.
    opened.warnings.extend(body.warnings.into_iter().filter(|_| is_obj(path)));
    body.sources.iter().for_each(|(name, digest)| opened.sources.add_digest(&format!("body/{name}"), digest));
    Ok(())
}

/// Removes the ground and the backdrop of a built-in scene.
fn remove_ground(scene: &mut Scene) {
    let Scene { meshes, surfaces, .. } = scene;
    meshes.retain(|mesh| !matches!(surfaces[mesh.surface].name.as_str(), "ground" | "backdrop"));
}

/// Whether the scene has a ground or a room: meshes that are much larger than its strands in both horizontal
/// directions. A body is large in one of them at most.
fn has_set(scene: &Scene) -> bool {
    let Some((low, high)) = scene.bounds().filter(|_| !scene.strands.is_empty()) else { return false };
    let vertices = || scene.meshes.iter().flat_map(|mesh| &mesh.positions).copied();
    let Some(size) = vertices().reduce(Vec3::max).zip(vertices().reduce(Vec3::min)).map(|(a, b)| a - b) else {
        return false;
    };
    let depth = if scene.up() == Vec3::Z { size.y } else { size.z };
    size.x.min(depth) > SET * (high - low).length()
}
