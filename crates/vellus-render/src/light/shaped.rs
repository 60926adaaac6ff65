//! The shaping of a light, prepared for rays.

use glam::Vec3;
use vellus_scene::Shaping;

/// Directions for the mean of the factor.
const DIRECTIONS: usize = 1024;

/// A shaping with an axis of unit length, and bounds that spare the angle of most directions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shaped {
    shaping: Shaping,
    /// The cosines of the cone, and of the angle where its soft edge begins.
    cos_end: f32,
    cos_start: f32,
    /// The mean factor over the directions in which the light emits, weighted by its emission. Lights are chosen by
    /// their power, which is multiplied by it.
    pub mean: f32,
}

impl Shaped {
    /// Prepares a shaping. `face` is the direction that a flat light faces. It is `None` if the light emits in all
    /// directions.
    pub(super) fn new(shaping: &Shaping, face: Option<Vec3>) -> Self {
        let shaping = Shaping { axis: shaping.axis.normalize(), ..*shaping };
        let start = (1.0 - shaping.softness) * shaping.cone;
        let mut shaped = Shaped { shaping, cos_end: shaping.cone.cos(), cos_start: start.cos(), mean: 0.0 };
        // The directions of a spiral about the axis cover the sphere evenly.
        let (x, y) = shaping.axis.any_orthonormal_pair();
        let (mut sum, mut weights) = (0.0, 0.0);
        for i in 0..DIRECTIONS {
            let cos = 1.0 - 2.0 * (i as f32 + 0.5) / DIRECTIONS as f32;
            let (sin_phi, cos_phi) = (i as f32 * 2.399_963).sin_cos();
            let direction = (x * cos_phi + y * sin_phi) * (1.0 - cos * cos).sqrt() + shaping.axis * cos;
            let weight = face.map_or(1.0, |face| face.dot(direction).max(0.0));
            sum += weight * shaped.factor(direction);
            weights += weight;
        }
        // A cone narrower than the spiral's steps must still be chosen.
        let narrow = 0.5 * (1.0 - shaped.cos_end);
        shaped.mean = (sum / weights).max(1e-3 * narrow).max(1e-6);
        shaped
    }

    /// The shaping, and the cosines of the cone and of the angle where its soft edge begins.
    pub(crate) fn packed(&self) -> (&Shaping, f32, f32) {
        (&self.shaping, self.cos_end, self.cos_start)
    }

    /// [`Shaping::factor`], for a direction away from the light.
    pub(super) fn factor(&self, direction: Vec3) -> f32 {
        let cos = direction.dot(self.shaping.axis);
        if cos < self.cos_end {
            0.0
        } else if cos >= self.cos_start && self.shaping.focus == 0.0 {
            1.0
        } else {
            self.shaping.factor(direction)
        }
    }
}
