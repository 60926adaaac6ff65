//! Images of a whole sky in a disk: angular maps and mirrored balls.

use glam::{DVec2, DVec3};
use std::f64::consts::PI;
use vellus_scene::{Texture, Wrap};

/// How far from the middle of its image a direction is, as a part of the disk's radius.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Probe {
    /// In proportion to the angle from the direction of the middle.
    Angular,
    /// As in a mirrored ball that is seen from far away: the sine of half of the angle.
    MirroredBall,
}

impl Probe {
    /// The lat-long image of a probe, with about as many pixels. Both have the same direction in their middle, and
    /// right and up are the same there.
    pub fn latlong(self, probe: &Texture) -> Texture {
        let probe = Texture { wrap: [Wrap::Clamp; 2], ..probe.clone() };
        let height = (probe.pixels.len() as f64 / 2.0).sqrt().ceil() as usize;
        let width = 2 * height;
        let mut sky =
            Texture { name: probe.name.clone(), width, height, pixels: Vec::new().into(), wrap: [Wrap::Repeat; 2] };
        sky.pixels = (0..width * height)
            .map(|i| {
                let uv = sky.uv(i % width, i / width).as_dvec2() - 0.5;
                let (sin, cos) = (2.0 * PI * uv.x).sin_cos();
                let (up, level) = (PI * uv.y).sin_cos();
                probe.at((0.5 + 0.5 * self.place(DVec3::new(level * sin, up, level * cos))).as_vec2())
            })
            .collect();
        sky
    }

    /// The place of a direction in the disk of radius 1. z is the direction of the middle, x is right and y is up.
    fn place(self, direction: DVec3) -> DVec2 {
        let angle = direction.z.clamp(-1.0, 1.0).acos();
        let radius = match self {
            Probe::Angular => angle / PI,
            Probe::MirroredBall => (0.5 * angle).sin(),
        };
        direction.truncate().normalize_or_zero() * radius
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_at_their_places_in_the_disk() {
        let right = DVec3::X;
        assert!((Probe::Angular.place(right) - DVec2::new(0.5, 0.0)).length() < 1e-12);
        assert!((Probe::MirroredBall.place(right) - DVec2::new(0.5f64.sqrt(), 0.0)).length() < 1e-12);
        for probe in [Probe::Angular, Probe::MirroredBall] {
            assert_eq!(probe.place(DVec3::Z), DVec2::ZERO);
            let behind = DVec3::new(0.0, 1e-6, -1.0).normalize();
            assert!((probe.place(behind) - DVec2::Y).length() < 1e-5);
        }
    }

    /// An angular map whose red is the part of its radius becomes a sky whose red is the angle from the middle.
    #[test]
    fn the_sky_has_the_light_of_the_probe() {
        const SIZE: usize = 64;
        let radius = |i: usize| {
            let middle = DVec2::splat(0.5 * SIZE as f64 - 0.5);
            (DVec2::new((i % SIZE) as f64, (i / SIZE) as f64) - middle).length() / (0.5 * SIZE as f64)
        };
        let pixels = (0..SIZE * SIZE).map(|i| [radius(i) as f32, 0.0, 0.0]).collect();
        let probe = Texture { name: "probe".to_owned(), width: SIZE, height: SIZE, pixels, wrap: [Wrap::Repeat; 2] };
        let sky = Probe::Angular.latlong(&probe);
        assert_eq!((sky.width, sky.height), (92, 46));
        // The middle, the zenith and the left edge: 0, 90 and nearly 180 degrees. A pixel is 4 degrees wide.
        let at = |u: f32, v: f32| sky.at(glam::Vec2::new(u, v))[0];
        assert!(at(0.5, 0.5) < 0.03 && (at(0.3, 0.999) - 0.5).abs() < 0.03 && at(0.001, 0.5) > 0.96);
    }
}
