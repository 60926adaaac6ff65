//! A standing raccoon that faces +x, with a black mask and a ringed tail.

use super::coat::{Coat, mix, smoothstep, to_segment};
use super::eyes::Eye;
use super::noise::noise;
use super::toes::Toes;
use super::tube::{curve, tube};
use super::whiskers::Whiskers;
use super::{grass, props, sky};
use crate::body::{Body, Flow};
use crate::error::Error;
use crate::scenes::Preset;
use crate::settings::{Clump, Draw, GrowSettings};
use glam::{Quat, Vec3};
use vellus::Species;
use vellus_scene::{Camera, Scene};

/// Points and radii of the tail, from the rump to its tip.
const TAIL: [([f32; 3], f32); 6] = [
    ([-17.0, 21.0, 0.0], 2.6),
    ([-24.0, 20.5, 2.0], 3.0),
    ([-31.0, 17.5, 6.0], 3.2),
    ([-37.0, 13.5, 11.0], 3.1),
    ([-41.5, 9.8, 17.0], 2.7),
    ([-44.0, 7.5, 23.0], 1.7),
];

pub(super) fn scene(small: bool, preset: Preset) -> Result<Scene, Error> {
    let body = body();
    let eye = body.project(Vec3::new(29.0, 27.6, 3.1)) - Vec3::new(0.3, 0.0, 0.12);
    let nose = Vec3::new(34.5, 24.4, 0.0);
    let mirrored = |p: Vec3| Vec3::new(p.x, p.y, -p.z);
    let lips = curve(&MOUTH, |p| body.project(p));
    let bare = [(eye, 0.86), (mirrored(eye), 0.86), (nose, 1.1)];
    let lip = |p: &Vec3| [(*p, 0.14), (mirrored(*p), 0.14)];
    let mut scene = Scene::default();
    Coat {
        body: &body,
        step: 0.4,
        soft: 0.9,
        settings: GrowSettings {
            name: "raccoon".to_owned(),
            count: 260_000,
            segments: 22,
            length: 1.0,
            length_variation: 0.25,
            radius: [0.006, 0.0015],
            guard_share: 0.2,
            guard_scale: [1.7, 1.5],
            lift: [0.75, 0.3],
            spread: 0.16,
            gravity: 0.12,
            clump: Clump { strands: 45, strength: 0.75, power: 1.3 },
            stray: 0.03,
            noise: 0.07,
            ..GrowSettings::default()
        },
        fiber: preset(Species::Raccoon),
        melanin: &melanin,
        patch: 5.0,
        bare: bare.into_iter().chain(lips.iter().flat_map(lip)).collect(),
        skin: 0.5,
    }
    .add(&mut scene, small)?;

    let eye = Eye {
        center: eye,
        radius: 0.82,
        gaze: Vec3::new(1.0, 0.08, 0.85),
        opening: [1.1, 0.55, 0.65],
        tilt: 0.18,
        iris: [0.03, 0.014, 0.007],
        iris_radius: 1.0,
        pupil: [0.5, 0.5],
        lid: [0.012; 3],
    };
    eye.add(&mut scene);
    eye.mirrored().add(&mut scene);
    let skin = props::glossy("mouth", [0.012, 0.01, 0.01], 0.5);
    for side in [lips.clone(), lips.into_iter().map(mirrored).collect()] {
        tube(&mut scene, &side, 0.11, skin.clone());
    }
    Whiskers {
        pad: Vec3::new(32.2, 23.8, 1.4),
        spacing: [0.4, 0.55],
        count: [3, 4],
        direction: Vec3::new(0.05, -0.1, 1.0),
        length: 7.0,
        radius: 0.016,
        melanin: [0.0, 0.003],
    }
    .add(&mut scene, |p| body.project(p));
    let hand = props::glossy("toe", [0.02, 0.017, 0.016], 0.5);
    for (tip, length) in [(Vec3::new(16.6, 0.5, 5.35), 1.35), (Vec3::new(-10.4, 0.5, 6.7), 1.35)] {
        Toes { tip, count: 5, radii: Vec3::new(length, 0.36, 0.3), spacing: 1.05, fan: 0.17 }.add(&mut scene, &hand);
    }
    let wet = props::glossy("nose", [0.012; 3], 0.42);
    props::ellipsoid(&mut scene, nose, Vec3::new(0.75, 0.7, 0.95), Quat::IDENTITY, wet);
    props::ground(&mut scene, 20_000.0, [0.17, 0.18, 0.09]);
    grass::grass(&mut scene, &body, small);
    sky::sky(&mut scene, Vec3::new(0.75, 0.8, 0.35));
    let target = Vec3::new(-3.5, 15.5, 3.0);
    let eye = target + 150.0 * Vec3::new(0.76, 0.1, 0.65).normalize();
    let camera = Camera::look_at(eye, target, Vec3::Y, 20.5f32.to_radians(), 1.5);
    // The head is in focus, and the horizon is soft.
    let head = Vec3::new(28.0, 26.0, 3.0);
    let focus_distance = (head - eye).dot((target - eye).normalize());
    scene.camera = Some(Camera { lens_radius: 0.7, focus_distance, ..camera });
    Ok(scene)
}

/// The right half of the mouth, from under the nose to its corner.
const MOUTH: [[f32; 3]; 5] =
    [[34.2, 23.4, 0.0], [33.4, 22.9, 0.35], [32.2, 22.8, 1.0], [30.6, 22.9, 1.8], [29.0, 23.2, 2.5]];

pub(super) fn body() -> Body {
    let back = Flow::Along(Vec3::new(-1.0, -0.35, 0.0));
    let face = Flow::AwayFrom(Vec3::new(35.0, 24.5, 0.0));
    let straight = Quat::IDENTITY;
    let mut body = Body::default()
        .ellipsoid([-9.0, 18.5, 0.0], [11.5, 10.0, 9.0], straight, 3.0, back, 3.0)
        .ellipsoid([0.0, 18.0, 0.0], [15.0, 9.0, 8.4], straight, 4.0, back, 3.0)
        .ellipsoid([11.0, 17.5, 0.0], [8.5, 8.0, 7.2], straight, 4.0, back, 2.6)
        .cone([13.0, 20.0, 0.0], 6.4, [21.0, 25.0, 0.0], 5.2, 4.0, 2.2)
        .flowing(back)
        .ellipsoid([24.0, 26.8, 0.0], [5.8, 5.4, 6.3], straight, 2.5, face, 1.1)
        .cone([27.0, 25.6, 0.0], 3.2, [33.4, 24.0, 0.0], 1.35, 2.0, 0.35)
        .flowing(face);
    for tail in TAIL.windows(2) {
        body = body.cone(tail[0].0, tail[0].1, tail[1].0, tail[1].1, 1.2, 2.6);
    }
    let first = body.len();
    body.ellipsoid([23.4, 24.8, 4.2], [3.6, 3.4, 3.4], straight, 2.0, face, 1.7)
        .ellipsoid([22.2, 32.2, 4.6], [0.9, 2.7, 2.1], Quat::from_rotation_x(0.35), 0.8, Flow::Along(Vec3::Y), 0.6)
        .ellipsoid([23.3, 32.3, 4.7], [0.8, 1.9, 1.35], Quat::from_rotation_x(0.35), 0.5, Flow::Along(Vec3::Y), 0.04)
        .carved()
        .cone([12.0, 15.0, 4.8], 3.4, [13.2, 3.2, 5.0], 1.9, 2.5, 1.3)
        .cone([13.2, 2.0, 5.0], 1.7, [15.8, 1.15, 5.3], 1.05, 1.0, 0.45)
        .ellipsoid([-12.0, 14.0, 5.6], [6.4, 8.0, 4.0], straight, 3.0, Flow::Along(Vec3::new(-0.5, -1.0, 0.0)), 2.4)
        .cone([-12.5, 9.0, 6.2], 3.2, [-15.5, 3.2, 6.2], 2.0, 2.0, 1.2)
        .cone([-15.5, 1.9, 6.2], 1.7, [-11.2, 1.1, 6.6], 1.05, 1.0, 0.45)
        .mirrored_z(first)
}

/// Grey-brown with paler flanks, a black mask between white bands, and a tail with seven rings.
fn melanin(p: Vec3, draw: &Draw) -> [f32; 2] {
    const WHITE: [f32; 2] = [0.004, 0.006];
    const BLACK: [f32; 2] = [8.0, 0.0];
    const GREY: [f32; 2] = [0.3, 0.035];
    let salt = draw.random;
    let mut color = mix(GREY, [0.1, 0.03], smoothstep(19.0, 9.0, p.y));
    // Real guard hairs are banded. Here some are dark and some pale.
    if draw.guard {
        color = if salt < 0.55 { [4.0, 0.0] } else { [0.03, 0.02] };
    }
    // The coat is uneven, and dark along the back.
    color = mix(color, [0.9, 0.05], 0.3 * (noise(0.35 * p) + 0.3).clamp(0.0, 1.0));
    color = mix(color, [1.6, 0.02], 0.4 * smoothstep(23.0, 28.0, p.y) * f32::from(p.x < 16.0));
    let side = Vec3::new(p.x, p.y, p.z.abs());
    let feet = smoothstep(6.5, 3.0, p.y) * f32::from(p.x > -20.0);
    color = mix(color, [3.5, 0.2], feet);

    let (tail, s) = along_tail(p);
    if tail < 2.5 && s > 0.06 {
        let ring = (s * 6.5 + 0.02 * (salt - 0.5)).fract();
        let dark = smoothstep(0.42, 0.52, ring) * smoothstep(1.0, 0.93, ring);
        color = mix([0.09, 0.06], BLACK, dark.max(smoothstep(0.9, 0.94, s)));
    }
    if p.x > 18.0 && p.y > 17.5 && to_segment(side, [21.0, 26.5, 0.0], [33.0, 25.0, 0.0]) < 9.5 {
        let head = smoothstep(18.0, 21.0, p.x);
        let mut face = mix(GREY, color, 0.4);
        let ears = smoothstep(31.0, 32.0, p.y);
        face = mix(face, [2.0, 0.1], ears);
        face = mix(face, WHITE, ears * smoothstep(33.6, 34.1, p.y + 0.3 * side.z - 1.3));
        let brow = to_segment(side, [29.2, 29.9, 1.7], [24.5, 28.6, 7.0]);
        face = mix(face, WHITE, smoothstep(1.35, 0.85, brow));
        let muzzle = smoothstep(28.6, 29.6, p.x + 0.25 * (25.5 - p.y)) * smoothstep(27.3, 26.4, p.y);
        face = mix(face, WHITE, muzzle);
        let cheek = to_segment(side, [28.0, 23.2, 3.4], [23.0, 21.6, 7.0]);
        face = mix(face, WHITE, smoothstep(1.9, 1.2, cheek));
        // The mask is widest around the eye, and narrower down the cheek.
        let mask = to_segment(side, [29.6, 27.3, 2.2], [22.8, 24.2, 8.0]) + 0.16 * (29.0 - p.x).max(0.0);
        face = mix(face, BLACK, smoothstep(2.15, 1.75, mask));
        let blaze = to_segment(side, [34.0, 25.4, 0.0], [28.5, 31.0, 0.0]);
        face = mix(face, [4.0, 0.2], smoothstep(0.95, 0.6, blaze));
        color = mix(color, face, head);
    }
    color
}

/// Distance from the surface of the tail, and the position along it, from 0 to 1.
fn along_tail(p: Vec3) -> (f32, f32) {
    let (mut best, mut s) = (f32::INFINITY, 0.0);
    for (i, pair) in TAIL.windows(2).enumerate() {
        let (a, b) = (Vec3::from(pair[0].0), Vec3::from(pair[1].0));
        let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        let distance = p.distance(a.lerp(b, t)) - pair[0].1;
        if distance < best {
            (best, s) = (distance, (i as f32 + t) / (TAIL.len() - 1) as f32);
        }
    }
    (best, s)
}
