//! Lights, with the shapes of UsdLux.

use crate::error::{Error, invalid};
use crate::link::Link;
use glam::{Mat3, Mat4, Vec2, Vec3};

/// A light.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// What emits, and how much.
    pub shape: LightShape,
    /// Its group. The renderer can write the light of each group as a separate layer. The name has 1 to 64 letters,
    /// digits, `_` or `-`. Without one, the light is a group of its own: [`crate::Scene::light_group_names`].
    pub group: Option<String>,
    /// Whether the camera sees it directly. It illuminates the scene in any case.
    pub visible: bool,
    /// How the emission depends on the direction. Domes and distant lights have none.
    pub shaping: Option<Shaping>,
    /// Which objects it lights, which of them cast shadows, and gains. Without one, it lights everything.
    pub link: Option<Link>,
}

/// A visible light without group, shaping and link.
impl From<LightShape> for Light {
    fn from(shape: LightShape) -> Self {
        Light { shape, group: None, visible: true, shaping: None, link: None }
    }
}

impl Light {
    /// Checks the shape, the name of the group, the shaping and the link. `textures` is the number of textures of the
    /// scene.
    ///
    /// # Errors
    /// [`Error::Invalid`] for the first problem.
    pub fn validate(&self, textures: usize) -> Result<(), Error> {
        self.shape.validate(textures)?;
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if let Some(name) = &self.group
            && (!(1..=64).contains(&name.len()) || !name.chars().all(plain))
        {
            let what = "a light group's name has 1 to 64 letters, digits, _ or -";
            return Err(invalid("lights", format!("'{name}': {what}")));
        }
        if let Some(shaping) = &self.shaping {
            shaping.validate(textures)?;
            if matches!(self.shape, LightShape::Dome { .. } | LightShape::Distant { .. }) {
                return Err(invalid("lights", format!("a {} light cannot have a shaping", self.shape.kind())));
            }
        }
        self.link.iter().try_for_each(Link::validate)
    }
}

/// The shape of a light, and its emission. Radiance is linear RGB. Rectangles and disks emit toward −z of their own
/// frame, spheres and cylinders outward.
#[derive(Clone, Debug, PartialEq)]
pub enum LightShape {
    /// Infinitely distant light from all directions: radiance times a lat-long texture. In the light's own frame, the
    /// centre of the texture is at −z and its top at +y.
    Dome {
        /// Radiance, or the factor of the texture.
        radiance: [f32; 3],
        /// Index of a lat-long texture in the scene.
        texture: Option<usize>,
        /// From the light's own frame to world space: a rotation, or a rotation and a reflection, which mirrors the
        /// image.
        rotation: Mat3,
        /// Projection of the lower half of the texture onto the ground, if any.
        ground: Option<Ground>,
    },
    /// Infinitely distant light from a cone of directions.
    Distant {
        /// Direction toward the light.
        direction: Vec3,
        /// Half angle of the cone in radians. 0 is a single direction.
        half_angle: f32,
        /// Irradiance of a plane that faces the light.
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
    /// A point.
    Point {
        /// Its position.
        position: Vec3,
        /// Radiant intensity: power per solid angle, the same in all directions.
        intensity: [f32; 3],
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
    /// The lateral surface of a cylinder, which emits outward. The ends do not emit.
    Cylinder {
        /// Its centre.
        center: Vec3,
        /// Vector from the centre to the centre of one end; not zero.
        half_axis: Vec3,
        /// Its radius, positive.
        radius: f32,
        /// Emitted.
        radiance: [f32; 3],
    },
}

/// How the emission of a light depends on its direction, as in UsdLuxShapingAPI: a cone with a soft edge, a focus, and
/// a measured profile.
///
/// The emission in a direction at the angle θ from the axis is multiplied by [`Shaping::factor`], and by the profile
/// if there is one. The total power is not kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shaping {
    /// The axis in world space, away from the light. Not zero.
    pub axis: Vec3,
    /// The largest angle between the axis and a direction with emission, in radians; in (0, π].
    pub cone: f32,
    /// The share of the cone's angle over which the emission falls to 0; in [0, 1]. 0 is a hard edge.
    pub softness: f32,
    /// The exponent of |cos θ|; at least 0. 0 changes nothing.
    pub focus: f32,
    /// The factor where the focus has no light left, RGB; no channel is negative.
    pub tint: [f32; 3],
    /// The measured profile of the lamp.
    pub profile: Option<Profile>,
}

/// The luminous intensity of a lamp by direction (an IES profile), as an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    /// The index of the image in [`crate::Scene::textures`], whose first channel counts. Its rows go from the axis of
    /// the shaping to the opposite direction: the centres of the first and of the last row are these directions. Its
    /// columns go around the axis.
    pub texture: usize,
    /// The direction in world space at which the first column begins to turn about the axis; not along it. Looking
    /// along the axis, columns turn counterclockwise from it.
    pub side: Vec3,
}

impl Profile {
    /// The texture coordinates of a direction in an image of this width and height. `axis` and `direction` have unit
    /// length.
    pub fn uv(&self, axis: Vec3, direction: Vec3, [width, height]: [usize; 2]) -> Vec2 {
        let x = self.side.reject_from_normalized(axis).normalize_or_zero();
        let y = x.cross(axis);
        let down = direction.dot(axis).clamp(-1.0, 1.0).acos() / std::f32::consts::PI;
        let around = direction.dot(y).atan2(direction.dot(x)) / std::f32::consts::TAU;
        let row = (down * (height - 1) as f32 + 0.5) / height as f32;
        Vec2::new(around + 0.5 / width as f32, 1.0 - row)
    }
}

impl Shaping {
    /// The factor of the emission in a direction of unit length, away from the light, without the profile: f + (1 − f)
    /// · tint, where f is |cos θ| to the power of the focus, times a smoothstep from 1 at (1 − softness) · cone to 0 at
    /// the cone.
    pub fn factor(&self, direction: Vec3) -> [f32; 3] {
        let cos = direction.dot(self.axis.normalize()).clamp(-1.0, 1.0);
        let angle = cos.acos();
        if angle > self.cone {
            return [0.0; 3];
        }
        let start = (1.0 - self.softness) * self.cone;
        let edge = if angle <= start { 0.0 } else { (angle - start) / (self.cone - start) };
        let focus = if self.focus == 0.0 { 1.0 } else { cos.abs().powf(self.focus) };
        let cone = 1.0 - edge * edge * (3.0 - 2.0 * edge);
        self.tint.map(|tint| (focus + (1.0 - focus) * tint) * cone)
    }

    /// Checks that the axis is finite and not zero, all numbers are in their ranges, and a profile is one of this many
    /// textures.
    ///
    /// # Errors
    /// [`Error::Invalid`] if they are not.
    pub fn validate(&self, textures: usize) -> Result<(), Error> {
        let Shaping { axis, cone, softness, focus, tint, profile } = *self;
        let aimed = axis.is_finite() && axis.try_normalize().is_some();
        if tint.iter().any(|x| !(x.is_finite() && *x >= 0.0)) {
            return Err(invalid("shaping of a light", "no channel of its tint may be negative or infinite"));
        }
        if let (Some(profile), Some(axis)) = (profile, axis.try_normalize()) {
            if profile.texture >= textures {
                let what = format!("its profile is texture {}, but there are only {textures}", profile.texture);
                return Err(invalid("shaping of a light", what));
            }
            if profile.side.reject_from_normalized(axis).try_normalize().is_none() {
                return Err(invalid("shaping of a light", "the side of its profile must not be along its axis"));
            }
        }
        let in_range = cone > 0.0 && cone <= std::f32::consts::PI && (0.0..=1.0).contains(&softness);
        if aimed && in_range && focus.is_finite() && focus >= 0.0 {
            Ok(())
        } else {
            let what = "its axis must not be zero, its cone in (0, π], its softness in [0, 1], its focus not negative";
            Err(invalid("shaping of a light", what))
        }
    }
}

/// Projection of the lower half of a dome's texture onto a disk of ground. It only changes the background that the
/// camera sees: lighting is unchanged, and the ground receives no shadows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// The centre of the ground, below the position where the image was taken. Up is +y of the light's own frame.
    pub origin: Vec3,
    /// Height of that position above the ground; positive.
    pub height: f32,
    /// Radius of the ground; positive. Beyond it, the image is on a sphere that meets the ground at its edge.
    pub radius: f32,
}

impl LightShape {
    /// The kind of the light: `dome`, `distant`, `rect`, `disk`, `point`, `sphere` or `cylinder`.
    pub fn kind(&self) -> &'static str {
        match self {
            LightShape::Dome { .. } => "dome",
            LightShape::Distant { .. } => "distant",
            LightShape::Rect { .. } => "rect",
            LightShape::Disk { .. } => "disk",
            LightShape::Point { .. } => "point",
            LightShape::Sphere { .. } => "sphere",
            LightShape::Cylinder { .. } => "cylinder",
        }
    }

    /// Checks that all numbers are finite, that sizes are positive and colours not negative, and that the texture
    /// exists in a scene with this number of textures.
    ///
    /// # Errors
    /// [`Error::Invalid`] for the first problem.
    pub fn validate(&self, textures: usize) -> Result<(), Error> {
        let (place, color, texture, finite) = match self {
            LightShape::Dome { radiance, texture, rotation, ground } => {
                let positive = |x: f32| x.is_finite() && x > 0.0;
                let laid = |g: &Ground| g.origin.is_finite() && positive(g.height) && positive(g.radius);
                ("dome light", radiance, *texture, rotation.is_finite() && ground.iter().all(laid))
            }
            LightShape::Distant { direction, half_angle, irradiance } => {
                let finite = direction.is_finite() && direction.length() > 0.0 && half_angle.is_finite();
                ("distant light", irradiance, None, finite && *half_angle >= 0.0)
            }
            LightShape::Rect { to_world, radiance, texture } => {
                ("rect light", radiance, *texture, to_world.is_finite())
            }
            LightShape::Disk { to_world, radiance } => ("disk light", radiance, None, to_world.is_finite()),
            LightShape::Point { position, intensity } => ("point light", intensity, None, position.is_finite()),
            LightShape::Sphere { center, radius, radiance } => {
                ("sphere light", radiance, None, center.is_finite() && radius.is_finite() && *radius > 0.0)
            }
            LightShape::Cylinder { center, half_axis, radius, radiance } => {
                let length = half_axis.length();
                let finite = center.is_finite() && length.is_finite() && radius.is_finite();
                ("cylinder light", radiance, None, finite && length > 0.0 && *radius > 0.0)
            }
        };
        if !finite {
            return Err(invalid(place, "its position and size must be finite, and its size positive"));
        }
        if color.iter().any(|c| !(c.is_finite() && *c >= 0.0)) {
            return Err(invalid(place, format!("its colour is {color:?}: no channel may be negative or infinite")));
        }
        match texture {
            Some(index) if index >= textures => Err(invalid(place, "the texture does not exist")),
            _ => Ok(()),
        }
    }
}
