//! A curling lock of hair that hangs from a small round patch.

use super::glow::glow;
use super::props;
use crate::error::Error;
use crate::grow::grow;
use crate::roots::Site;
use crate::scenes::Preset;
use crate::settings::{Clump, Draw, GrowSettings, Maps};
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, TAU};
use vellus::Species;
use vellus_scene::{Camera, Look, Mesh, Parameter, Scene, Surface};

pub(super) fn scene(small: bool, preset: Preset) -> Result<Scene, Error> {
    let mesh = patch(1.4);
    let (count, segments, wider) = if small { (200, 52, 2.0) } else { (1000, 210, 1.0) };
    let settings = GrowSettings {
        name: "hair-lock".to_owned(),
        count,
        segments,
        length: 22.0,
        length_variation: 0.12,
        radius: [0.005 * wider, 0.003 * wider],
        lift: [FRAC_PI_2, FRAC_PI_2],
        spread: 0.02,
        // Several thin locks curl together.
        clump: Clump { strands: count / 9, strength: 0.85, power: 0.4 },
        curl_radius: 1.5,
        curl_turns: 3.0,
        stray: 0.04,
        curl_variation: 0.25,
        noise: 0.02,
        seed: 4,
        ..GrowSettings::default()
    };
    let color = |_: &Site, draw: &Draw| [0.8 + 0.4 * draw.random, 0.25 + 0.15 * draw.random, 0.0];
    let maps = Maps { color: Some((Parameter::Melanin, &color)), ..Maps::default() };
    let mut scene = Scene { strands: vec![grow(&mesh, &settings, &maps)?], ..Scene::default() };
    scene.looks.push(Look::constant("hair", preset(Species::Human)));
    scene.meshes.push(mesh);
    scene.surfaces.push(Surface::diffuse("patch", [0.02; 3]));
    let target = Vec3::new(0.0, -13.4, 0.0);
    // A key light for R and TRT, and a light behind the lock for TT.
    scene.lights.push(props::window(Vec3::new(34.0, 22.0, 40.0), target, Vec2::splat(20.0), [66.0, 63.5, 60.0]));
    scene.lights.push(props::window(Vec3::new(-40.0, 6.0, -34.0), target, Vec2::splat(22.0), [40.0, 41.5, 44.0]));
    glow(&mut scene, Vec3::new(0.05, -0.1, -1.0), 0.35, Vec3::new(0.72, 0.71, 0.69), Vec3::new(0.26, 0.265, 0.28));
    scene.camera = Some(Camera::look_at(Vec3::new(0.0, -13.4, 90.0), target, Vec3::Y, 12.4f32.to_radians(), 1.5));
    Ok(scene)
}

/// A disk at the origin that faces down.
fn patch(radius: f32) -> Mesh {
    const SIDES: u32 = 32;
    let rim = |i: u32| {
        let (sin, cos) = (TAU * i as f32 / SIDES as f32).sin_cos();
        radius * Vec3::new(cos, 0.0, sin)
    };
    Mesh {
        name: "patch".to_owned(),
        positions: std::iter::once(Vec3::ZERO).chain((0..SIDES).map(rim)).collect(),
        triangles: (0..SIDES).map(|i| [0, 1 + i, 1 + (i + 1) % SIDES]).collect(),
        normals: None,
        uv: None,
        moved: None,
        surface: 0,
    }
}
