//! The camera.

use crate::error::{Error, invalid};
use glam::{Mat4, Vec3};

/// A perspective camera with a thin lens. It looks along −z of its own frame, y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// From its frame to the world: a rigid motion.
    pub to_world: Mat4,
    /// The same when the shutter closes, if it moves.
    pub moved: Option<Mat4>,
    /// Width of the film over the focal length: 2 tan of half the horizontal angle of view.
    pub film_width: f32,
    /// Height of the film over the focal length.
    pub film_height: f32,
    /// Radius of the lens; 0 is a pinhole.
    pub lens_radius: f32,
    /// Distance along −z that is sharp.
    pub focus_distance: f32,
}

impl Camera {
    /// A pinhole at `eye` that looks at `target`; `angle` is the vertical angle of view in radians.
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

    /// Checks that all is finite and positive.
    ///
    /// # Errors
    /// [`Error::Invalid`] says what is wrong.
    pub fn validate(&self) -> Result<(), Error> {
        let positive = |x: f32| x.is_finite() && x > 0.0;
        if !(positive(self.film_width) && positive(self.film_height)) {
            return Err(invalid("camera", "the film must have a positive width and height"));
        }
        if !(self.lens_radius >= 0.0 && self.lens_radius.is_finite() && positive(self.focus_distance)) {
            return Err(invalid("camera", "the lens' radius must not be negative, the focus distance positive"));
        }
        if !self.to_world.is_finite() || self.to_world.determinant().abs() < 1e-6 {
            return Err(invalid("camera", "its transform must be finite and invertible"));
        }
        Ok(())
    }
}
