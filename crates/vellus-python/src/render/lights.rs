//! Lights and the camera of a scene.

use super::arrays::{Floats, one_of, required};
use super::scene::Scene;
use super::values::{LIGHTS, position as known};
use crate::checks::{out_of_range, positive, within};
use crate::error::value;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use vellus::glam::{Mat3, Mat4, Vec3};
use vellus_scene::{Camera, Fit, Light, LightShape, Shaping};

fn angle_of_view(fov: f32) -> PyResult<()> {
    if fov > 0.0 && fov < 180.0 { Ok(()) } else { Err(out_of_range("fov", fov, "in (0, 180) degrees")) }
}

fn not_zero(v: Vec3, name: &str) -> PyResult<Vec3> {
    if v == Vec3::ZERO { Err(PyValueError::new_err(format!("{name} is zero: it must have a length"))) } else { Ok(v) }
}

#[pymethods]
impl Scene {
    /// Adds a light and returns its index. `kind` is one of these. `color` is linear RGB or one number, at least 0:
    ///
    /// - `dome`: radiance from everywhere, times the lat-long image `texture`. `matrix` rotates it; the middle of the
    ///   image is at −z and its top at +y.
    /// - `distant`: irradiance from `direction` (toward the light), within the half angle `angle` in degrees.
    /// - `rect`, `disk`: radiance of a square of side 1, or of a disk of radius 1, toward −z, after `matrix`.
    /// - `point`: intensity (power per solid angle) at `position`.
    /// - `sphere`: radiance of a sphere at `position` with `radius`.
    /// - `cylinder`: radiance of the side of a cylinder at `position` with `radius`; `axis` leads to one end.
    ///
    /// `cone`: emit within this angle in degrees of −z of `matrix`, or of `axis` for a point or a sphere, with an edge
    /// as soft as `softness` in [0, 1]. `group`: for the layer `lights`. `visible`: whether the camera sees it.
    #[pyo3(signature = (kind, color=None, *, matrix=None, direction=None, angle=0.0, position=None, radius=None,
        axis=None, texture=None, cone=None, softness=0.0, group=None, visible=true))]
    fn add_light(
        &self,
        kind: &str,
        color: Option<&Bound<'_, PyAny>>,
        matrix: Option<&Bound<'_, PyAny>>,
        direction: Option<Bound<'_, PyAny>>,
        angle: f32,
        position: Option<Bound<'_, PyAny>>,
        radius: Option<f32>,
        axis: Option<Bound<'_, PyAny>>,
        texture: Option<i128>,
        cone: Option<f32>,
        softness: f32,
        group: Option<String>,
        visible: bool,
    ) -> PyResult<usize> {
        one_of("kind", kind, &LIGHTS)?;
        let color = color.map_or(Ok([1.0; 3]), |color| Floats::new(color, "color")?.color())?;
        if let Some(x) = color.iter().find(|x| **x < 0.0) {
            return Err(out_of_range("color", x, "at least 0"));
        }
        within("angle", angle.into(), 0.0..=180.0)?;
        within("softness", softness.into(), 0.0..=1.0)?;
        radius.map_or(Ok(()), |radius| positive("radius", radius.into(), 1e9))?;
        cone.map_or(Ok(()), |cone| positive("cone", cone.into(), 180.0))?;
        let matrix = matrix.map(|matrix| Floats::new(matrix, "matrix")?.matrix()).transpose()?;
        let to_world = matrix.unwrap_or(Mat4::IDENTITY);
        let vector =
            |given: Option<Bound<'_, PyAny>>, name: &str| Floats::new(&required(given, name, kind)?, name)?.vector();
        let arrow = |given: Option<Bound<'_, PyAny>>, name: &str| vector(given, name).and_then(|v| not_zero(v, name));
        let size = |radius: Option<f32>| radius.ok_or_else(|| PyValueError::new_err(format!("{kind} needs radius")));
        let shape_axis = match &axis {
            Some(axis) => not_zero(Floats::new(axis, "axis")?.vector()?, "axis")?,
            None => -to_world.z_axis.truncate(),
        };
        // A lock of its own: arguments are read without it, because that may run code of Python.
        let all = self.lock().scene.textures.len();
        let texture = texture.map(|texture| known(all, texture, "texture")).transpose()?;
        let shape = match kind {
            "dome" => {
                let rotation = Mat3::from_mat4(to_world);
                LightShape::Dome { radiance: color, texture, rotation, ground: None }
            }
            "distant" => {
                let direction = arrow(direction, "direction")?;
                LightShape::Distant {
                    direction: direction.normalize_or_zero(),
                    half_angle: angle.to_radians(),
                    irradiance: color,
                }
            }
            "rect" => LightShape::Rect { to_world, radiance: color, texture },
            "disk" => LightShape::Disk { to_world, radiance: color },
            "point" => LightShape::Point { position: vector(position, "position")?, intensity: color },
            "sphere" => {
                LightShape::Sphere { center: vector(position, "position")?, radius: size(radius)?, radiance: color }
            }
            _ => LightShape::Cylinder {
                center: vector(position, "position")?,
                half_axis: arrow(axis, "axis")?,
                radius: size(radius)?,
                radiance: color,
            },
        };
        let mut state = self.lock();
        if cone.is_some() && matches!(shape, LightShape::Dome { .. } | LightShape::Distant { .. }) {
            return Err(PyValueError::new_err(format!("cone: a {kind} light has none")));
        }
        let shaping = cone.map(|cone| {
            let (cone, tint) = (cone.to_radians(), [0.0; 3]);
            Shaping { axis: shape_axis, cone, softness, focus: 0.0, tint, profile: None }
        });
        let light = Light { shape, group, visible, shaping, link: None };
        light.validate(state.scene.textures.len()).map_err(value)?;
        let scene = state.change();
        scene.lights.push(light);
        Ok(scene.lights.len() - 1)
    }

    /// Sets the camera.
    ///
    /// `matrix`: from its own frame to world space, (4, 4), for column vectors: a rotation and a
    /// translation. It looks along −z, with y up. `fov`: vertical angle of view in degrees, in (0, 180). `aperture`:
    /// radius of the lens; 0 is a pinhole. `focus_distance`: of the plane in focus. `moved`: the matrix when the
    /// shutter closes.
    #[pyo3(signature = (matrix, *, fov=40.0, aperture=0.0, focus_distance=1.0, moved=None))]
    fn set_camera(
        &self,
        matrix: &Bound<'_, PyAny>,
        fov: f32,
        aperture: f32,
        focus_distance: f32,
        moved: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        angle_of_view(fov)?;
        within("aperture", aperture.into(), 0.0..=1e9)?;
        positive("focus_distance", focus_distance.into(), 1e9)?;
        let film_height = 2.0 * (0.5 * fov.to_radians()).tan();
        let camera = Camera {
            to_world: Floats::new(matrix, "matrix")?.matrix()?,
            moved: moved.map(|moved| Floats::new(moved, "moved")?.matrix()).transpose()?,
            film_width: film_height,
            film_height,
            shift: [0.0; 2],
            fit: Fit::AdjustWidth,
            lens_radius: aperture,
            focus_distance,
        };
        camera.validate().map_err(value)?;
        self.lock().change().camera = Some(camera);
        Ok(())
    }

    /// Places a pinhole camera at `eye` that looks at `target`.
    ///
    /// `eye`, `target`: points, (3,). `up`: the direction that is up in the picture, (3,); +y without it. `fov`:
    /// vertical angle of view in degrees, in (0, 180).
    ///
    /// Raises `ValueError` for an angle out of range, equal points, and `up` along the view.
    #[pyo3(signature = (eye, target, *, up=None, fov=40.0))]
    fn look_at(
        &self,
        eye: &Bound<'_, PyAny>,
        target: &Bound<'_, PyAny>,
        up: Option<&Bound<'_, PyAny>>,
        fov: f32,
    ) -> PyResult<()> {
        angle_of_view(fov)?;
        let vector = |given, name| Floats::new(given, name)?.vector();
        let (eye, target) = (vector(eye, "eye")?, vector(target, "target")?);
        let up = up.map_or(Ok(Vec3::Y), |up| vector(up, "up"))?;
        if eye == target {
            return Err(PyValueError::new_err("eye and target are the same point"));
        }
        if (target - eye).normalize_or_zero().cross(up.normalize_or_zero()).length() < 1e-6 {
            return Err(PyValueError::new_err(format!("up = {up} is parallel to the view, or zero")));
        }
        let camera = Camera::look_at(eye, target, up, fov.to_radians(), 1.5);
        camera.validate().map_err(value)?;
        self.lock().change().camera = Some(camera);
        Ok(())
    }
}
