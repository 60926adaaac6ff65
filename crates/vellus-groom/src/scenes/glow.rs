//! A studio background: a dome that is brightest behind the subject.

use super::coat::smoothstep;
use super::props;
use glam::Vec3;
use std::f32::consts::{PI, TAU};
use vellus_scene::{Scene, Texture, Wrap};

const WIDTH: usize = 256;
const HEIGHT: usize = 128;

/// Adds a dome with radiance `bright` in the direction `center`, and radiance `dark` from an angle of `reach` radians
/// around it.
pub(super) fn glow(scene: &mut Scene, center: Vec3, reach: f32, bright: Vec3, dark: Vec3) {
    let center = center.normalize_or(Vec3::NEG_Z);
    let pixels = (0..WIDTH * HEIGHT).map(|i| {
        let phi = TAU * ((i % WIDTH) as f32 + 0.5) / WIDTH as f32 - PI;
        let elevation = PI * (0.5 - ((i / WIDTH) as f32 + 0.5) / HEIGHT as f32);
        let level = elevation.cos();
        let direction = Vec3::new(level * phi.sin(), elevation.sin(), -level * phi.cos());
        dark.lerp(bright, smoothstep(reach, 0.0, direction.angle_between(center))).to_array()
    });
    let pixels = pixels.collect();
    let texture = Some(scene.textures.len());
    scene.lights.push(props::dome([1.0; 3], texture));
    scene.textures.push(Texture {
        name: "studio".to_owned(),
        width: WIDTH,
        height: HEIGHT,
        pixels,
        wrap: [Wrap::Repeat; 2],
    });
}
