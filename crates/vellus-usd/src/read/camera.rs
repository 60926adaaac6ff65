//! Reads cameras (UsdGeomCamera).

use crate::error::Error;
use crate::read::context::Reader;
use crate::read::settings::Settings;
use crate::read::xform::{self, Place, rigid};
use crate::stage::Clock;
use crate::warning::Fault;
use glam::DMat4;
use std::collections::HashSet;
use vellus_scene::Camera;

/// The path of the camera with this name or path. Without a name, the camera of the settings, or the first camera.
pub(crate) fn choose(
    reader: &mut Reader,
    paths: &[String],
    name: Option<&str>,
    settings: &Settings,
) -> Result<Option<String>, Error> {
    let stage = reader.stage;
    if let (None, Some(path)) = (name, &settings.camera) {
        if paths.contains(path) && stage.type_name(path)? == "Camera" {
            return Ok(Some(path.clone()));
        }
        reader.warnings.add(path, "the camera of the RenderSettings does not exist: the first camera is used");
    }
    for path in paths {
        let is_wanted = name.is_none_or(|name| path == name || path.rsplit('/').next() == Some(name));
        if is_wanted && stage.type_name(path)? == "Camera" {
            return Ok(Some(path.clone()));
        }
    }
    Ok(None)
}

/// When the shutter of a camera opens and closes, in time codes relative to the frame. A shutter that is not valid is
/// an error if the user named the camera, otherwise a warning.
pub(crate) fn shutter(reader: &mut Reader, camera: &str, settings: &Settings) -> Result<[f64; 2], Error> {
    let prim = reader.prim(camera)?;
    let read = || {
        let [open, close] = [prim.number("shutter:open", 0.0)?, prim.number("shutter:close", 0.0)?];
        if open <= close {
            return Ok([open, if settings.is_instantaneous { open } else { close }]);
        }
        Err(prim.error(format!("the shutter opens at {open} and closes at {close}: it must not close before")))
    };
    match read() {
        Err(error) if reader.options.camera.is_none() => {
            reader.fault(Fault::Prim, camera, error, "the picture has no motion blur")?;
            Ok([0.0; 2])
        }
        shutter => shutter,
    }
}

/// The cameras of the frames before: see [`Reading::earlier`](crate::Reading::earlier). `places` are those of the
/// frame.
pub(crate) fn earlier(
    reader: &mut Reader,
    places: &[Place],
    chosen: Option<&str>,
    settings: &Settings,
) -> Result<Vec<Camera>, Error> {
    let (stage, mut cameras) = (reader.stage, Vec::new());
    let clock = stage.clock();
    let Some(chosen) = chosen.filter(|_| reader.scene.camera.is_some()) else { return Ok(cameras) };
    if reader.options.earlier == 0 || clock.is_timeless() || stage.varies() {
        return Ok(cameras);
    }
    // Only these have other places in other frames. Those of their ancestors are a part of theirs.
    let moving = |place: &&Place| place.varies || place.path == chosen;
    let mut needed: HashSet<&str> = HashSet::new();
    for place in places.iter().filter(moving) {
        let ends = place.path.match_indices('/').map(|(end, _)| end).chain([place.path.len()]);
        needed.extend(ends.map(|end| &place.path[..end]));
    }
    let now: Vec<&Place> = places.iter().filter(|place| needed.contains(place.path.as_str())).collect();
    let paths: Vec<String> = now.iter().map(|place| place.path.clone()).collect();
    // The frame itself has the warnings about the camera and the transforms.
    let warnings = std::mem::take(&mut reader.warnings);
    for k in 1..=reader.options.earlier {
        let [frame, open, close] = [clock.frame, clock.open, clock.close].map(|time| time - k as f64);
        stage.set_clock(Clock { frame, open, close });
        let before = xform::places(reader, &paths)?;
        if !before.iter().zip(&now).all(|(before, now)| before.is_like(now)) {
            break;
        }
        let Some(place) = before.iter().find(|place| place.path == chosen) else { break };
        let Ok(Some(camera)) = read(reader, place, settings) else { break };
        cameras.push(camera);
    }
    reader.warnings = warnings;
    stage.set_clock(clock);
    Ok(cameras)
}

/// Reads a perspective camera. Returns `None` with a warning for other projections.
pub(crate) fn read(reader: &mut Reader, place: &Place, settings: &Settings) -> Result<Option<Camera>, Error> {
    let prim = place.path.as_str();
    let handle = reader.prim(prim)?;
    let get = |name, fallback| handle.number(name, fallback);
    // Default values of the schema. Focal length and apertures are in tenths of a scene unit, the focus distance is in
    // scene units.
    let focal_length = get("focalLength", 50.0)?;
    let width = get("horizontalAperture", 20.955)?;
    let height = get("verticalAperture", 15.2908)?;
    let f_stop = get("fStop", 0.0)?;
    let focus_distance = get("focusDistance", 0.0)?;
    let offsets = [get("horizontalApertureOffset", 0.0)?, get("verticalApertureOffset", 0.0)?];
    let projection = reader.stage.words(prim, "projection")?.unwrap_or_default();
    if projection.first().is_some_and(|p| p != "perspective") {
        reader.left_out.insert(prim.to_owned());
        reader.warnings.add(prim, "only perspective cameras are supported: this camera is ignored");
        return Ok(None);
    }
    if get("exposure", 0.0)? != 0.0 {
        reader.warnings.add(prim, "the camera's exposure is not supported and is ignored");
    }
    if focal_length <= 0.0 || width <= 0.0 || height <= 0.0 || f_stop < 0.0 {
        let what =
            "focalLength, horizontalAperture and verticalAperture must be positive, and fStop must not be negative";
        return Err(Error::prim(prim, what));
    }
    // An fStop of 0 means a pinhole.
    let has_lens = f_stop > 0.0 && focus_distance > 0.0 && !settings.is_pinhole;
    if f_stop > 0.0 && focus_distance <= 0.0 {
        reader.warnings.add(prim, "fStop has no effect without a positive focusDistance");
    }
    reader.focal_length = Some(0.1 * focal_length);
    let to_world = rigid(&place.to_world);
    let moved = rigid(&place.moved);
    let single = |matrix: DMat4| matrix.as_mat4();
    let camera = Camera {
        to_world: single(to_world),
        moved: (moved != to_world).then(|| single(moved)),
        film_width: (width / focal_length) as f32,
        film_height: (height / focal_length) as f32,
        shift: offsets.map(|offset| (offset / focal_length) as f32),
        fit: settings.fit,
        lens_radius: if has_lens { (0.05 * focal_length / f_stop) as f32 } else { 0.0 },
        focus_distance: if focus_distance > 0.0 { focus_distance as f32 } else { 1.0 },
    };
    match camera.validate() {
        Err(vellus_scene::Error::Invalid { what, .. }) => Err(Error::prim(prim, what)),
        Err(error) => Err(error.into()),
        Ok(()) => Ok(Some(camera)),
    }
}
