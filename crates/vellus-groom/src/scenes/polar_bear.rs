//! A standing polar bear cub that faces +x. Its fur does not absorb light.

use super::coat::Coat;
use super::eyes::Eye;
use super::props;
use super::whiskers::Whiskers;
use crate::body::{Body, Flow};
use crate::error::Error;
use crate::scenes::Preset;
use crate::settings::{Clump, GrowSettings};
use glam::{Quat, Vec2, Vec3};
use vellus::{Fiber, Species};
use vellus_scene::{Camera, Scene};

pub(super) fn scene(small: bool, preset: Preset) -> Result<Scene, Error> {
    let body = body();
    let eye = body.project(Vec3::new(39.2, 36.6, 3.4)) - Vec3::new(0.1, 0.0, 0.05);
    let nose = body.project(Vec3::new(49.0, 32.6, 0.0)) - Vec3::new(0.5, 0.0, 0.0);
    let mirrored = |p: Vec3| Vec3::new(p.x, p.y, -p.z);
    let mut scene = Scene::default();
    Coat {
        body: &body,
        step: 0.5,
        soft: 1.2,
        settings: GrowSettings {
            name: "polar-bear".to_owned(),
            count: 300_000,
            segments: 16,
            length: 1.0,
            length_variation: 0.25,
            radius: [0.01, 0.003],
            guard_share: 0.25,
            guard_scale: [1.4, 1.3],
            lift: [0.7, 0.25],
            spread: 0.18,
            gravity: 0.25,
            clump: Clump { strands: 40, strength: 0.7, power: 1.3 },
            stray: 0.03,
            noise: 0.06,
            ..GrowSettings::default()
        },
        // The refractive index of Yan17 Fig. 6, and the medulla of the dog, whose fit has almost no absorption.
        fiber: Fiber { eta: 1.45, ..preset(Species::Dog) }.without_absorption(),
        melanin: &|_, _| [0.0, 0.0],
        patch: 8.0,
        bare: [(eye, 1.0), (mirrored(eye), 1.0), (nose, 1.5)].into_iter().chain(lips()).collect(),
        // The skin of polar bears is black, but real bears have more hair to cover it.
        skin: 0.4,
    }
    .add(&mut scene, small)?;

    let eye = Eye {
        center: eye,
        radius: 0.95,
        gaze: Vec3::new(1.0, 0.05, 0.4),
        opening: [1.0, 0.68, 0.6],
        tilt: 0.15,
        iris: [0.035, 0.018, 0.01],
        iris_radius: 1.0,
        pupil: [0.5, 0.5],
        lid: [0.012; 3],
    };
    eye.add(&mut scene);
    eye.mirrored().add(&mut scene);
    Whiskers {
        pad: Vec3::new(45.0, 31.6, 2.4),
        spacing: [0.5, 0.6],
        count: [2, 4],
        direction: Vec3::new(0.1, -0.15, 1.0),
        length: 3.5,
        radius: 0.014,
        melanin: [0.0; 2],
    }
    .add(&mut scene, |p| body.project(p));
    let wet = props::glossy("nose", [0.012; 3], 0.35);
    props::ellipsoid(&mut scene, nose, Vec3::new(1.2, 1.1, 1.6), Quat::IDENTITY, wet);
    let skin = props::glossy("mouth", [0.02, 0.018, 0.018], 0.5);
    props::ellipsoid(&mut scene, MOUTH, Vec3::new(4.3, 0.28, 2.75), Quat::from_rotation_z(-0.12), skin);
    for (paw, x) in [(Vec3::new(16.5, 0.9, 7.0), 6.1), (Vec3::new(-15.0, 0.9, 7.6), 6.4)] {
        for i in 0..5 {
            let across = i as f32 - 2.0;
            let claw = paw + Vec3::new(x - 0.28 * across * across, 0.0, 1.55 * across);
            let turn = Quat::from_rotation_y(-0.12 * across) * Quat::from_rotation_z(-0.35);
            for claw in [claw, mirrored(claw)] {
                let horn = props::glossy("claw", [0.03, 0.027, 0.025], 0.25);
                props::ellipsoid(&mut scene, claw, Vec3::new(1.25, 0.36, 0.38), turn, horn);
            }
        }
    }
    let view = Vec3::new(0.76, 0.12, 0.64).normalize();
    // A bank of snow rises behind the bear.
    let forward = (view - view.y * Vec3::Y).normalize();
    props::strip(&mut scene, &props::room(110.0, 190.0), forward, 1200.0, [0.62, 0.66, 0.72]);
    let target = Vec3::new(8.0, 21.0, 0.0);
    scene.lights.push(props::window(Vec3::new(70.0, 150.0, 110.0), target, Vec2::splat(130.0), [8.6, 8.1, 7.3]));
    scene.lights.push(props::dome([0.3, 0.36, 0.46], None));
    let eye = target + 190.0 * view;
    scene.camera = Some(Camera::look_at(eye, target, Vec3::Y, 19f32.to_radians(), 1.5));
    Ok(scene)
}

/// Centre of the gap between upper and lower jaw.
const MOUTH: Vec3 = Vec3::new(43.2, 30.2, 0.0);

/// Bare spheres along the lips: centres and radii.
fn lips() -> impl Iterator<Item = (Vec3, f32)> {
    (0..13).flat_map(|i| {
        let (sin, cos) = (-0.6 + 0.2 * *super::opaque(&i) as f32 - 0.6).sin_cos();
        let side = MOUTH + Vec3::new(4.0 * cos, -0.12 * 4.0 * cos, 2.5 * sin);
        [(side, 0.55), (Vec3::new(side.x, side.y, -side.z), 0.55)]
    })
}

pub(super) fn body() -> Body {
    let back = Flow::Along(Vec3::new(-1.0, -0.45, 0.0));
    let face = Flow::AwayFrom(Vec3::new(49.0, 31.5, 0.0));
    let straight = Quat::IDENTITY;
    let body = Body::default()
        .ellipsoid([-12.0, 24.0, 0.0], [14.0, 12.5, 11.5], straight, 3.0, back, 3.4)
        .ellipsoid([0.0, 23.0, 0.0], [20.0, 11.8, 11.0], straight, 4.0, back, 3.4)
        .ellipsoid([13.0, 23.5, 0.0], [11.0, 11.5, 10.0], straight, 4.0, back, 3.2)
        .cone([18.0, 26.0, 0.0], 8.8, [30.0, 33.0, 0.0], 6.4, 5.0, 2.6)
        .flowing(back)
        .ellipsoid([34.0, 35.0, 0.0], [6.8, 6.4, 6.8], straight, 3.0, face, 1.3)
        .cone([38.0, 33.6, 0.0], 3.9, [46.0, 31.6, 0.0], 2.5, 2.0, 0.6)
        .flowing(face)
        .cone([37.5, 30.9, 0.0], 2.9, [44.0, 29.7, 0.0], 1.7, 0.5, 0.6)
        .flowing(face)
        .cone([-25.0, 25.0, 0.0], 2.8, [-28.5, 21.5, 0.0], 2.0, 2.0, 2.2);
    let first = body.len();
    body.ellipsoid([33.0, 32.8, 4.0], [4.0, 3.8, 3.6], straight, 2.0, face, 2.2)
        .ellipsoid([30.6, 40.6, 4.8], [1.1, 2.3, 2.1], Quat::from_rotation_x(0.4), 1.2, Flow::Along(Vec3::Y), 0.8)
        .ellipsoid([31.9, 40.8, 5.0], [0.9, 1.5, 1.3], Quat::from_rotation_x(0.4), 0.5, Flow::Along(Vec3::Y), 0.6)
        .carved()
        .cone([14.0, 19.0, 6.4], 6.4, [14.5, 5.0, 6.8], 4.3, 3.0, 2.4)
        .ellipsoid([16.5, 3.0, 7.0], [5.2, 3.0, 4.4], straight, 3.0, Flow::Along(Vec3::new(1.0, -0.6, 0.0)), 1.5)
        .ellipsoid([-14.0, 18.0, 6.6], [9.0, 10.0, 5.6], straight, 3.0, Flow::Along(-Vec3::Y), 3.0)
        .cone([-15.0, 12.0, 7.2], 5.8, [-17.5, 4.8, 7.4], 4.3, 3.0, 2.4)
        .ellipsoid([-15.0, 3.0, 7.6], [5.6, 3.0, 4.4], straight, 3.0, Flow::Along(Vec3::new(1.0, -0.6, 0.0)), 1.5)
        .mirrored_z(first)
}
