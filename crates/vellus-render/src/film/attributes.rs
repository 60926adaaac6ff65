//! Notes that OpenEXR has standard attributes for: they get the types of the standard.
//!
//! Source: <https://openexr.com/en/latest/StandardAttributes.html>.

use super::picture::Notes;
use ::exr::prelude::{AttributeValue, LayerAttributes, Text, Vec2};
use glam::{Mat4, Vec4};
use vellus_scene::Camera;

/// The notes about a camera and a picture of this size: `worldToCamera` and `worldToNDC`, 16 numbers for points as
/// rows, `screenWindowWidth` and `screenWindowCenter`. The camera is that of the shutter's opening.
pub fn camera_notes(camera: &Camera, size: [usize; 2]) -> Notes {
    let [width, height] = camera.film(size[0] as f32 / size[1] as f32);
    let [right, up] = camera.shift;
    // The space is left-handed, with the scene on the positive side of z.
    let to_camera = Mat4::from_diagonal(Vec4::new(1.0, 1.0, -1.0, 1.0)) * camera.to_world.inverse();
    // From the upper left corner, 0 to 1. The third coordinate is unused: 1/z keeps the matrix invertible.
    let projection = Mat4::from_cols(
        Vec4::new(1.0 / width, 0.0, 0.0, 0.0),
        Vec4::new(0.0, -1.0 / height, 0.0, 0.0),
        Vec4::new(0.5 - right / width, 0.5 + up / height, 0.0, 1.0),
        Vec4::new(0.0, 0.0, 1.0, 0.0),
    );
    // Columns that are written one after the other are the rows of the transposed matrix.
    let text = |matrix: Mat4| matrix.to_cols_array().map(|x| x.to_string()).join(" ");
    vec![
        ("worldToCamera".to_owned(), text(to_camera)),
        ("worldToNDC".to_owned(), text(projection * to_camera)),
        ("screenWindowWidth".to_owned(), width.to_string()),
        ("screenWindowCenter".to_owned(), format!("{right} {up}")),
    ]
}

/// Adds a note to a header. One whose name is in the standard becomes the attribute of its type, or is left out if its
/// value is none of this type; others become texts.
pub(super) fn add(attributes: &mut LayerAttributes, name: &str, value: &str) {
    let single = || numbers::<1>(value).map(|[x]| x);
    let typed = match name {
        "worldToCamera" => return attributes.world_to_camera = numbers(value),
        "worldToNDC" => return attributes.world_to_normalized_device = numbers(value),
        "screenWindowWidth" => return attributes.screen_window_width = single().unwrap_or(1.0),
        "screenWindowCenter" => {
            let [x, y] = numbers(value).unwrap_or_default();
            return attributes.screen_window_center = Vec2(x, y);
        }
        "focus" => return attributes.focus = single(),
        "aperture" => return attributes.aperture = single(),
        "framesPerSecond" => {
            let rate = value.split_once('/').map(|(over, under)| (over.parse(), under.parse()));
            let rate = rate.and_then(|(over, under)| Some((over.ok()?, under.ok()?)));
            return attributes.frames_per_second = rate;
        }
        "imageCounter" => value.parse().ok().map(AttributeValue::I32),
        "pinholeFocalLength" => single().map(AttributeValue::F32),
        "sensorOverallDimensions" => numbers(value).map(|[x, y]| AttributeValue::FloatVec2(Vec2(x, y))),
        // UTF-8, as in most programs. The encoder's own conversion accepts only Latin letters.
        _ => Some(AttributeValue::Text(Text::from_slice_unchecked(value.as_bytes()))),
    };
    if let Some(value) = typed {
        attributes.other.insert(Text::from_slice_unchecked(name.as_bytes()), value);
    }
}

/// As many finite numbers.
fn numbers<const N: usize>(text: &str) -> Option<[f32; N]> {
    let all: Vec<f32> = text.split(' ').map(|part| part.parse().ok()).collect::<Option<_>>()?;
    <[f32; N]>::try_from(all).ok().filter(|all| all.iter().all(|x| x.is_finite()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::layout::Layout;
    use crate::integrator::view::View;
    use crate::{Film, Layer, PixelType};
    use ::exr::prelude::MetaData;
    use glam::Vec3;
    use std::io::Cursor;

    fn header(notes: &[(&str, &str)]) -> ::exr::meta::header::Header {
        let mut film = Film::new([4, 2], [0, 0, 4, 2], Layout::new(&[], &[]));
        let words = 4 * film.layout().words();
        film.add_rows(rayon::iter::repeat_n(vec![0; words], 2));
        film.advance(1);
        let notes: Notes = notes.iter().map(|(name, value)| (name.to_string(), value.to_string())).collect();
        let bytes = film.to_exr(&[Layer::Beauty], None, PixelType::Half, &notes).unwrap();
        MetaData::read_from_buffered(Cursor::new(bytes), true).unwrap().headers.remove(0)
    }

    #[test]
    fn notes_of_the_standard_have_its_types() {
        let found = header(&[
            ("framesPerSecond", "24000/1001"),
            ("imageCounter", "-7"),
            ("pinholeFocalLength", "50"),
            ("sensorOverallDimensions", "36 24"),
            ("aperture", "2.8"),
            ("focus", "3"),
            ("screenWindowWidth", "0.72"),
            ("vellus_command", "24/1"),
        ]);
        let own = &found.own_attributes;
        let other = |name: &str| own.other.get(&Text::from(name)).cloned();
        assert_eq!(own.frames_per_second, Some((24000, 1001)));
        assert_eq!((own.aperture, own.focus, own.screen_window_width), (Some(2.8), Some(3.0), 0.72));
        assert_eq!(other("imageCounter"), Some(AttributeValue::I32(-7)));
        assert_eq!(other("pinholeFocalLength"), Some(AttributeValue::F32(50.0)));
        assert_eq!(other("sensorOverallDimensions"), Some(AttributeValue::FloatVec2(Vec2(36.0, 24.0))));
        assert!(
            ["vellus_command", "colorInteropID"].map(other).iter().all(|x| matches!(x, Some(AttributeValue::Text(_))))
        );
        assert_eq!(found.shared_attributes.chromaticities.map(|c| c.white), Some(Vec2(0.3127, 0.329)));
    }

    /// Notes come from films, which anybody may have written.
    #[test]
    fn values_of_other_types_are_left_out() {
        let names = ["worldToCamera", "worldToNDC", "focus", "aperture", "framesPerSecond", "imageCounter"];
        let names = names.into_iter().chain(["screenWindowWidth", "pinholeFocalLength", "sensorOverallDimensions"]);
        for bad in ["", "x", "NaN", "inf", "1 2 3", "1/-1", "1e99"] {
            let notes: Vec<_> = names.clone().map(|name| (name, bad)).collect();
            let own = header(&notes).own_attributes;
            assert_eq!((own.world_to_camera, own.world_to_normalized_device), (None, None), "{bad}");
            assert_eq!((own.focus, own.aperture, own.frames_per_second), (None, None, None), "{bad}");
            assert_eq!(own.screen_window_width, 1.0, "{bad}");
            assert!(notes.iter().all(|(name, _)| !own.other.contains_key(&Text::from(*name))), "{bad}");
        }
    }

    /// A point as a row times a matrix. The picture shows it at x/w and y/w.
    #[test]
    fn matrices_map_points_to_where_the_picture_shows_them() {
        let (eye, size) = (Vec3::new(1.0, 2.0, 5.0), [300, 200]);
        let camera = Camera::look_at(eye, Vec3::new(0.5, 0.0, -1.0), Vec3::Y, 0.7, 2.0);
        let camera = Camera { shift: [0.3, -0.2], ..camera };
        let notes = camera_notes(&camera, size);
        let notes: Vec<_> = notes.iter().map(|(name, value)| (name.as_str(), value.as_str())).collect();
        let own = header(&notes).own_attributes;
        let times =
            |point: Vec3, matrix: Option<[f32; 16]>| Mat4::from_cols_array(&matrix.unwrap()) * point.extend(1.0);
        // Products of numbers below 10 in single precision are wrong by a few 1e-6, of a picture of 300 pixels by 3e-3.
        for point in [Vec3::ZERO, Vec3::new(0.3, -0.8, 0.4), Vec3::new(-1.0, 1.0, -3.0)] {
            let local = times(point, own.world_to_camera).truncate();
            assert!((local.length() - point.distance(eye)).abs() < 1e-5 && local.z > 0.0, "{local}");
            let shown = times(point, own.world_to_normalized_device);
            let seen = View::new(camera).seen(size, point, 0.0).unwrap();
            assert!((shown.x / shown.w * 300.0 - seen.x).abs() < 3e-3, "{shown} {seen}");
            assert!((shown.y / shown.w * 200.0 - seen.y).abs() < 3e-3, "{shown} {seen}");
        }
        // The film is as high as 2 tan(0.35) at distance 1.
        assert_eq!(own.screen_window_center, Vec2(0.3, -0.2));
        assert!((own.screen_window_width - 1.5 * 2.0 * 0.35f32.tan()).abs() < 1e-6);
    }
}
