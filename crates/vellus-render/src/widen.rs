//! A smallest width of strands in pixels.

use crate::integrator::view::View;
use crate::simplify::{Lod, simplify};
use glam::Vec4Swizzles;
use rayon::prelude::*;
use vellus_scene::Scene;

/// Prepares a scene for a picture. A scene without a camera gets one that shows everything. Strands become at least
/// `pixels` wide, see [`widen()`]. Then [`simplify()`] keeps as many as the level of detail needs.
pub fn prepare(scene: &mut Scene, size: [usize; 2], pixels: f32, lod: Lod) {
    let [width, height] = size.map(|n| n as f32);
    scene.camera = scene.camera.or_else(|| scene.framing(width / height));
    widen(scene, size, pixels);
    simplify(scene, size, lod);
}

/// Makes strands at least `pixels` wide in a picture of `size` by the scene's camera. Each control point gets the
/// larger of the radii for the opening and for the closing of the shutter. Points behind the camera, scenes without a
/// camera, and strands of instances do not change.
///
/// This biases the coverage of thin fur for every ray, so fur looks denser. In return, strands thinner than a pixel
/// have less noise and flicker. `pixels` is at least 0, and 0 changes nothing.
pub fn widen(scene: &mut Scene, size: [usize; 2], pixels: f32) {
    let Some(camera) = scene.camera else { return };
    let view = View::new(camera);
    // The radius of a strand that is `pixels` wide; negative behind the camera.
    let [open, close] = [0.0, 1.0].map(|time| {
        let width = view.pixel_widths(size, time);
        move |point| 0.5 * pixels * width(point)
    });
    for strands in &mut scene.strands {
        let moved = strands.moved.as_deref();
        strands.points.par_iter_mut().enumerate().for_each(|(i, point)| {
            let start = point.xyz();
            let end = moved.and_then(|moved| moved.get(i)).copied().unwrap_or(start);
            let least = open(start).max(close(end));
            // Invalid radii do not change, and validation rejects them later.
            if (0.0..least).contains(&point.w) {
                point.w = least;
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Mat4, Vec3, Vec4};
    use vellus_scene::{Basis, Camera, Strands};

    /// Wherever the camera sees a strand, it has the requested width or its own.
    #[test]
    fn strands_have_the_requested_width_at_both_ends_of_the_shutter() {
        let mut camera = Camera::look_at(Vec3::new(1.0, 2.0, 5.0), Vec3::new(0.2, 0.1, 0.0), Vec3::Y, 0.6, 1.5);
        camera.moved = Some(Mat4::from_rotation_y(0.3) * Mat4::from_translation(Vec3::Z) * camera.to_world);
        let place = |i: usize, k: f32| Vec3::new((i as f32 * k).sin(), (i as f32).cos(), (i as f32 * 0.37).sin() * 8.0);
        let radius = |i: usize| if i.is_multiple_of(5) { 0.0 } else { 0.004 * (i % 7) as f32 };
        let strands = Strands {
            name: "fur".to_owned(),
            basis: Basis::Linear,
            starts: vec![0, 400],
            points: (0..400).map(|i| place(i, 0.9).extend(radius(i))).collect(),
            moved: Some((0..400).map(|i| place(i, 1.1) + 0.5 * Vec3::Y).collect()),
            normals: None,
            root_uv: None,
            look: 0,
            varying: vec![],
        };
        let before = Scene { strands: vec![strands], camera: Some(camera), ..Scene::default() };
        let size = [300, 200];
        let pixels = 0.8;
        let mut after = before.clone();
        widen(&mut after, size, pixels);
        let (mut kept, mut raised, mut behind, mut near) = (0, 0, 0, 0);
        let view = View::new(camera);
        for (i, (was, is)) in before.strands[0].points.iter().zip(&after.strands[0].points).enumerate() {
            let moved = before.strands[0].moved.as_ref().unwrap()[i];
            let frames = [(was.xyz(), 0.0, camera.to_world), (moved, 1.0, camera.moved.unwrap())];
            assert_eq!(was.xyz(), is.xyz());
            // Points at the side of the camera are thousands of pixels outside the picture, where single precision does
            // not resolve a pixel.
            if frames.iter().any(|(point, _, frame)| frame.inverse().transform_point3(*point).z.abs() < 0.5) {
                near += 1;
                continue;
            }
            // The width of a pixel, from the positions of a point and of a neighbouring point in the picture.
            let step = 1e-2;
            let pixel = |(point, time, frame): (Vec3, f32, Mat4)| {
                let seen = view.seen(size, point, time)?;
                let beside = view.seen(size, point + step * frame.x_axis.truncate(), time)?;
                Some(step / seen.distance(beside))
            };
            let least = frames.into_iter().filter_map(pixel).reduce(f32::max);
            match least {
                None => behind += usize::from(was == is),
                Some(pixel) if was.w >= 0.5 * pixels * pixel => kept += usize::from(was == is),
                // Coordinates are up to some thousand pixels, with an error of 2⁻²⁴ of them. Their difference is at
                // least 0.3.
                Some(pixel) => {
                    assert!((is.w / (0.5 * pixels * pixel) - 1.0).abs() < 1e-2, "{i}: {is} {pixel}");
                    raised += 1;
                }
            }
        }
        assert_eq!(kept + raised + behind + near, 400);
        assert!(kept > 20 && raised > 100 && behind > 20 && near < 100, "{kept} {raised} {behind} {near}");
        // No width is requested, and then there is no camera.
        let mut none = before.clone();
        widen(&mut none, size, 0.0);
        assert_eq!(none, before);
        let blind = Scene { camera: None, ..before };
        let mut same = blind.clone();
        widen(&mut same, size, pixels);
        assert_eq!(same, blind);
    }

    #[test]
    fn invalid_radii_are_still_errors() {
        let strands = Strands {
            name: "fur".to_owned(),
            basis: Basis::Linear,
            starts: vec![0, 2],
            points: vec![Vec4::new(0.0, 0.0, 0.0, f32::NAN), Vec4::new(1.0, 0.0, 0.0, -1.0)],
            moved: None,
            normals: None,
            root_uv: None,
            look: 0,
            varying: vec![],
        };
        let camera = Camera::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, 0.6, 1.5);
        let mut scene = Scene { strands: vec![strands], camera: Some(camera), ..Scene::default() };
        widen(&mut scene, [30, 20], 1.0);
        assert!(scene.strands[0].points[0].w.is_nan() && scene.strands[0].points[1].w == -1.0);
    }
}
