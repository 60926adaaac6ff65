//! A golden hamster that faces +x, in a studio with a curved backdrop from the floor to the ceiling.

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
    let body = body();
    let eye = body.project(Vec3::new(5.2, 6.5, 2.3)) + Vec3::new(0.06, 0.02, 0.06);
    let nose = body.project(Vec3::new(8.0, 5.1, 0.0)) - Vec3::new(0.1, 0.0, 0.0);
    let mirrored = |p: Vec3| Vec3::new(p.x, p.y, -p.z);
    let lips = curve(&MOUTH, |p| body.project(p));
    let bare = [(eye, 0.64), (mirrored(eye), 0.64), (nose, 0.32)];
    let lip = |p: &Vec3| [(*p, 0.07), (mirrored(*p), 0.07)];
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
            guard_scale: [1.25, 1.3],
            lift: [0.8, 0.35],
            spread: 0.15,
            gravity: 0.1,
            clump: Clump { strands: 60, strength: 0.5, power: 1.5 },
            noise: 0.05,
            ..GrowSettings::default()
        },
        // The paper uses the fibre of a mouse for the hamster.
        fiber: preset(Species::Mouse),
        melanin: &melanin,
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
        tube(&mut scene, &side, 0.045, skin.clone());
    }
    Whiskers {
        pad: Vec3::new(7.2, 4.75, 0.8),
        spacing: [0.2, 0.24],
        count: [4, 4],
        direction: Vec3::new(0.1, 0.0, 1.0),
        length: 3.0,
        radius: 0.009,
        melanin: [0.3, 0.3],
    }
    .add(&mut scene, |p| body.project(p));
    let paw = props::glossy("toe", [0.62, 0.36, 0.31], 0.5);
    for (tip, length) in [(Vec3::new(5.75, 0.17, 2.0), 0.34), (Vec3::new(1.55, 0.17, 3.5), 0.4)] {
        Toes { tip, count: 4, radii: Vec3::new(length, 0.13, 0.11), spacing: 1.1, fan: 0.22 }.add(&mut scene, &paw);
    }
    let pink = props::glossy("nose", [0.55, 0.25, 0.22], 0.4);
    props::ellipsoid(&mut scene, nose, Vec3::new(0.25, 0.24, 0.34), Quat::IDENTITY, pink);

    let forward = Vec3::new(0.7, 0.0, 0.72).normalize();
    props::strip(&mut scene, &capsule(), forward, 150.0, [0.78, 0.77, 0.75]);
    let center = Vec3::new(1.0, 4.0, 0.0);
    for (across, along, radiance) in [(-22.0, 12.0, 16.0), (0.0, 48.0, 17.0), (24.0, 4.0, 15.0)] {
        let from = along * forward + across * forward.cross(Vec3::Y) + 44.0 * Vec3::Y;
        let color = [radiance, 0.97 * radiance, 0.92 * radiance];
        scene.lights.push(props::window(from, center, Vec2::new(14.0, 14.0), color));
    }
    let target = Vec3::new(0.9, 4.7, 0.0);
    let eye = target + 62.0 * (forward + 0.2 * Vec3::Y).normalize();
    scene.camera = Some(Camera::look_at(eye, target, Vec3::Y, 14f32.to_radians(), 1.5));
    Ok(scene)
}

/// The right half of the mouth, from under the nose to its corner.
const MOUTH: [[f32; 3]; 5] = [[7.6, 4.7, 0.0], [7.4, 4.3, 0.0], [7.2, 4.12, 0.22], [6.8, 4.05, 0.5], [6.3, 4.1, 0.75]];

/// The profile of the backdrop, from the front of the ceiling over the back to the front of the floor.
fn capsule() -> Vec<Vec2> {
    const RADIUS: f32 = 25.0;
    let turn = |i: i32| {
        let angle = PI * i as f32 / 32.0;
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
    let back = Flow::Along(Vec3::new(-1.0, -0.4, 0.0));
    let face = Flow::AwayFrom(Vec3::new(8.0, 4.9, 0.0));
    let straight = Quat::IDENTITY;
    let body = Body::default()
        .ellipsoid([-2.0, 3.7, 0.0], [4.2, 3.7, 4.3], straight, 1.0, back, 1.1)
        .ellipsoid([0.6, 3.7, 0.0], [4.3, 3.7, 4.0], straight, 2.0, back, 1.15)
        .ellipsoid([3.6, 5.3, 0.0], [3.1, 2.8, 2.9], straight, 1.6, face, 0.75)
        .ellipsoid([6.1, 4.8, 0.0], [1.55, 1.15, 1.25], straight, 1.2, face, 0.3);
    let first = body.len();
    let up = Flow::Along(Vec3::Y);
    body.ellipsoid([4.4, 4.0, 1.9], [2.1, 1.8, 1.8], straight, 1.0, face, 0.6)
        .ellipsoid([2.3, 8.3, 2.2], [0.35, 1.25, 1.05], Quat::from_rotation_x(0.4), 0.4, up, 0.18)
        .ellipsoid([2.75, 8.4, 2.3], [0.4, 0.95, 0.75], Quat::from_rotation_x(0.4), 0.2, up, 0.12)
        .carved()
        .cone([3.6, 1.7, 1.7], 0.9, [4.9, 0.55, 1.9], 0.42, 0.5, 0.2)
        .cone([4.9, 0.42, 1.9], 0.4, [5.7, 0.3, 2.0], 0.26, 0.2, 0.08)
        .ellipsoid([-2.0, 2.6, 2.6], [2.6, 2.5, 1.9], straight, 1.2, back, 0.9)
        .cone([-0.6, 0.6, 3.2], 0.6, [1.4, 0.35, 3.5], 0.3, 0.4, 0.1)
        .mirrored_z(first)
}

/// Golden above and cream below, with pale cheeks, and pink feet and ears that look bare.
fn melanin(p: Vec3, draw: &Draw) -> [f32; 2] {
    const CREAM: [f32; 2] = [0.0, 0.012];
    let golden = if draw.guard && draw.random < 0.4 { [0.2, 0.6] } else { [0.0, 0.17 + 0.12 * draw.random] };
    let side = Vec3::new(p.x, p.y, p.z.abs());
    // The border between flank and belly rises toward the chest.
    let border = 2.9 + 0.15 * (p.x + 2.0).max(0.0) + 0.25 * (1.7 * p.x).sin() + 0.35 * noise(1.1 * p);
    let mut color = mix(CREAM, golden, smoothstep(border - 0.7, border + 0.8, p.y));
    // The back is darker than the flanks.
    let back = smoothstep(5.6, 8.2, p.y + 0.5 * noise(0.9 * p)) * f32::from(p.x < 3.5);
    color = mix(color, [0.08, 0.6], 0.5 * back);
    let cheek = to_segment(side, [5.6, 4.2, 1.4], [3.2, 3.9, 3.4]);
    color = mix(color, CREAM, smoothstep(1.5, 0.9, cheek));
    color = mix(color, CREAM, smoothstep(6.1, 6.9, p.x) * smoothstep(5.6, 5.0, p.y));
    // Golden hamsters have a darker stripe from the cheek to the shoulder.
    let stripe = to_segment(side, [3.7, 5.5, 2.6], [1.3, 3.9, 4.0]);
    color = mix(color, [0.25, 0.9], 0.7 * smoothstep(0.75, 0.0, stripe));
    let ears = smoothstep(8.2, 8.7, p.y);
    mix(color, [0.3, 0.3], ears)
}
