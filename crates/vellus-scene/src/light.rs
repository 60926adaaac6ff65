//! Lights, with UsdLux' shapes.

use crate::error::{Error, invalid};
use glam::{Mat3, Mat4, Vec3};

/// A light. Radiance is linear RGB. Rectangles and disks shine toward −z of their own frame, spheres and cylinders
/// outward.
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// From everywhere beyond the scene: radiance times a lat-long texture, whose middle is toward −z of the frame
    /// `rotation` takes to the world, its top toward +y.
    Dome {
        /// Radiance, or what multiplies the texture.
        radiance: [f32; 3],
        /// Index of a lat-long texture in the scene.
        texture: Option<usize>,
        /// From the light's frame to the world.
        rotation: Mat3,
        /// Where the lower half of the texture is to be seen as ground, if anywhere.
        ground: Option<Ground>,
    },
    /// From one direction, spread over a cone.
    Distant {
        /// Toward the light.
        direction: Vec3,
        /// Half angle of the cone, radians; 0 is exactly one direction.
        half_angle: f32,
        /// Irradiance on a plane that faces it.
        irradiance: [f32; 3],
    },
    /// A rectangle of 1 × 1 in the xy plane, then transformed.
    Rect {
        /// From its frame to the world.
        to_world: Mat4,
        /// Emitted.
        radiance: [f32; 3],
        /// Index of a texture in the scene.
        texture: Option<usize>,
    },
    /// A disk of radius 1 in the xy plane, then transformed.
    Disk {
        /// From its frame to the world.
        to_world: Mat4,
        /// Emitted.
        radiance: [f32; 3],
    },
    /// A sphere.
    Sphere {
        /// Its centre.
        center: Vec3,
        /// Its radius, positive.
        radius: f32,
        /// Emitted.
        radiance: [f32; 3],
    },
    /// The side of a cylinder, which shines outward. Its ends are open and do not shine.
    Cylinder {
        /// Its centre.
        center: Vec3,
        /// From its centre to the centre of one end, not zero.
        half_axis: Vec3,
        /// Its radius, positive.
        radius: f32,
        /// Emitted.
        radiance: [f32; 3],
    },
}

/// The lower half of a dome's image laid onto a disk of ground, as far as the camera sees it: light is still that of a dome
/// infinitely far away, and nothing casts shadows on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// The middle of the ground, below where the image was taken; up is +y of the light's frame.
    pub origin: Vec3,
    /// How high above it the image was taken, positive.
    pub height: f32,
    /// Radius of the ground, positive; beyond, the image is on a sphere that meets it there.
    pub radius: f32,
}

impl Light {
    /// `dome`, `distant`, `rect`, `disk`, `sphere` or `cylinder`.
    pub fn kind(&self) -> &'static str {
        match self {
            Light::Dome { .. } => "dome",
            Light::Distant { .. } => "distant",
            Light::Rect { .. } => "rect",
            Light::Disk { .. } => "disk",
            Light::Sphere { .. } => "sphere",
            Light::Cylinder { .. } => "cylinder",
        }
    }

    /// Checks that all is finite, no colour negative, and that textures exist.
    ///
    /// # Errors
    /// [`Error::Invalid`] says what is wrong.
    pub fn validate(&self, textures: usize) -> Result<(), Error> {
        let (place, color, texture, finite) = match self {
            Light::Dome { radiance, texture, rotation, ground } => {
                let positive = |x: f32| x.is_finite() && x > 0.0;
                let laid = |g: &Ground| g.origin.is_finite() && positive(g.height) && positive(g.radius);
                ("dome light", radiance, *texture, rotation.is_finite() && ground.iter().all(laid))
            }
            Light::Distant { direction, half_angle, irradiance } => {
                let finite = direction.is_finite() && direction.length() > 0.0 && half_angle.is_finite();
                ("distant light", irradiance, None, finite && *half_angle >= 0.0)
            }
            Light::Rect { to_world, radiance, texture } => ("rect light", radiance, *texture, to_world.is_finite()),
            Light::Disk { to_world, radiance } => ("disk light", radiance, None, to_world.is_finite()),
            Light::Sphere { center, radius, radiance } => {
                ("sphere light", radiance, None, center.is_finite() && radius.is_finite() && *radius > 0.0)
            }
            Light::Cylinder { center, half_axis, radius, radiance } => {
                let length = half_axis.length();
                let finite = center.is_finite() && length.is_finite() && radius.is_finite();
                ("cylinder light", radiance, None, finite && length > 0.0 && *radius > 0.0)
            }
        };
        if !finite {
            return Err(invalid(place, "its place and size must be finite, its size positive"));
        }
        if color.iter().any(|c| !(c.is_finite() && *c >= 0.0)) {
            return Err(invalid(place, format!("its colour is {color:?}: no channel may be negative or infinite")));
        }
        match texture {
            Some(index) if index >= textures => Err(invalid(place, "it has no such texture")),
            _ => Ok(()),
        }
    }
}
