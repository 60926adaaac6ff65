//! The perspective camera.

use crate::error::{Error, invalid};
use crate::strands::{MAX_COORDINATE, is_within};
use glam::{Mat3, Mat4, Vec3, Vec4};

/// The largest width or height of the film, relative to the focal length. The angle of view is 179.99°.
const MAX_FILM: f32 = 1e4;

/// Tolerance of a rotation: the largest difference between the products of its axes and those of an orthonormal basis.
/// Each rotation in a product adds about 1e-6 in single precision. A scale of 0.05 % is an error.
const RIGID: f32 = 1e-3;

/// A perspective camera with a thin lens. In its own frame it looks along −z, with y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// From its own frame to world space: a rotation and a translation.
    pub to_world: Mat4,
    /// The same transform when the shutter closes. `None` if the camera does not move.
    pub moved: Option<Mat4>,
    /// Width of the film over the focal length: 2 tan(a/2), where a is the horizontal angle of view. In (0, 10⁴].
    ///
    /// Framing and files use it. The renderer fits the height, and computes the width from the size of the picture.
    pub film_width: f32,
    /// Height of the film over the focal length, in (0, 10⁴].
    pub film_height: f32,
    /// Radius of the lens, in [0, [`MAX_COORDINATE`]]. 0 is a pinhole.
    pub lens_radius: f32,
    /// Distance along −z of the plane in focus, in (0, [`MAX_COORDINATE`]].
    pub focus_distance: f32,
}

impl Camera {
    /// A pinhole camera at `eye` that looks at `target`. `angle` is the vertical angle of view in radians, and `aspect`
    /// is width over height.
    pub fn look_at(eye: Vec3, target: Vec3, up: Vec3, angle: f32, aspect: f32) -> Self {
        let z = (eye - target).normalize_or(Vec3::Z);
        let x = up.cross(z).normalize_or(z.any_orthonormal_vector());
        let film_height = 2.0 * (0.5 * angle).tan();
        Camera {
            to_world: Mat4::from_cols(x.extend(0.0), z.cross(x).extend(0.0), z.extend(0.0), eye.extend(1.0)),
            moved: None,
            film_width: film_height * aspect,
            film_height,
            lens_radius: 0.0,
            focus_distance: eye.distance(target),
        }
    }

    /// Checks that all numbers are in range, and that the transforms are rigid with translations of at most
    /// [`MAX_COORDINATE`].
    ///
    /// # Errors
    /// [`Error::Invalid`] for the first problem.
    pub fn validate(&self) -> Result<(), Error> {
        let fail = |what: String| Err(invalid("camera", what));
        let within = |x: f32, max: f32| x > 0.0 && x <= max;
        for (name, x) in [("width", self.film_width), ("height", self.film_height)] {
            if !within(x, MAX_FILM) {
                return fail(format!(
                    "the film's {name} over the focal length is {x}: it must be in (0, {MAX_FILM:e}]"
                ));
            }
        }
        if !(0.0..=MAX_COORDINATE).contains(&self.lens_radius) {
            return fail(format!("the lens' radius is {}: it must be in [0, {MAX_COORDINATE:e}]", self.lens_radius));
        }
        if !within(self.focus_distance, MAX_COORDINATE) {
            let what = format!("the focus distance is {}: it must be in (0, {MAX_COORDINATE:e}]", self.focus_distance);
            return fail(what);
        }
        for (name, matrix) in [("transform", Some(self.to_world)), ("transform when the shutter closes", self.moved)] {
            let Some(matrix) = matrix else { continue };
            if !is_within(matrix.w_axis.truncate()) {
                return fail(format!("its {name} must be finite, and its translation within ±{MAX_COORDINATE:e}"));
            }
            let rotation = Mat3::from_mat4(matrix);
            let gram = rotation.transpose() * rotation;
            if !gram.abs_diff_eq(Mat3::IDENTITY, RIGID) || matrix.row(3) != Vec4::W {
                return fail(format!("its {name} must be a rotation and a translation, without scale or shear"));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_number_has_its_own_message() {
        let camera = Camera::look_at(Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO, Vec3::Y, 0.5, 1.5);
        assert_eq!(camera.validate(), Ok(()));
        type Break = fn(&mut Camera);
        let broken: [(Break, &str); 8] = [
            (|c| c.film_width = 0.0, "film's width"),
            (|c| c.film_height = f32::NAN, "film's height"),
            (|c| c.lens_radius = -1.0, "lens' radius is -1"),
            (|c| c.focus_distance = f32::INFINITY, "focus distance is inf"),
            (|c| c.to_world.w_axis.x = 1e20, "translation"),
            (|c| c.to_world *= Mat4::from_scale(Vec3::splat(2.0)), "without scale"),
            (|c| c.moved = Some(Mat4::NAN), "when the shutter closes must be finite"),
            (
                |c| c.moved = Some(Mat4::from_scale(Vec3::new(1.0, 2.0, 1.0))),
                "when the shutter closes must be a rotation",
            ),
        ];
        for (change, message) in broken {
            let mut camera = camera;
            change(&mut camera);
            let error = camera.validate().unwrap_err().to_string();
            assert!(error.contains(message), "{error}");
        }
    }
}
