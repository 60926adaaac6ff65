//! A small picture.

use glam::{Vec3, Vec4};
use vellus::{Fiber, Species};
use vellus_render::{Settings, World};
use vellus_scene::{Basis, Camera, Look, Scene, Strands};

/// One strand.
pub fn world() -> World {
    let strands = Strands {
        name: "fur".to_owned(),
        basis: Basis::Linear,
        starts: vec![0, 2],
        points: vec![Vec4::new(-0.5, 0.0, 0.0, 0.1), Vec4::new(0.5, 0.1, 0.0, 0.1)],
        moved: None,
        root_uv: None,
        look: 0,
        varying: vec![],
    };
    let scene = Scene {
        strands: vec![strands],
        looks: vec![Look::constant("fox", Fiber::preset(Species::RedFox))],
        camera: Some(Camera::look_at(Vec3::Z * 3.0, Vec3::ZERO, Vec3::Y, 0.5, 1.0)),
        ..Scene::default()
    };
    World::new(scene).unwrap()
}

/// 8 by 8 pixels.
pub fn settings() -> Settings {
    Settings::new([8, 8])
}
