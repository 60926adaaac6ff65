//! The shaping of a light, prepared for rays.

use super::brightness;
use glam::Vec3;
use vellus_scene::{Profile, Shaping, Texture, Wrap};

/// Directions for the mean of the factor.
const DIRECTIONS: usize = 1024;

/// A shaping with an axis of unit length, and bounds that spare the angle of most directions.
#[derive(Clone, Debug)]
pub(crate) struct Shaped {
    shaping: Shaping,
    /// The cosines of the cone, and of the angle where its soft edge begins.
    cos_end: f32,
    cos_start: f32,
    /// The mean factor over the directions in which the light emits, weighted by its emission. Lights are chosen by
    /// their power, which is multiplied by it.
    pub mean: f32,
    /// The image of the profile.
    image: Option<(Profile, Texture)>,
}

impl Shaped {
    /// Prepares a shaping. `face` is the direction that a flat light faces. It is `None` if the light emits in all
    /// directions.
    pub(super) fn new(shaping: &Shaping, face: Option<Vec3>, textures: &[Texture]) -> Self {
        let shaping = Shaping { axis: shaping.axis.normalize(), ..*shaping };
        let start = (1.0 - shaping.softness) * shaping.cone;
        let image = |profile: Profile| {
            (profile, Texture { wrap: [Wrap::Repeat, Wrap::Clamp], ..textures[profile.texture].clone() })
        };
        let image = shaping.profile.map(image);
        let mut shaped = Shaped { shaping, cos_end: shaping.cone.cos(), cos_start: start.cos(), mean: 0.0, image };
        // The directions of a spiral about the axis cover the sphere evenly.
        let (x, y) = shaping.axis.any_orthonormal_pair();
        let (mut sum, mut weights) = (0.0, 0.0);
        for i in 0..DIRECTIONS {
            let cos = 1.0 - 2.0 * (i as f32 + 0.5) / DIRECTIONS as f32;
            let (sin_phi, cos_phi) = (i as f32 * 2.399_963).sin_cos();
            let direction = (x * cos_phi + y * sin_phi) * (1.0 - cos * cos).sqrt() + shaping.axis * cos;
            let weight = face.map_or(1.0, |face| face.dot(direction).max(0.0));
            sum += weight * brightness(shaped.factor(direction)) / 3.0;
            weights += weight;
        }
        // A cone narrower than the spiral's steps must still be chosen.
        let narrow = 0.5 * (1.0 - shaped.cos_end);
        shaped.mean = (sum / weights).max(1e-3 * narrow).max(1e-6);
        shaped
    }

    /// The shaping, the cosine of the cone, and the profile with its image.
    pub(crate) fn packed(&self) -> (&Shaping, f32, Option<&(Profile, Texture)>) {
        (&self.shaping, self.cos_end, self.image.as_ref())
    }

    /// [`Shaping::factor`] times the profile, for a direction away from the light.
    pub(super) fn factor(&self, direction: Vec3) -> [f32; 3] {
        let cos = direction.dot(self.shaping.axis);
        if cos < self.cos_end {
            return [0.0; 3];
        }
        let plain = cos >= self.cos_start && self.shaping.focus == 0.0;
        let factor = if plain { [1.0; 3] } else { self.shaping.factor(direction) };
        let Some((profile, image)) = &self.image else { return factor };
        let uv = profile.uv(self.shaping.axis, direction, [image.width, image.height]);
        factor.map(|x| x * image.at(uv)[0])
    }
}
