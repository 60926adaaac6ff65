//! A golden hamster that sits up and faces +x, in a studio with a curved backdrop from the floor to the ceiling.

use super::coat::{Coat, mix, smoothstep, to_segment};
use super::eyes::Eye;
use super::noise::noise;
use super::props;
use super::toes::Toes;
use super::tube::{curve, tube};
use super::whiskers::Whiskers;
use crate::body::{Body, Flow};
use crate::error::Error;
use crate::scenes::Preset;
use crate::settings::{Clump, Draw, GrowSettings};
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::PI;
use vellus::Species;
use vellus_scene::{Camera, Scene};

pub(super) fn scene(small: bool, preset: Preset) -> Result<Scene, Error> {
    let mut scene = animal(small, preset)?;
    let forward = Vec3::new(0.7, 0.0, 0.72).normalize();
    props::strip(&mut scene, &capsule(), forward, 150.0, [0.78, 0.77, 0.75]);
    let center = Vec3::new(1.0, 4.0, 0.0);
    // The light in front is low, for the belly.
    for (across, along, up, radiance) in [(-22.0, 12.0, 44.0, 16.0), (0.0, 54.0, 32.0, 18.0), (24.0, 4.0, 44.0, 15.0)] {
        let from = along * forward + across * forward.cross(Vec3::Y) + up * Vec3::Y;
        let color = [radiance, 0.97 * radiance, 0.92 * radiance];
        scene.lights.push(props::window(from, center, Vec2::new(14.0, 14.0), color));
    }
    let target = Vec3::new(0.4, 5.0, 0.0);
    let eye = target + 62.0 * (forward + 0.2 * Vec3::Y).normalize();
    scene.camera = Some(Camera::look_at(eye, target, Vec3::Y, 14f32.to_radians(), 1.5));
    Ok(scene)
}

/// The hamster alone, on the ground y = 0, without light and camera.
pub(super) fn animal(small: bool, preset: Preset) -> Result<Scene, Error> {
    let body = body();
    let eye = body.project(Vec3::new(5.0, 8.3, 1.9)) + Vec3::new(0.06, 0.02, 0.06);
    let nose = body.project(Vec3::new(7.2, 7.3, 0.0)) - Vec3::new(0.1, 0.0, 0.0);
    let mirrored = |p: Vec3| Vec3::new(p.x, p.y, -p.z);
    let lips = curve(&MOUTH, |p| body.project(p));
    let bare = [(eye, 0.64), (mirrored(eye), 0.64), (nose, 0.32)];
    let lip = |p: &Vec3| [(*p, 0.1), (mirrored(*p), 0.1)];
    let mut scene = Scene::default();
    Coat {
        body: &body,
        step: 0.14,
        soft: 0.3,
        settings: GrowSettings {
            name: "hamster".to_owned(),
            count: 580_000,
            segments: 15,
            length: 1.0,
            length_variation: 0.25,
            radius: [0.003, 0.0008],
            guard_share: 0.15,
            guard_scale: [1.6, 1.3],
            lift: [0.8, 0.35],
            spread: 0.15,
            gravity: 0.1,
            clump: Clump { strands: 60, strength: 0.5, power: 1.5 },
            stray: 0.03,
            noise: 0.05,
            ..GrowSettings::default()
        },
        // The paper uses the fibre of a mouse for the hamster.
        fiber: preset(Species::Mouse),
        melanin: &melanin,
        patch: 1.6,
        bare: bare.into_iter().chain(lips.iter().flat_map(lip)).collect(),
        skin: 0.6,
    }
    .add(&mut scene, small)?;

    let eye = Eye {
        center: eye,
        radius: 0.6,
        gaze: Vec3::new(0.75, 0.12, 0.75),
        opening: [1.15, 0.95, 0.85],
        tilt: 0.1,
        iris: [0.012, 0.006, 0.004],
        iris_radius: 1.4,
        pupil: [0.7, 0.7],
        lid: [0.05, 0.03, 0.025],
    };
    eye.add(&mut scene);
    eye.mirrored().add(&mut scene);
    let skin = props::glossy("mouth", [0.3, 0.12, 0.1], 0.5);
    for side in [lips.clone(), lips.into_iter().map(mirrored).collect()] {
        tube(&mut scene, &side, 0.06, skin.clone());
    }
    Whiskers {
        pad: Vec3::new(5.9, 6.8, 0.8),
        spacing: [0.2, 0.24],
        count: [4, 4],
        direction: Vec3::new(0.1, 0.0, 1.0),
        length: 3.0,
        radius: 0.009,
        melanin: [0.3, 0.3],
    }
    .add(&mut scene, |p| body.project(p));
    let paw = props::glossy("toe", [0.62, 0.36, 0.31], 0.5);
    for (tip, length) in [(Vec3::new(5.75, 3.98, 1.4), 0.3), (Vec3::new(2.75, 0.17, 3.35), 0.38)] {
        Toes { tip, count: 4, radii: Vec3::new(length, 0.13, 0.11), spacing: 1.1, fan: 0.22 }.add(&mut scene, &paw);
    }
    let pink = props::glossy("nose", [0.55, 0.25, 0.22], 0.4);
    props::ellipsoid(&mut scene, nose, Vec3::new(0.25, 0.24, 0.34), Quat::IDENTITY, pink);

    Ok(scene)
}

/// The right half of the mouth, from under the nose to its corner.
const MOUTH: [[f32; 3]; 5] = [[6.4, 6.75, 0.0], [6.2, 6.4, 0.0], [5.9, 6.22, 0.22], [5.5, 6.15, 0.5], [5.0, 6.2, 0.75]];

/// The profile of the backdrop, from the front of the ceiling over the back to the front of the floor.
fn capsule() -> Vec<Vec2> {
    const RADIUS: f32 = 25.0;
    let turn = |i: i32| {
        let angle = PI * *super::opaque(&i) as f32 / 32.0;
        Vec2::new(-18.0 - RADIUS * angle.sin(), RADIUS * (1.0 - angle.cos()))
    };
    let front = |y: f32| Vec2::new(140.0, y);
    let mut profile = vec![front(0.0)];
    profile.extend((0..=32).map(turn));
    profile.push(front(2.0 * RADIUS));
    profile.reverse();
    profile
}

pub(super) fn body() -> Body {
    let back = Flow::Along(Vec3::new(-0.8, -0.6, 0.0));
    let face = Flow::AwayFrom(Vec3::new(6.9, 7.1, 0.0));
    let straight = Quat::IDENTITY;
    // The chest rises toward the head.
    let upright = Quat::from_rotation_z(0.6);
    let body = Body::default()
        .ellipsoid([-2.2, 4.2, 0.0], [4.3, 4.2, 4.2], straight, 1.0, back, 1.1)
        .ellipsoid([0.6, 4.7, 0.0], [4.3, 3.6, 3.7], upright, 1.6, back, 0.95)
        .ellipsoid([3.3, 7.6, 0.0], [2.6, 2.3, 2.4], straight, 0.9, face, 0.65)
        .ellipsoid([5.2, 7.0, 0.0], [1.45, 0.95, 1.05], Quat::from_rotation_z(-0.15), 1.1, face, 0.3);
    let first = body.len();
    let up = Flow::Along(Vec3::Y);
    let ear = Quat::from_rotation_y(-0.5) * Quat::from_rotation_x(0.35);
    // Full cheek pouches, ears, hands in front of the chest, thighs and flat hind feet.
    body.ellipsoid([3.9, 6.35, 1.7], [1.65, 1.4, 1.45], straight, 0.7, face, 0.6)
        .ellipsoid([1.9, 9.75, 1.8], [0.3, 0.85, 0.85], ear, 0.3, up, 0.14)
        .ellipsoid([2.25, 9.85, 1.97], [0.32, 0.62, 0.6], ear, 0.15, up, 0.03)
        .carved()
        .cone([2.3, 4.8, 2.4], 0.95, [4.7, 4.0, 1.9], 0.5, 0.4, 0.35)
        .cone([4.7, 4.0, 1.9], 0.42, [5.5, 4.1, 1.45], 0.3, 0.2, 0.08)
        .ellipsoid([-1.0, 2.4, 2.7], [2.7, 2.3, 2.0], straight, 1.0, back, 0.9)
        .cone([0.6, 0.55, 3.0], 0.6, [2.5, 0.36, 3.3], 0.36, 0.5, 0.1)
        .mirrored_z(first)
}

/// Golden above and cream below, with pale cheeks, and pink feet and ears that look bare.
fn melanin(p: Vec3, draw: &Draw) -> [f32; 2] {
    const CREAM: [f32; 2] = [0.0, 0.007];
    let golden = if draw.guard && draw.random < 0.4 { [0.1, 0.6] } else { [0.0, 0.24 + 0.22 * draw.random] };
    let side = Vec3::new(p.x, p.y, p.z.abs());
    let patchy = noise(1.1 * p);
    // The height above a plane from the rump to the throat. The colour changes gradually across it.
    let above = 0.62 * (p.y - 4.2) - 0.78 * p.x + 0.25 * (side.z - 3.0).max(-2.0) + 0.3 * patchy;
    let mut gold = smoothstep(-1.7, 0.5, above) * smoothstep(0.5, 2.6, p.y + 0.4 * patchy);
    // The face is golden above the cheeks and the muzzle.
    let face = smoothstep(5.2, 6.2, p.y - 0.25 * (p.x - 3.0)) * smoothstep(1.0, 2.4, p.x);
    gold = gold.max(face * smoothstep(5.2, 5.8, p.y));
    let cheek = to_segment(side, [5.6, 6.2, 0.8], [3.2, 6.0, 2.6]);
    gold *= smoothstep(0.9, 1.9, cheek + 0.15 * patchy);
    gold *= 1.0 - smoothstep(5.9, 6.5, p.x) * smoothstep(7.6, 7.0, p.y);
    // The back is darker than the flanks.
    let back = smoothstep(1.6, 4.2, above) * smoothstep(3.2, 1.2, p.x);
    let golden = mix(golden, [0.04, 0.65], 0.5 * back);
    // Golden hamsters have a darker stripe from the cheek to the shoulder.
    let stripe = to_segment(side, [2.0, 6.7, 2.4], [0.6, 5.2, 3.6]);
    let golden = mix(golden, [0.25, 0.9], 0.5 * smoothstep(0.8, 0.0, stripe));
    let color = mix(CREAM, golden, gold);
    let ears = smoothstep(1.05, 0.75, side.distance(Vec3::new(1.9, 9.95, 1.9)));
    mix(color, [0.09, 0.14], ears)
}
