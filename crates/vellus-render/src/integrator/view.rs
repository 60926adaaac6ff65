//! The moving camera: rays through a pixel, and the pixel in which a point appears.

use crate::geometry::ray::Ray;
use crate::light::sampling::concentric;
use glam::{Affine3A, Mat4, Quat, Vec2, Vec3};
use vellus_scene::Camera;

/// The pixel filter. Samples are drawn in proportion to it, so each sample belongs to one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// A box of one pixel.
    Box,
    /// A tent of two pixels. It gives smoother edges than a box, without steps for fibres that are nearly parallel to
    /// rows or columns.
    #[default]
    Tent,
}

impl Filter {
    /// The offset of a sample from the middle of its pixel, in pixels, for a number in [0, 1).
    fn offset(self, u: f32) -> f32 {
        match self {
            Filter::Box => u - 0.5,
            Filter::Tent if u < 0.5 => (2.0 * u).sqrt() - 1.0,
            Filter::Tent => 1.0 - (2.0 - 2.0 * u).sqrt(),
        }
    }
}

/// A camera prepared for rays. While the shutter is open, it rotates uniformly and moves in a straight line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    camera: Camera,
    open: (Quat, Vec3),
    closed: Option<(Quat, Vec3)>,
}

fn rigid(to_world: Mat4) -> (Quat, Vec3) {
    let (_, turn, place) = to_world.to_scale_rotation_translation();
    (turn, place)
}

impl View {
    pub(crate) fn new(camera: Camera) -> Self {
        View { camera, open: rigid(camera.to_world), closed: camera.moved.map(rigid) }
    }

    /// The camera, and the transform from its frame to the world when the shutter opens.
    pub(crate) fn still(&self) -> (Affine3A, &Camera) {
        (self.frame(0.0), &self.camera)
    }

    /// The camera.
    pub(crate) fn camera(&self) -> Camera {
        self.camera
    }

    /// Whether the camera moves.
    pub(crate) fn moves(&self) -> bool {
        self.closed.is_some()
    }

    /// The axis in the world and the angle of its rotation, and its movement, while the shutter is open.
    pub(crate) fn turn(&self) -> (Vec3, f32, Vec3) {
        let (turn, place) = self.open;
        let (turned, moved) = self.closed.unwrap_or(self.open);
        let by = turned * turn.inverse();
        // The shorter way.
        let (axis, angle) = if by.w < 0.0 { -by } else { by }.normalize().to_axis_angle();
        (axis, angle, moved - place)
    }

    /// The transform from its frame to the world.
    fn frame(&self, time: f32) -> Affine3A {
        let (turn, place) = self.open;
        match self.closed {
            Some((turned, moved)) => {
                Affine3A::from_rotation_translation(turn.slerp(turned, time), place.lerp(moved, time))
            }
            None => Affine3A::from_rotation_translation(turn, place),
        }
    }

    /// The height of the film that a picture of this size shows, over the focal length.
    pub(crate) fn film_height(&self, size: [usize; 2]) -> f32 {
        self.camera.film(size[0] as f32 / size[1] as f32)[1]
    }

    /// The point of the picture through which [`View::ray`] sends a ray: u from the left edge to the right one, v from
    /// the bottom to the top, in [0, 1] for most points of the filter.
    pub(crate) fn place(&self, size: [usize; 2], pixel: [usize; 2], filter: Filter, u: [f32; 4]) -> Vec2 {
        let [x, y] = [0, 1].map(|k| (pixel[k] as f32 + 0.5 + filter.offset(u[k])) / size[k] as f32);
        Vec2::new(x, 1.0 - y)
    }

    /// A ray through a point of a pixel's filter and a point of the lens. `size` is that of the whole picture; `u` are
    /// two numbers for the filter and two for the lens, in [0, 1).
    pub(crate) fn ray(&self, size: [usize; 2], pixel: [usize; 2], filter: Filter, u: [f32; 4], time: f32) -> Ray {
        let [width, height] = size.map(|n| n as f32);
        let film_height = self.film_height(size);
        let x = ((pixel[0] as f32 + 0.5 + filter.offset(u[0])) / width - 0.5) * film_height * width / height;
        let y = (0.5 - (pixel[1] as f32 + 0.5 + filter.offset(u[1])) / height) * film_height;
        let (a, b) = concentric([u[2], u[3]]);
        let lens = Vec3::new(a, b, 0.0) * self.camera.lens_radius;
        let [right, up] = self.camera.shift;
        let focus = Vec3::new(x + right, y + up, -1.0) * self.camera.focus_distance;
        let frame = self.frame(time);
        let direction = frame.transform_vector3(focus - lens).normalize();
        Ray { time, ..Ray::new(frame.transform_point3(lens), direction) }
    }

    /// The width of a pixel at a distance along a camera ray, perpendicular to the view direction (Yan17 Eq. 27).
    pub(crate) fn pixel_width(&self, size: [usize; 2], ray: &Ray, t: f32) -> f32 {
        let forward = self.frame(ray.time).transform_vector3(-Vec3::Z);
        t * ray.direction.dot(forward) * self.film_height(size) / size[1] as f32
    }

    /// The position of the camera when the shutter opens, and the width of a pixel at distance 1 from it.
    pub(crate) fn perspective(&self, size: [usize; 2]) -> (Vec3, f32) {
        (self.frame(0.0).translation.into(), self.film_height(size) / size[1] as f32)
    }

    /// The positions of the camera when the shutter opens and closes.
    pub(crate) fn eyes(&self) -> [Vec3; 2] {
        [0.0, 1.0].map(|time| self.frame(time).translation.into())
    }

    /// The width of a pixel at a point, perpendicular to the view direction; negative behind the camera.
    pub(crate) fn pixel_widths(&self, size: [usize; 2], time: f32) -> impl Fn(Vec3) -> f32 + Sync {
        let frame = self.frame(time);
        let (eye, forward) = (Vec3::from(frame.translation), frame.transform_vector3(-Vec3::Z));
        let slope = self.film_height(size) / size[1] as f32;
        move |point| (point - eye).dot(forward) * slope
    }

    /// The position of a point in the picture, in pixels from the upper left corner. `None` behind the camera.
    pub(crate) fn seen(&self, size: [usize; 2], point: Vec3, time: f32) -> Option<Vec2> {
        let p = self.frame(time).inverse().transform_point3(point);
        let [width, height] = size.map(|n| n as f32);
        let pixels = height / self.film_height(size);
        let on_film = p.truncate() / -p.z - Vec2::from(self.camera.shift);
        (p.z < 0.0).then(|| 0.5 * Vec2::new(width, height) + Vec2::new(on_film.x, -on_film.y) * pixels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vellus_scene::Fit;

    /// Filters are centred. They have the variance and the support of a box of one pixel, and of a tent of two pixels.
    #[test]
    fn filters_have_their_variance_and_support() {
        for (filter, reach, variance) in [(Filter::Box, 0.5, 1.0 / 12.0), (Filter::Tent, 1.0, 1.0 / 6.0)] {
            const N: usize = 10_000;
            let all: Vec<f32> = (0..N).map(|i| filter.offset((i as f32 + 0.5) / N as f32)).collect();
            assert!(all.iter().all(|x| x.abs() <= reach) && all.is_sorted());
            let mean = |f: &dyn Fn(f32) -> f32| all.iter().map(|&x| f64::from(f(x))).sum::<f64>() / N as f64;
            assert!(mean(&|x| x).abs() < 1e-5 && (mean(&|x| x * x) - variance).abs() < 1e-4, "{filter:?}");
        }
    }

    /// The rotation about its axis and the movement make the frame at any time.
    #[test]
    fn the_turn_is_that_of_the_frame() {
        let mut camera = Camera::look_at(Vec3::new(1.0, 2.0, 5.0), Vec3::new(0.2, 0.1, 0.0), Vec3::Y, 0.6, 1.5);
        for angle in [0.0, 0.8, 3.0, -2.5] {
            camera.moved = Some(Mat4::from_rotation_y(angle) * Mat4::from_translation(Vec3::X) * camera.to_world);
            let view = View::new(camera);
            let (axis, angle, way) = view.turn();
            for time in [0.0, 0.3, 1.0] {
                let turned = Quat::from_axis_angle(axis, angle * time) * view.open.0;
                let expected = Affine3A::from_rotation_translation(turned, view.open.1 + way * time);
                assert!(view.frame(time).abs_diff_eq(expected, 1e-5), "{angle} {time}");
            }
        }
    }

    /// A point on a ray appears in the pixel of the ray, at any time, with a moving camera.
    #[test]
    fn points_on_a_ray_appear_in_its_pixel() {
        let mut camera = Camera::look_at(Vec3::new(1.0, 2.0, 5.0), Vec3::new(0.2, 0.1, 0.0), Vec3::Y, 0.6, 1.5);
        camera.moved = Some(Mat4::from_rotation_y(0.8) * Mat4::from_translation(Vec3::X) * camera.to_world);
        let view = View::new(camera);
        for i in 0..200 {
            let pixel = [i % 30, i % 20];
            let time = (i % 7) as f32 / 6.0;
            // The middle of the filter.
            let ray = view.ray([30, 20], pixel, Filter::Tent, [0.5; 4], time);
            let found = view.seen([30, 20], ray.at(0.3 + i as f32), time).unwrap();
            let middle = Vec2::new(pixel[0] as f32 + 0.5, pixel[1] as f32 + 0.5);
            assert!(found.abs_diff_eq(middle, 1e-3), "{found} is not {middle}");
            assert!(view.seen([30, 20], ray.at(-1.0), time).is_none());
        }
    }

    /// With each fit, the corners of the picture are those of the film that it shows, and the width of a pixel agrees.
    #[test]
    fn the_picture_shows_what_the_fit_says() {
        let camera =
            Camera { film_width: 0.6, film_height: 0.3, ..Camera::look_at(Vec3::ZERO, -Vec3::Z, Vec3::Y, 1.0, 1.0) };
        for fit in [Fit::Expand, Fit::Crop, Fit::AdjustWidth, Fit::AdjustHeight] {
            for size in [[40, 10], [40, 20], [20, 20], [10, 40]] {
                // The film is shifted to the right and down.
                let view = View::new(Camera { fit, shift: [0.25, -0.125], ..camera });
                let [width, height] = camera_film(fit, size);
                let ray = view.ray(size, [0, 0], Filter::Box, [0.0, 0.0, 0.5, 0.5], 0.0);
                let corner = ray.direction / -ray.direction.z;
                let expected = Vec3::new(0.25 - 0.5 * width, 0.5 * height - 0.125, -1.0);
                assert!(corner.abs_diff_eq(expected, 1e-6), "{fit:?} {size:?}");
                assert!(view.seen(size, corner, 0.0).unwrap().abs_diff_eq(Vec2::ZERO, 1e-4));
                assert!((view.perspective(size).1 - height / size[1] as f32).abs() < 1e-7);
            }
        }
    }

    /// A film of 0.6 by 0.3.
    fn camera_film(fit: Fit, [w, h]: [usize; 2]) -> [f32; 2] {
        let aspect = w as f32 / h as f32;
        match fit {
            Fit::Expand if aspect < 2.0 => [0.6, 0.6 / aspect],
            Fit::Crop if aspect > 2.0 => [0.6, 0.6 / aspect],
            Fit::AdjustHeight => [0.6, 0.6 / aspect],
            _ => [0.3 * aspect, 0.3],
        }
    }
}
