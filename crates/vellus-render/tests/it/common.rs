//! A small picture, and what tests of pictures share.

use glam::{Mat3, Vec3, Vec4};
use vellus::{Fiber, Species};
use vellus_render::{Film, Layer, Settings, World};
use vellus_scene::{Basis, Camera, Light, LightShape, Look, Scene, Strands};

/// One strand.
pub fn world() -> World {
    World::new(fox()).unwrap()
}

/// The scene of [`world`].
pub fn fox() -> Scene {
    let strands = Strands {
        name: "fur".to_owned(),
        basis: Basis::Linear,
        starts: vec![0, 2],
        points: vec![Vec4::new(-0.5, 0.0, 0.0, 0.1), Vec4::new(0.5, 0.1, 0.0, 0.1)],
        moved: None,
        normals: None,
        root_uv: None,
        look: 0,
        varying: vec![],
    };
    Scene {
        strands: vec![strands],
        looks: vec![Look::constant("fox", Fiber::preset(Species::RedFox))],
        camera: Some(Camera::look_at(Vec3::Z * 3.0, Vec3::ZERO, Vec3::Y, 0.5, 1.0)),
        ..Scene::default()
    }
}

/// 8 by 8 pixels.
pub fn settings() -> Settings {
    Settings::new([8, 8])
}

/// A number in [0, 1) that looks random.
pub fn noise(i: usize, k: u32) -> f32 {
    ((i as f32 * 12.9898 + k as f32 * 78.233).sin() * 43758.547).rem_euclid(1.0)
}

/// A white sky.
pub fn dome() -> Light {
    LightShape::Dome { radiance: [1.0; 3], texture: None, rotation: Mat3::IDENTITY, ground: None }.into()
}

/// The mean of a channel over the picture.
pub fn mean(film: &Film, layer: Layer, channel: usize) -> f64 {
    let (w, h) = (film.width(), film.height());
    (0..w * h).map(|i| film.mean(i % w, i / w, layer, channel)).sum::<f64>() / (w * h) as f64
}

/// The variable that chooses the folder of rescued films.
pub const STATE: &str = if cfg!(windows) { "LOCALAPPDATA" } else { "XDG_STATE_HOME" };
