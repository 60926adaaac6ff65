//! A sitting brown tabby that faces +x, in the light of one large window.

use super::coat::{Coat, mix, smoothstep, to_segment};
use super::props;
use crate::body::{Body, Flow};
use crate::error::Error;
use crate::scenes::Preset;
use crate::settings::{Clump, Draw, GrowSettings};
use glam::{Mat3, Quat, Vec2, Vec3};
use std::f32::consts::FRAC_PI_2;
use vellus::Species;
use vellus_scene::{Camera, Light, Scene};

pub(super) fn scene(small: bool, preset: Preset) -> Result<Scene, Error> {
    let body = body();
    let eye = body.project(Vec3::new(12.5, 33.0, 2.5)) - Vec3::new(0.62, 0.0, 0.2);
    let nose = body.project(Vec3::new(15.0, 31.0, 0.0)) - Vec3::new(0.1, 0.0, 0.0);
    let mirrored = |p: Vec3| Vec3::new(p.x, p.y, -p.z);
    let mut scene = Scene::default();
    Coat {
        body: &body,
        step: 0.35,
        soft: 0.6,
        settings: GrowSettings {
            name: "cat".to_owned(),
            count: 267_000,
            segments: 9,
            length: 1.0,
            length_variation: 0.25,
            radius: [0.005, 0.0012],
            guard_share: 0.2,
            guard_scale: [1.3, 1.3],
            lift: [0.55, 0.2],
            spread: 0.14,
            gravity: 0.1,
            clump: Clump { strands: 20, strength: 0.5, power: 1.5 },
            noise: 0.04,
            ..GrowSettings::default()
        },
        fiber: preset(Species::Cat),
        melanin: &melanin,
        bare: vec![(eye, 1.12), (mirrored(eye), 1.12), (nose, 0.5)],
        skin: 0.5,
    }
    .add(&mut scene, small)?;

    for eye in [eye, mirrored(eye)] {
        let iris = props::glossy("iris", [0.42, 0.4, 0.08], 0.05);
        props::ellipsoid(&mut scene, eye, Vec3::splat(1.1), Quat::IDENTITY, iris);
        // The pupil protrudes from the iris a little, in the direction of view.
        let gaze = Vec3::new(1.0, 0.05, 0.22 * eye.z.signum()).normalize();
        let turn = Quat::from_rotation_arc(Vec3::X, gaze);
        let pupil = props::glossy("pupil", [0.004; 3], 0.03);
        props::ellipsoid(&mut scene, eye + 0.62 * gaze, Vec3::new(0.53, 0.75, 0.3), turn, pupil);
    }
    let pink = props::glossy("nose", [0.4, 0.16, 0.13], 0.4);
    props::ellipsoid(&mut scene, nose, Vec3::new(0.35, 0.38, 0.6), Quat::IDENTITY, pink);
    let target = Vec3::new(0.0, 19.5, 1.5);
    let view = Vec3::new(0.8, 0.14, 0.55).normalize();
    props::strip(&mut scene, &room(), (view - view.y * Vec3::Y).normalize(), 600.0, [0.42, 0.36, 0.31]);
    scene.lights.push(props::window(Vec3::new(60.0, 85.0, 75.0), target, Vec2::splat(70.0), [26.0, 24.3, 21.5]));
    scene.lights.push(Light::Dome {
        radiance: [0.4, 0.45, 0.52],
        texture: None,
        rotation: Mat3::IDENTITY,
        ground: None,
    });
    let eye = target + 150.0 * view;
    scene.camera = Some(Camera::look_at(eye, target, Vec3::Y, 19.5f32.to_radians(), 1.5));
    Ok(scene)
}

/// The profile of a wall and the floor in front of it, from the top, with a rounded corner.
fn room() -> Vec<Vec2> {
    const RADIUS: f32 = 30.0;
    let turn = |i: i32| {
        let (sin, cos) = (FRAC_PI_2 * i as f32 / 16.0).sin_cos();
        Vec2::new(-90.0 - RADIUS * cos, RADIUS * (1.0 - sin))
    };
    let mut profile = vec![Vec2::new(-90.0 - RADIUS, 300.0)];
    profile.extend((0..=16).map(turn));
    profile.push(Vec2::new(400.0, 0.0));
    profile
}

pub(super) fn body() -> Body {
    let back = Flow::Along(Vec3::new(-0.7, -1.0, 0.0));
    let face = Flow::AwayFrom(Vec3::new(14.5, 30.8, 0.0));
    let straight = Quat::IDENTITY;
    let mut body = Body::default()
        .cone([-6.0, 8.5, 0.0], 8.2, [2.5, 20.0, 0.0], 5.6, 2.0, 1.9)
        .flowing(back)
        .ellipsoid([4.0, 18.0, 0.0], [5.0, 8.0, 5.4], straight, 3.0, Flow::Along(Vec3::new(0.2, -1.0, 0.0)), 2.0)
        .cone([3.5, 23.0, 0.0], 4.6, [6.0, 29.0, 0.0], 4.0, 2.5, 1.5)
        .flowing(back)
        .ellipsoid([7.6, 32.4, 0.0], [5.6, 5.1, 5.7], straight, 1.6, face, 0.8)
        .ellipsoid([11.6, 31.6, 0.0], [1.9, 1.5, 1.5], straight, 1.4, face, 0.4)
        .ellipsoid([11.4, 29.0, 0.0], [1.6, 1.2, 1.4], straight, 0.8, face, 0.5);
    // The tail goes around the right hind leg to the front.
    let tail = [[-13.0, 4.5, 2.0], [-13.0, 2.2, 7.5], [-7.0, 1.8, 12.0], [0.0, 1.7, 13.2], [6.5, 1.7, 12.2]];
    for (i, pair) in tail.windows(2).enumerate() {
        let radius = |i: usize| 2.0 - 0.22 * i as f32;
        body = body.cone(pair[0], radius(i), pair[1], radius(i + 1), 0.8, 1.3);
    }
    let first = body.len();
    let down = Flow::Along(Vec3::new(-0.3, -1.0, 0.0));
    let up = Flow::Along(Vec3::Y);
    let ear = Quat::from_rotation_x(0.28);
    body.ellipsoid([-3.0, 6.5, 5.2], [8.0, 6.4, 3.8], straight, 2.5, down, 1.6)
        .cone([4.5, 20.0, 3.0], 3.0, [8.3, 3.0, 3.2], 1.8, 2.0, 0.9)
        .ellipsoid([9.6, 1.5, 3.2], [2.7, 1.5, 1.9], straight, 1.0, Flow::Along(Vec3::X), 0.5)
        .cone([-1.0, 1.7, 6.6], 1.8, [6.4, 1.4, 6.9], 1.4, 1.5, 0.5)
        .ellipsoid([9.2, 30.4, 3.2], [2.7, 2.3, 2.7], straight, 1.6, face, 1.2)
        .ellipsoid([12.2, 30.3, 1.1], [1.5, 1.15, 1.25], straight, 0.7, face, 0.35)
        .ellipsoid([6.4, 36.4, 3.7], [0.8, 2.7, 2.5], ear, 1.0, up, 0.4)
        .cone([6.3, 37.4, 4.3], 1.2, [6.1, 39.5, 5.2], 0.35, 1.4, 0.35)
        .ellipsoid([7.3, 36.8, 3.95], [0.85, 2.3, 1.6], ear, 0.5, up, 0.3)
        .carved()
        .mirrored_z(first)
}

/// Agouti brown with dark stripes: rings on legs and tail, lines down the flanks, an M on the forehead. It is pale
/// around the mouth.
fn melanin(p: Vec3, draw: &Draw) -> [f32; 2] {
    const DARK: [f32; 2] = [5.0, 0.5];
    const PALE: [f32; 2] = [0.004, 0.015];
    let side = Vec3::new(p.x, p.y, p.z.abs());
    let mut color = if draw.guard && draw.random < 0.5 { [1.0, 0.6] } else { [0.06, 0.28 + 0.14 * draw.random] };
    let wobble = 0.9 * (0.5 * p.y + 0.9 * side.z).sin() + 0.6 * (0.7 * p.x + 0.5 * p.z).sin();
    let stripe = |phase: f32, width: f32| smoothstep(width, width - 0.25, 1.0 - phase.cos());
    if p.y > 27.5 || p.x > 9.5 && p.y > 26.0 {
        // The head.
        let forehead = smoothstep(34.6, 35.4, p.y) * smoothstep(38.4, 37.0, p.y);
        let lines = stripe(3.0 * p.z, 0.7) * forehead;
        let cheek =
            stripe(2.4 * (p.y - 0.25 * p.x) + 0.6, 0.6) * smoothstep(3.6, 4.2, side.z) * smoothstep(34.5, 33.5, p.y);
        color = mix(color, DARK, 0.95 * lines.max(cheek));
        color = mix(color, PALE, smoothstep(2.7, 1.8, to_segment(side, [13.5, 29.8, 0.0], [12.0, 28.8, 2.4])));
        color = mix(color, PALE, smoothstep(1.9, 1.5, side.distance(Vec3::new(11.9, 33.0, 2.5))));
        color = mix(color, DARK, smoothstep(1.35, 1.2, side.distance(Vec3::new(11.8, 33.0, 2.5))));
        return mix(color, [0.35, 0.15], smoothstep(38.0, 38.8, p.y));
    }
    let tail = p.y < 6.5 && (p.z > 9.3 || p.x < -12.8);
    let front = p.x > 3.0 && p.y < 15.0 && side.z < 6.0;
    let dark = if tail {
        stripe(1.5 * (p.x + 0.6 * p.z), 0.8)
    } else if front {
        stripe(2.0 * p.y + 0.6 * (p.z + 0.5 * p.x).sin(), 0.6) * smoothstep(2.6, 3.6, p.y)
    } else {
        // Across the back, bent to follow the haunches.
        let spine = 0.56 * p.x + 0.83 * p.y;
        let across = spine + 0.35 * side.z + wobble;
        let chest = smoothstep(3.5, 6.5, p.x) * smoothstep(4.5, 2.0, side.z);
        stripe(1.75 * across, 0.7) * (1.0 - chest)
    };
    let paws = smoothstep(3.2, 2.0, p.y) * f32::from(!tail);
    color = mix(color, PALE, 0.6 * paws);
    color =
        mix(color, [0.02, 0.12], 0.8 * smoothstep(4.5, 7.5, p.x) * smoothstep(4.0, 2.0, side.z) * f32::from(!front));
    mix(color, DARK, 0.92 * dark * (1.0 - paws))
}
