//! A sitting brown tabby that faces +x, in the light of one large window.

use super::coat::{Coat, mix, smoothstep, to_segment};
use super::eyes::Eye;
use super::noise::noise;
use super::props;
use super::tube::{curve, tube};
use super::whiskers::Whiskers;
use crate::body::{Body, Flow};
use crate::error::Error;
use crate::scenes::Preset;
use crate::settings::{Clump, Draw, GrowSettings};
use glam::{Quat, Vec2, Vec3};
use vellus::Species;
use vellus_scene::{Camera, Scene};

pub(super) fn scene(small: bool, preset: Preset) -> Result<Scene, Error> {
    let body = body();
    let eye = body.project(HEAD + Vec3::new(12.8, 33.0, 2.35)) - Vec3::new(0.96, 0.0, 0.26);
    let nose = body.project(HEAD + Vec3::new(15.0, 31.0, 0.0)) - Vec3::new(0.1, 0.0, 0.0);
    let mirrored = |p: Vec3| Vec3::new(p.x, p.y, -p.z);
    let lips = curve(&MOUTH, |p| body.project(HEAD + p));
    let bare = [(eye, 1.32), (mirrored(eye), 1.32), (nose, 0.5)];
    let lip = |p: &Vec3| [(*p, 0.13), (mirrored(*p), 0.13)];
    let mut scene = Scene::default();
    Coat {
        body: &body,
        step: 0.35,
        soft: 0.6,
        settings: GrowSettings {
            name: "cat".to_owned(),
            count: 267_000,
            segments: 9,
            length: 1.1,
            length_variation: 0.32,
            radius: [0.0085, 0.0024],
            guard_share: 0.15,
            guard_scale: [1.6, 1.45],
            lift: [0.55, 0.2],
            spread: 0.14,
            gravity: 0.1,
            clump: Clump { strands: 20, strength: 0.5, power: 1.5 },
            stray: 0.02,
            noise: 0.055,
            ..GrowSettings::default()
        },
        fiber: preset(Species::Cat),
        melanin: &melanin,
        patch: 4.0,
        bare: bare.into_iter().chain(lips.iter().flat_map(lip)).collect(),
        skin: 0.5,
    }
    .add(&mut scene, small)?;

    let eye = Eye {
        center: eye,
        radius: 1.3,
        gaze: Vec3::new(1.0, 0.06, 0.32),
        opening: [1.15, 0.66, 0.66],
        tilt: 0.22,
        iris: [0.17, 0.16, 0.045],
        iris_radius: 1.15,
        pupil: [0.38, 0.66],
        lid: [0.022, 0.015, 0.011],
    };
    eye.add(&mut scene);
    // It looks toward the window, and both eyes look the same way.
    Eye { gaze: Vec3::new(1.0, 0.06, 0.02), ..eye.mirrored() }.add(&mut scene);
    let skin = props::glossy("mouth", [0.03, 0.018, 0.016], 0.5);
    for side in [lips.clone(), lips.into_iter().map(mirrored).collect()] {
        tube(&mut scene, &side, 0.09, skin.clone());
    }
    Whiskers {
        pad: HEAD + Vec3::new(13.0, 30.35, 2.0),
        spacing: [0.42, 0.5],
        count: [3, 4],
        direction: Vec3::new(0.15, -0.02, 1.0),
        length: 7.0,
        radius: 0.016,
        melanin: [0.0, 0.003],
    }
    .add(&mut scene, |p| body.project(p));
    let pink = props::glossy("nose", [0.34, 0.16, 0.13], 0.45);
    props::ellipsoid(&mut scene, nose, Vec3::new(0.33, 0.32, 0.58), Quat::IDENTITY, pink);
    let target = Vec3::new(0.5, 19.0, 1.5);
    let view = Vec3::new(0.87, 0.12, 0.48).normalize();
    props::strip(
        &mut scene,
        &props::room(90.0, 30.0),
        (view - view.y * Vec3::Y).normalize(),
        600.0,
        [0.42, 0.36, 0.31],
    );
    scene.lights.push(props::window(Vec3::new(60.0, 85.0, 75.0), target, Vec2::splat(70.0), [26.0, 24.3, 21.5]));
    scene.lights.push(props::dome([0.26, 0.29, 0.34], None));
    let eye = target + 150.0 * view;
    scene.camera = Some(Camera::look_at(eye, target, Vec3::Y, 17f32.to_radians(), 1.5));
    Ok(scene)
}

/// The position of the head relative to the coordinates of its parts.
const HEAD: Vec3 = Vec3::new(0.2, -1.8, 0.0);

/// The right half of the mouth, relative to [`HEAD`], from under the nose to its corner.
const MOUTH: [[f32; 3]; 6] =
    [[14.0, 30.6, 0.0], [13.7, 29.9, 0.0], [13.3, 29.5, 0.5], [12.7, 29.3, 1.2], [12.0, 29.4, 1.9], [11.2, 29.8, 2.4]];

pub(super) fn body() -> Body {
    let back = Flow::Along(Vec3::new(-0.7, -1.0, 0.0));
    let face = Flow::AwayFrom(HEAD + Vec3::new(14.5, 30.8, 0.0));
    let chest = Flow::Along(Vec3::new(0.35, -1.0, 0.0));
    let straight = Quat::IDENTITY;
    let head = |x: f32, y: f32, z: f32| (HEAD + Vec3::new(x, y, z)).to_array();
    let mut body = Body::default()
        .ellipsoid([-5.5, 8.4, 0.0], [8.6, 8.4, 7.6], straight, 2.0, back, 2.2)
        .cone([-4.5, 10.5, 0.0], 7.6, [2.0, 19.5, 0.0], 5.4, 2.5, 2.2)
        .flowing(back)
        .ellipsoid([3.8, 17.0, 0.0], [4.6, 7.6, 4.9], straight, 3.0, chest, 3.2)
        .cone([3.4, 21.5, 0.0], 4.7, [6.2, 27.0, 0.0], 4.3, 2.5, 2.0)
        .flowing(back)
        .ellipsoid(head(7.6, 32.4, 0.0), [5.5, 4.9, 5.6], straight, 1.6, face, 0.7)
        .ellipsoid(head(11.5, 31.7, 0.0), [1.9, 1.5, 1.5], straight, 1.6, face, 0.35)
        .ellipsoid(head(11.4, 28.9, 0.0), [1.6, 1.2, 1.5], straight, 0.9, face, 0.5);
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
    body.ellipsoid([-3.2, 7.0, 5.2], [7.4, 6.6, 3.9], straight, 2.5, down, 1.8)
        // Forelegs, paws and their toes.
        .cone([4.4, 18.5, 2.8], 2.8, [7.4, 3.0, 2.7], 1.6, 2.0, 0.8)
        .ellipsoid([8.7, 1.35, 2.8], [2.4, 1.35, 1.75], straight, 1.0, Flow::Along(Vec3::X), 0.4)
        .ellipsoid([10.3, 0.95, 1.8], [1.0, 0.9, 0.62], straight, 0.3, Flow::Along(Vec3::X), 0.25)
        .ellipsoid([10.6, 0.95, 2.8], [1.0, 0.9, 0.62], straight, 0.3, Flow::Along(Vec3::X), 0.25)
        .ellipsoid([10.3, 0.95, 3.8], [1.0, 0.9, 0.62], straight, 0.3, Flow::Along(Vec3::X), 0.25)
        // Hind feet.
        .cone([-1.0, 1.7, 6.6], 1.7, [5.6, 1.35, 6.9], 1.35, 1.5, 0.45)
        .ellipsoid([6.5, 0.95, 6.2], [1.0, 0.9, 0.62], straight, 0.3, Flow::Along(Vec3::X), 0.25)
        .ellipsoid([6.7, 0.95, 7.3], [1.0, 0.9, 0.62], straight, 0.3, Flow::Along(Vec3::X), 0.25)
        // Cheek, whisker pad and ear.
        .ellipsoid(head(8.8, 30.3, 3.3), [2.9, 2.5, 2.9], straight, 1.8, face, 1.5)
        .ellipsoid(head(12.1, 30.25, 1.2), [1.5, 1.2, 1.4], straight, 0.7, face, 0.35)
        .ellipsoid(head(6.4, 36.2, 3.7), [0.8, 2.8, 2.5], ear, 1.0, up, 0.4)
        .cone(head(6.3, 37.2, 4.3), 1.2, head(6.1, 39.4, 5.2), 0.35, 1.4, 0.35)
        .ellipsoid(head(7.3, 36.6, 3.95), [0.85, 2.3, 1.6], ear, 0.5, up, 0.04)
        .carved()
        // Long hair from the front of the ear covers its hollow.
        .ellipsoid(head(7.5, 35.4, 2.6), [0.5, 0.9, 0.4], straight, 0.5, Flow::Along(Vec3::new(0.2, 1.0, 0.5)), 2.0)
        .mirrored_z(first)
}

/// Agouti brown with dark stripes: rings on legs and tail, lines down the flanks, an M on the forehead. It is pale
/// around the mouth.
fn melanin(p: Vec3, draw: &Draw) -> [f32; 2] {
    const DARK: [f32; 2] = [2.6, 0.4];
    const PALE: [f32; 2] = [0.004, 0.015];
    let side = Vec3::new(p.x, p.y, p.z.abs());
    // The undercoat is pale. Most guard hairs are darker.
    let mut color = if draw.guard && draw.random < 0.6 { [0.9, 0.4] } else { [0.06, 0.11 + 0.14 * draw.random] };
    let wobble = 0.9 * (0.5 * p.y + 0.9 * side.z).sin() + 0.6 * (0.7 * p.x + 0.5 * p.z).sin();
    // Stripes are broken in places, and the coat between them is uneven.
    // A few hairs in stripes have the colour of the coat between them.
    let dyed = if draw.random > 0.8 { 0.15 } else { 0.85 };
    let patchy = noise(0.33 * p + Vec3::splat(7.0)) + 0.5 * noise(0.8 * p);
    let stripe = |phase: f32, width: f32| {
        let width = width * (1.0 + 0.45 * patchy);
        smoothstep(width + 0.1, width - 0.45, 1.0 - phase.cos())
    };
    color = mix(color, [0.04, 0.1], 0.45 * (0.5 + patchy).clamp(0.0, 1.0));
    let at = p - HEAD;
    if at.y > 27.5 || at.x > 9.5 && at.y > 26.0 {
        // The head.
        let (p, side) = (at, side - HEAD);
        let forehead = smoothstep(34.6, 35.4, p.y) * smoothstep(38.4, 37.0, p.y) * smoothstep(2.9, 2.3, side.z);
        let lines = stripe(3.0 * p.z, 0.7) * forehead;
        let cheek =
            stripe(2.4 * (p.y - 0.25 * p.x) + 0.6, 0.6) * smoothstep(3.6, 4.2, side.z) * smoothstep(34.5, 33.5, p.y);
        color = mix(color, DARK, dyed * lines.max(cheek));
        color = mix(color, PALE, smoothstep(2.7, 1.8, to_segment(side, [13.5, 29.8, 0.0], [12.0, 28.8, 2.4])));
        // Pale spots above and below the eyes, and a dark line from the outer corner.
        let eye = side - Vec3::new(11.9, 33.0, 2.5);
        color = mix(color, PALE, 0.6 * smoothstep(2.1, 1.3, eye.length()) * smoothstep(0.4, 1.0, eye.y.abs()));
        let corner = to_segment(side, [11.7, 33.1, 3.3], [9.6, 32.3, 5.0]);
        color = mix(color, DARK, dyed * smoothstep(0.45, 0.15, corner));
        return mix(color, [0.35, 0.15], smoothstep(38.0, 38.8, p.y));
    }
    let tail = p.y < 6.5 && (p.z > 9.3 || p.x < -12.8);
    let front = p.x > 3.0 && p.y < 15.0 && side.z < 6.0;
    let dark = if tail {
        stripe(1.5 * (p.x + 0.6 * p.z), 0.8)
    } else if front {
        0.7 * stripe(1.9 * p.y + 0.8 * (p.z + 0.5 * p.x).sin(), 0.5) * smoothstep(2.6, 3.6, p.y)
    } else {
        // Across the back, bent to follow the haunches.
        let spine = 0.56 * p.x + 0.83 * p.y;
        let across = spine + 0.35 * side.z + wobble;
        let chest = smoothstep(3.5, 6.5, p.x) * smoothstep(4.5, 2.0, side.z);
        stripe(1.75 * across, 0.55) * (1.0 - chest)
    };
    let paws = smoothstep(3.2, 2.0, p.y) * f32::from(!tail);
    color = mix(color, PALE, 0.6 * paws);
    color =
        mix(color, [0.015, 0.05], 0.85 * smoothstep(4.5, 7.5, p.x) * smoothstep(4.0, 2.0, side.z) * f32::from(!front));
    mix(color, DARK, dyed * dark * (1.0 - paws))
}
