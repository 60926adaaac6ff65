//! A procedural sky with a sun.

use super::coat::smoothstep;
use super::noise::noise;
use super::props;
use glam::Vec3;
use std::f32::consts::{PI, TAU};
use vellus_scene::{Scene, Texture, Wrap};

const WIDTH: usize = 512;
const HEIGHT: usize = 256;

/// Adds a clear sky with a sun in this direction.
pub(super) fn sky(scene: &mut Scene, sun: Vec3) {
    scene.lights.push(props::dome([1.0; 3], Some(scene.textures.len())));
    scene.textures.push(image(sun));
}

/// A lat-long image of a clear sky. The centre is −z, the top +y, and +x is right of the centre. The radiance is about
/// 1 at the zenith. Woods stand along the horizon. The sun has about twice the irradiance of the sky.
fn image(sun: Vec3) -> Texture {
    let sun = sun.normalize_or(Vec3::Y);
    let pixels = (0..WIDTH * HEIGHT).map(|i| {
        let phi = TAU * ((i % WIDTH) as f32 + 0.5) / WIDTH as f32 - PI;
        let elevation = PI * (0.5 - ((i / WIDTH) as f32 + 0.5) / HEIGHT as f32);
        let (level, up) = (elevation.cos(), elevation.sin());
        let direction = Vec3::new(level * phi.sin(), up, -level * phi.cos());
        radiance(direction, sun).to_array()
    });
    Texture { name: "sky".to_owned(), width: WIDTH, height: HEIGHT, pixels: pixels.collect(), wrap: [Wrap::Repeat; 2] }
}

fn radiance(direction: Vec3, sun: Vec3) -> Vec3 {
    let (zenith, horizon) = (Vec3::new(0.32, 0.55, 1.0), Vec3::new(0.95, 1.0, 1.05));
    let ground = Vec3::new(0.24, 0.22, 0.17);
    let up = direction.y;
    let sky = horizon.lerp(zenith, up.max(0.0).powf(0.45));
    let ground = ground.lerp(horizon, (1.0 + 12.0 * up).clamp(0.0, 1.0) * 0.5);
    let background = woods(direction, if up >= 0.0 { sky } else { ground });
    // A disc with a blur of four pixels, and a haze around it.
    let angle = direction.angle_between(sun).to_degrees();
    let disc = 1800.0 * (-(angle / 1.6).powi(2)).exp();
    let haze = 1.2 * (-angle / 12.0).exp();
    background + (disc + haze) * Vec3::new(1.0, 0.9, 0.74)
}

/// Distant trees in front of `background`, out of focus.
fn woods(direction: Vec3, background: Vec3) -> Vec3 {
    let flat = Vec3::new(direction.x, 0.0, direction.z).normalize_or(Vec3::X);
    let height = 0.085 + 0.035 * noise(5.0 * flat) + 0.02 * noise(17.0 * flat);
    let shade = 0.75 + 0.35 * noise(Vec3::new(20.0 * flat.x, 40.0 * direction.y, 20.0 * flat.z));
    // Haze makes the foot of the woods paler.
    let leaves =
        shade * Vec3::new(0.12, 0.17, 0.06).lerp(Vec3::new(0.3, 0.34, 0.26), smoothstep(0.06, 0.0, direction.y));
    background.lerp(leaves, smoothstep(height + 0.02, height - 0.02, direction.y) * f32::from(direction.y > -0.02))
}
