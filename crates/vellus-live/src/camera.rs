//! The camera that a page moves: it orbits around a target.

use crate::request::within;
use glam::{Mat3, Mat4, Quat, Vec3};
use serde::Serialize;
use vellus_scene::Camera;

/// The smallest angle between the view direction and the up axis, in radians.
const POLE: f32 = 0.02;

/// A camera with a target and an up axis.
#[derive(Clone, Copy, Debug)]
pub struct Orbit {
    home: Camera,
    home_distance: f32,
    camera: Camera,
    /// Distance to the target, along the view direction.
    distance: f32,
    up: Vec3,
}

/// The numbers of the camera for the page.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Report {
    eye: [f32; 3],
    target: [f32; 3],
    /// Vertical angle of view of the film, degrees.
    angle: f32,
    /// Radius of the lens, scene units.
    radius: f32,
    /// Distance in focus, scene units.
    focus: f32,
}

impl Orbit {
    /// A camera of a scene whose middle is at `middle`.
    pub fn new(camera: Camera, middle: Vec3, up: Vec3) -> Self {
        let still = Camera { moved: None, ..camera };
        let forward = -camera.to_world.z_axis.truncate();
        let ahead = (middle - camera.to_world.w_axis.truncate()).dot(forward);
        let distance = if ahead > 0.0 { ahead } else { camera.focus_distance };
        Orbit { home: still, home_distance: distance, camera: still, distance, up: up.normalize_or(Vec3::Y) }
    }

    /// The camera.
    pub fn camera(&self) -> Camera {
        self.camera
    }

    fn frame(&self) -> (Vec3, Mat3) {
        (self.camera.to_world.w_axis.truncate(), Mat3::from_mat4(self.camera.to_world))
    }

    fn target(&self) -> Vec3 {
        let (eye, axes) = self.frame();
        eye - axes.z_axis * self.distance
    }

    /// Looks from `eye` along `forward`, upright.
    fn look(&mut self, eye: Vec3, back: Vec3) {
        let x = self.up.cross(back).normalize_or(back.any_orthonormal_vector());
        let y = back.cross(x);
        self.camera.to_world = Mat4::from_cols(x.extend(0.0), y.extend(0.0), back.extend(0.0), eye.extend(1.0));
    }

    /// Turns around the target, in degrees.
    pub fn turn(&mut self, right: f32, upward: f32) -> Result<(), String> {
        let right = within("x", right, -3600.0, 3600.0)?.to_radians();
        let upward = within("y", upward, -3600.0, 3600.0)?.to_radians();
        let target = self.target();
        let (_, axes) = self.frame();
        let back = Quat::from_axis_angle(self.up, right) * axes.z_axis;
        let side = self.up.cross(back).normalize_or(axes.x_axis);
        let flat = side.cross(self.up);
        let height = (back.dot(self.up).clamp(-1.0, 1.0).asin() + upward)
            .clamp(POLE - std::f32::consts::FRAC_PI_2, std::f32::consts::FRAC_PI_2 - POLE);
        let back = (flat * height.cos() + self.up * height.sin()).normalize();
        self.look(target + back * self.distance, back);
        Ok(())
    }

    /// Moves sideways and upward, in heights of the picture at the target. `aspect` is its width over its height.
    pub fn pan(&mut self, right: f32, upward: f32, aspect: f32) -> Result<(), String> {
        let height = self.distance * self.camera.film(aspect)[1];
        let (eye, axes) = self.frame();
        let x = within("x", right, -10.0, 10.0)? * height;
        let y = within("y", upward, -10.0, 10.0)? * height;
        self.look(eye + axes.x_axis * x + axes.y_axis * y, axes.z_axis);
        Ok(())
    }

    /// Multiplies the distance to the target. The target stays in focus if it was.
    pub fn zoom(&mut self, factor: f32) -> Result<(), String> {
        let factor = within("factor", factor, 0.01, 100.0)?;
        let (target, (_, axes)) = (self.target(), self.frame());
        let ahead = self.camera.focus_distance - self.distance;
        let least = self.home_distance * 1e-4;
        self.distance = (self.distance * factor).clamp(least, self.home_distance * 1e3);
        self.camera.focus_distance = (self.distance + ahead).max(least);
        self.look(target + axes.z_axis * self.distance, axes.z_axis);
        Ok(())
    }

    /// Focuses on a point, and turns to it.
    pub fn focus(&mut self, point: Vec3) {
        let (eye, _) = self.frame();
        let back = eye - point;
        let distance = back.length();
        if distance > 0.0 && distance.is_finite() {
            self.distance = distance;
            self.camera.focus_distance = distance;
            self.look(eye, back / distance);
        }
    }

    /// Sets the vertical angle of view of the film in degrees, and the radius of the lens.
    pub fn lens(&mut self, angle: f32, radius: f32) -> Result<(), String> {
        let height = 2.0 * (0.5 * within("angle", angle, 1.0, 150.0)?.to_radians()).tan();
        self.camera.lens_radius = within("radius", radius, 0.0, self.home_distance)?;
        self.camera.film_width *= height / self.camera.film_height;
        self.camera.film_height = height;
        Ok(())
    }

    /// Returns to the first camera.
    pub fn home(&mut self) {
        (self.camera, self.distance) = (self.home, self.home_distance);
    }

    /// The numbers for the page.
    pub fn report(&self) -> Report {
        Report {
            eye: self.frame().0.to_array(),
            target: self.target().to_array(),
            angle: 2.0 * (0.5 * self.camera.film_height).atan().to_degrees(),
            radius: self.camera.lens_radius,
            focus: self.camera.focus_distance,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_target_stays_in_the_middle() {
        let camera = Camera::look_at(Vec3::new(3.0, 1.0, 5.0), Vec3::new(0.5, 0.2, 0.1), Vec3::Y, 0.6, 1.5);
        let mut orbit = Orbit::new(camera, Vec3::new(0.5, 0.2, 0.1), Vec3::Y);
        let target = orbit.target();
        for step in 0..200 {
            orbit.turn(17.0, if step % 3 == 0 { 40.0 } else { -25.0 }).unwrap();
            orbit.zoom(if step % 2 == 0 { 0.8 } else { 1.25 }).unwrap();
            assert_eq!(orbit.camera().validate(), Ok(()), "{step}");
        }
        // 200 products of rotations in single precision.
        assert!(orbit.target().distance(target) < 1e-3);
        orbit.pan(0.5, -0.5, 1.5).unwrap();
        assert!(orbit.target().distance(target) > 0.1);
        orbit.home();
        assert_eq!(orbit.camera(), camera);
    }

    #[test]
    fn numbers_out_of_range_are_refused() {
        let camera = Camera::look_at(Vec3::Z, Vec3::ZERO, Vec3::Y, 0.6, 1.5);
        let mut orbit = Orbit::new(camera, Vec3::ZERO, Vec3::Y);
        assert!(
            orbit.turn(f32::NAN, 0.0).is_err()
                && orbit.zoom(0.0).is_err()
                && orbit.pan(f32::INFINITY, 0.0, 1.5).is_err()
        );
        assert!(orbit.lens(0.0, 0.0).is_err() && orbit.lens(30.0, -1.0).is_err());
        orbit.focus(Vec3::Z);
        orbit.focus(Vec3::splat(f32::NAN));
        assert_eq!(orbit.camera(), camera);
    }
}
