//! The camera of an archive.

use super::Reader;
use super::place::{Place, places, rigid};
use crate::Error;
use std::path::Path;
use vellus_alembic::Camera;
use vellus_scene::Fit;

/// The camera with this name or path, or the first one. `None` with a warning if it cannot be read.
pub(super) fn find(reader: &mut Reader, path: &Path, name: Option<&str>) -> Result<Option<(Place, Camera)>, Error> {
    let archive = reader.archive;
    let is_wanted = |path: &str| name.is_none_or(|name| path == name || path.rsplit('/').next() == Some(name));
    let mut all = places(archive, reader.times).0.into_iter();
    let place = all.find(|place| place.has_schema(archive, Camera::SCHEMA) && is_wanted(&place.path));
    let Some(place) = place else {
        let missing = name.map(|name| Error::NoCamera { path: path.to_owned(), name: name.to_owned() });
        return missing.map_or(Ok(None), Err);
    };
    match Camera::read(archive, &archive.objects[place.object], reader.times[0]) {
        Ok(camera) => Ok(Some((place, camera))),
        Err(error) => {
            reader.note(&place, Some(format!("left out: {error}")));
            Ok(None)
        }
    }
}

/// The camera of the picture. `None` with a warning if it is not valid.
pub(super) fn shown(reader: &mut Reader, place: &Place, camera: &Camera) -> Option<vellus_scene::Camera> {
    // The aperture is in centimetres, the focal length in millimetres.
    let film = |aperture: f64| (10.0 * aperture / camera.focal_length) as f32;
    let (to_world, moved) = (rigid(&place.to_world), rigid(&place.moved));
    let found = vellus_scene::Camera {
        to_world,
        moved: (moved != to_world).then_some(moved),
        film_width: film(camera.horizontal_aperture * camera.lens_squeeze_ratio),
        film_height: film(camera.vertical_aperture),
        shift: [film(camera.horizontal_film_offset * camera.lens_squeeze_ratio), film(camera.vertical_film_offset)],
        // As Houdini and Blender do: Blender writes the height of the sensor, not that of the picture.
        fit: Fit::AdjustHeight,
        // The unit of the scene is not known, so neither is the size of the lens.
        lens_radius: 0.0,
        focus_distance: 1.0,
    };
    match found.validate() {
        Ok(()) => Some(found),
        Err(error) => {
            reader.note(place, Some(format!("left out: {error}")));
            None
        }
    }
}
