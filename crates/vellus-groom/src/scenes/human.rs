//! Hair with a side parting, on the head of a mannequin that faces +x.

use super::coat::smoothstep;
use super::glow::glow;
use super::hairstyle::Hairstyle;
use super::noise::noise;
use super::props;
use crate::body::{Body, Flow};
use crate::error::Error;
use crate::grow::grow;
use crate::polygonize::polygonize;
use crate::roots::Site;
use crate::scenes::Preset;
use crate::settings::{Draw, Maps};
use glam::{Quat, Vec2, Vec3};
use vellus::Species;
use vellus_scene::{Camera, Look, Parameter, Scene, Surface, Tint};

pub(super) fn scene(style: &Hairstyle, small: bool, preset: Preset) -> Result<Scene, Error> {
    let body = body();
    let mut scene = Scene::default();
    let mesh = polygonize(&body, if small { 0.6 } else { 0.32 }, "head", &|_| Vec2::ZERO);
    let settings = style.settings(small);
    // Points in the body leave it first, because its surface is then beside them. The distance is too short where
    // shoulders are blended.
    let distance = |p: Vec3| {
        let own = body.distance(p);
        let scale = if p.y < -12.0 { 1.7 } else { 1.0 };
        if own < 0.0 { scale * own } else { own.min(beside_face(p)) }
    };
    let [light, more] = style.melanin;
    let color = |_: &Site, draw: &Draw| [light[0] + more[0] * draw.random, light[1] + more[1] * draw.random, 0.0];
    let maps = Maps {
        density: &|site| smoothstep(-0.6, 1.4, hairline(site.position)),
        length: &|site| style.length(site.position),
        comb: &|site| combed(site.position),
        color: Some((Parameter::Melanin, &color)),
        distance: Some(&distance),
    };
    scene.strands.push(grow(&mesh, &settings, &maps)?);
    scene.looks.push(Look::constant("hair", preset(Species::Human)));
    scene.meshes.push(mesh);
    scene.surfaces.push(Surface {
        color: Tint { color: [0.44, 0.37, 0.32], texture: None },
        roughness: 0.5,
        ior: 1.4,
        ..Surface::diffuse("mannequin", [0.0; 3])
    });
    let [height, field] = style.framing;
    let target = Vec3::new(-1.0, height, 0.0);
    scene.lights.push(props::window(Vec3::new(45.0, 85.0, 75.0), target, Vec2::splat(44.0), [29.0, 27.8, 26.0]));
    scene.lights.push(props::window(Vec3::new(-95.0, 60.0, 10.0), target, Vec2::splat(45.0), [20.0, 20.7, 22.0]));
    let view = Vec3::new(0.68, 0.06, 0.73).normalize();
    let behind = (0.1 * Vec3::NEG_Y - view).normalize();
    glow(&mut scene, behind, 0.4, Vec3::new(0.5, 0.52, 0.56), Vec3::new(0.16, 0.17, 0.2));
    let eye = target + 190.0 * view;
    scene.camera = Some(Camera::look_at(eye, target, Vec3::Y, field.to_radians(), 1.5));
    Ok(scene)
}

/// Height above the hairline, which rises from the nape over the ears to the forehead and is uneven.
pub(super) fn hairline(p: Vec3) -> f32 {
    (p.y + 5.5 - 0.8 * (p.x + 9.0).max(0.0)).min(p.y + 6.0) + 0.5 * noise(1.3 * p)
}

/// About the distance from a region in front of the face. Hair falls to both sides of it.
fn beside_face(p: Vec3) -> f32 {
    // Its width changes in steps, so that the gradient points to the side.
    let [x, y] = [p.x, p.y].map(|c| (2.0 * c).round() / 2.0);
    let half = 6.2 * smoothstep(3.0, 6.0, x) * smoothstep(9.0, 4.6, y) * smoothstep(-18.0, -12.0, y);
    if half > 0.0 { p.z.abs() - half } else { f32::INFINITY }
}

/// Hair is combed away from the parting, and backward in front of it.
fn combed(p: Vec3) -> Vec3 {
    let parting = 2.2 + 0.35 * noise(0.9 * Vec3::new(p.x, p.y, 0.0));
    let side = if p.z > parting { 1.0 } else { -1.0 };
    Vec3::new(-0.4 - 0.48 * p.x.max(0.0), -0.5, 1.3 * side)
}

pub(super) fn body() -> Body {
    let none = Flow::Along(Vec3::NEG_Y);
    let straight = Quat::IDENTITY;
    let body = Body::default()
        // Cranium, face, chin, the bridge and tip of the nose, the mouth and its lips.
        .ellipsoid([-0.8, 2.6, 0.0], [9.5, 8.8, 7.5], straight, 1.0, none, 1.0)
        .ellipsoid([3.5, -2.8, 0.0], [5.4, 7.4, 5.3], straight, 3.5, none, 1.0)
        .ellipsoid([7.2, -9.0, 0.0], [1.5, 1.3, 1.5], straight, 2.2, none, 1.0)
        .cone([8.3, 0.9, 0.0], 0.5, [10.2, -3.2, 0.0], 0.55, 1.3, 1.0)
        .ellipsoid([10.0, -3.5, 0.0], [0.85, 0.6, 0.7], straight, 0.7, none, 1.0)
        .ellipsoid([7.0, -6.5, 0.0], [2.0, 1.7, 2.9], straight, 1.6, none, 1.0)
        .ellipsoid([7.65, -6.1, 0.0], [1.45, 0.42, 2.1], straight, 0.5, none, 1.0)
        .ellipsoid([7.55, -7.0, 0.0], [1.45, 0.5, 1.8], straight, 0.5, none, 1.0)
        // Neck and chest.
        .cone([-2.0, -6.0, 0.0], 4.7, [-3.6, -18.0, 0.0], 4.9, 2.6, 1.0)
        .ellipsoid([-3.0, -31.0, 0.0], [8.2, 11.0, 14.5], straight, 4.0, none, 1.0);
    let first = body.len();
    body.cone([-4.5, -14.5, 2.0], 3.0, [-4.5, -21.8, 14.0], 3.0, 4.0, 1.0)
        .ellipsoid([-4.2, -24.0, 15.6], [4.6, 4.6, 4.0], straight, 4.0, none, 1.0)
        .cone([-4.2, -25.0, 16.6], 4.0, [-4.5, -36.0, 17.4], 3.6, 3.0, 1.0)
        // Collar bone, and the muscle from behind the ear to it.
        .cone([2.6, -21.2, 1.6], 0.7, [-1.0, -20.4, 12.0], 0.5, 3.0, 1.0)
        .cone([-1.4, -7.0, 4.2], 1.1, [2.6, -20.0, 1.3], 0.9, 2.2, 1.0)
        // Jaw, cheek bone and brow.
        .cone([0.2, -5.0, 4.1], 1.2, [6.2, -8.7, 0.9], 1.1, 2.6, 1.0)
        .ellipsoid([5.2, -3.3, 3.7], [2.0, 2.4, 1.7], straight, 2.6, none, 1.0)
        .cone([8.0, 1.5, 1.4], 0.8, [6.2, 1.6, 4.8], 0.7, 1.8, 1.0)
        // The hollow of the eye, and the closed lid in it.
        .ellipsoid([9.4, -0.3, 3.2], [1.9, 1.2, 2.0], straight, 1.8, none, 1.0)
        .carved()
        .ellipsoid([6.5, -0.5, 3.15], [1.35, 1.0, 1.45], straight, 0.7, none, 1.0)
        // The wing of the nose.
        .ellipsoid([9.0, -3.9, 0.75], [0.75, 0.5, 0.5], straight, 0.6, none, 1.0)
        // The ear.
        .ellipsoid([-0.6, -1.3, 7.0], [1.6, 2.9, 0.8], straight, 0.8, none, 1.0)
        .mirrored_z(first)
}
