//! The perspective camera.

use crate::error::{Error, invalid};
use crate::strands::{MAX_COORDINATE, is_within};
use glam::{Mat3, Mat4, Vec3, Vec4};

/// The largest width or height of the film, relative to the focal length. The angle of view is 179.99°.
const MAX_FILM: f32 = 1e4;

/// Tolerance of a rotation: the largest difference between the products of its axes and those of an orthonormal basis.
/// Each rotation in a product adds about 1e-6 in single precision. A scale of 0.05 % is an error.
const RIGID: f32 = 1e-3;

/// Ratios of width to height that differ by less than this share are equal: sizes in pixels are rounded.
const EQUAL: f32 = 1e-4;

/// What a picture shows whose ratio of width to height is not that of the film (`aspectRatioConformPolicy` of
/// UsdRender).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fit {
    /// The whole film, and more beside or above and below it.
    Expand,
    /// As much of the film as fills the picture.
    Crop,
    /// The height of the film: its width is that of the picture.
    #[default]
    AdjustWidth,
    /// The width of the film: its height is that of the picture.
    AdjustHeight,
}

/// A perspective camera with a thin lens. In its own frame it looks along −z, with y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// From its own frame to world space: a rotation and a translation.
    pub to_world: Mat4,
    /// The same transform when the shutter closes. `None` if the camera does not move.
    pub moved: Option<Mat4>,
    /// Width of the film over the focal length: 2 tan(a/2), where a is the horizontal angle of view. In (0, 10⁴].
    pub film_width: f32,
    /// Height of the film over the focal length, in (0, 10⁴].
    pub film_height: f32,
    /// How far the middle of the film is right of and above the axis of the lens, over the focal length; within ±10⁴.
    pub shift: [f32; 2],
    /// What a picture of another shape shows. [`Camera::film`] has the numbers.
    pub fit: Fit,
    /// Radius of the lens, in [0, [`MAX_COORDINATE`]]. 0 is a pinhole.
    pub lens_radius: f32,
    /// Distance along −z of the plane in focus, in (0, [`MAX_COORDINATE`]].
    pub focus_distance: f32,
}

impl Camera {
    /// A pinhole camera at `eye` that looks at `target`. `angle` is the vertical angle of view in radians, and `aspect`
    /// is width over height. Pictures of another shape keep the vertical angle ([`Fit::AdjustWidth`]).
    pub fn look_at(eye: Vec3, target: Vec3, up: Vec3, angle: f32, aspect: f32) -> Self {
        let z = (eye - target).normalize_or(Vec3::Z);
        let x = up.cross(z).normalize_or(z.any_orthonormal_vector());
        let film_height = 2.0 * (0.5 * angle).tan();
        Camera {
            to_world: Mat4::from_cols(x.extend(0.0), z.cross(x).extend(0.0), z.extend(0.0), eye.extend(1.0)),
            moved: None,
            film_width: film_height * aspect,
            film_height,
            shift: [0.0; 2],
            fit: Fit::AdjustWidth,
            lens_radius: 0.0,
            focus_distance: eye.distance(target),
        }
    }

    /// Width over height of the film.
    pub fn aspect(&self) -> f32 {
        self.film_width / self.film_height
    }

    /// The width and height that a picture with this ratio of width to height shows, over the focal length.
    pub fn film(&self, aspect: f32) -> [f32; 2] {
        let relative = aspect / self.aspect();
        let keeps_height = match self.fit {
            Fit::Expand => relative > 1.0 - EQUAL,
            Fit::Crop => relative < 1.0 + EQUAL,
            Fit::AdjustWidth => true,
            Fit::AdjustHeight => (relative - 1.0).abs() < EQUAL,
        };
        if keeps_height {
            [self.film_height * aspect, self.film_height]
        } else {
            [self.film_width, self.film_width / aspect]
        }
    }

    /// The size of a picture with the shape of the film, in pixels: `longer` is that of its longer side.
    pub fn size(&self, longer: usize) -> [usize; 2] {
        let side = |share: f32| ((longer as f32 * share.min(1.0)).round() as usize).max(1);
        [side(self.aspect()), side(self.aspect().recip())]
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
        if self.shift.iter().any(|x| x.is_nan() || x.abs() > MAX_FILM) {
            let [x, y] = self.shift;
            return fail(format!(
                "the shift of the film over the focal length is ({x}, {y}): it must be within ±{MAX_FILM:e}"
            ));
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

    /// Of a film of 2 by 1, in a picture that is wider, as wide, nearly as wide, less wide, and tall.
    #[test]
    fn each_fit_keeps_its_side_of_the_film() {
        let film = |fit, aspect| {
            let camera = Camera::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, 2.0 * 0.5f32.atan(), 2.0);
            Camera { film_width: 2.0, film_height: 1.0, fit, ..camera }.film(aspect)
        };
        let aspects = [4.0, 2.0, 2.0001, 1.0, 0.5];
        assert_eq!(aspects.map(|a| film(Fit::AdjustWidth, a)), aspects.map(|a| [a, 1.0]));
        let whole = [[4.0, 1.0], [2.0, 1.0], [2.0001, 1.0], [2.0, 2.0], [2.0, 4.0]];
        assert_eq!(aspects.map(|a| film(Fit::Expand, a)), whole);
        let part = [[2.0, 0.5], [2.0, 1.0], [2.0001, 1.0], [1.0, 1.0], [0.5, 1.0]];
        assert_eq!(aspects.map(|a| film(Fit::Crop, a)), part);
        let wide = [[2.0, 0.5], [2.0, 1.0], [2.0001, 1.0], [2.0, 2.0], [2.0, 4.0]];
        assert_eq!(aspects.map(|a| film(Fit::AdjustHeight, a)), wide);
    }

    #[test]
    fn a_size_has_the_shape_of_the_film() {
        let size = |width: f32, height: f32| {
            let camera = Camera::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, 0.5, 1.5);
            Camera { film_width: width, film_height: height, ..camera }.size(960)
        };
        assert_eq!((size(0.3, 0.2), size(36.0, 20.25), size(2.0, 3.0)), ([960, 640], [960, 540], [640, 960]));
        assert_eq!((size(1e4, 1e-2), size(1.0, 1.0)), ([960, 1], [960, 960]));
    }

    #[test]
    fn each_number_has_its_own_message() {
        let camera = Camera::look_at(Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO, Vec3::Y, 0.5, 1.5);
        assert_eq!(camera.validate(), Ok(()));
        type Break = fn(&mut Camera);
        let broken: [(Break, &str); 9] = [
            (|c| c.shift[1] = f32::NAN, "the shift of the film over the focal length is (0, NaN)"),
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
