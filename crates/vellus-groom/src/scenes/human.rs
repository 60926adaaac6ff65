//! Hair with a side parting, on the head of a mannequin that faces +x.

use super::glow::glow;
use super::hairstyle::Hairstyle;
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
    let mesh = polygonize(&body, if small { 0.6 } else { 0.36 }, "head", &|_| Vec2::ZERO);
    let settings = style.settings(small);
    // Hair falls beside the face, not over it.
    let face = Body::default().ellipsoid(
        [9.5, -5.0, 0.0],
        [6.0, 8.5, 5.0],
        Quat::IDENTITY,
        1.0,
        Flow::Along(Vec3::NEG_Y),
        1.0,
    );
    let distance = |p: Vec3| body.distance(p).min(face.distance(p));
    let [light, more] = style.melanin;
    let color = |_: &Site, draw: &Draw| [light[0] + more[0] * draw.random, light[1] + more[1] * draw.random, 0.0];
    let maps = Maps {
        density: &|site| f32::from(scalp(site.position)),
        comb: &|site| combed(site.position),
        color: Some((Parameter::Melanin, &color)),
        distance: Some(&distance),
        ..Maps::default()
    };
    scene.strands.push(grow(&mesh, &settings, &maps)?);
    scene.looks.push(Look::constant("hair", preset(Species::Human)));
    scene.meshes.push(mesh);
    scene.surfaces.push(Surface {
        color: Tint { color: [0.2, 0.155, 0.13], texture: None },
        roughness: 0.5,
        ior: 1.4,
        ..Surface::diffuse("mannequin", [0.0; 3])
    });
    let [height, field] = style.framing;
    let target = Vec3::new(-1.0, height, 0.0);
    scene.lights.push(props::window(Vec3::new(60.0, 60.0, 70.0), target, Vec2::splat(50.0), [20.0, 19.2, 18.0]));
    scene.lights.push(props::window(Vec3::new(-90.0, 50.0, 30.0), target, Vec2::splat(45.0), [18.0, 18.6, 20.0]));
    let view = Vec3::new(0.6, 0.06, 0.8).normalize();
    let behind = (0.1 * Vec3::NEG_Y - view).normalize();
    glow(&mut scene, behind, 0.4, Vec3::new(0.5, 0.52, 0.56), Vec3::new(0.16, 0.17, 0.2));
    let eye = target + 190.0 * view;
    scene.camera = Some(Camera::look_at(eye, target, Vec3::Y, field.to_radians(), 1.5));
    Ok(scene)
}

/// Hair grows above a hairline that rises from the nape over the ears to the forehead.
fn scalp(p: Vec3) -> bool {
    p.y > -5.5 + 0.72 * (p.x + 9.0).max(0.0) && p.y > -6.0
}

/// Hair is combed away from the parting, and backward in front of it.
fn combed(p: Vec3) -> Vec3 {
    let parting = 2.2;
    let side = if p.z > parting { 1.0 } else { -1.0 };
    Vec3::new(-0.4 - 0.36 * p.x.max(0.0), -0.5, 1.3 * side)
}

pub(super) fn body() -> Body {
    let none = Flow::Along(Vec3::NEG_Y);
    let straight = Quat::IDENTITY;
    let body = Body::default()
        .ellipsoid([0.0, 2.0, 0.0], [9.4, 9.3, 7.5], straight, 1.0, none, 1.0)
        .ellipsoid([3.4, -4.0, 0.0], [5.6, 7.6, 5.5], straight, 3.0, none, 1.0)
        .ellipsoid([7.0, -9.6, 0.0], [1.8, 1.6, 2.2], straight, 2.5, none, 1.0)
        .cone([8.6, -0.2, 0.0], 0.6, [10.6, -3.6, 0.0], 0.85, 1.4, 1.0)
        .cone([-1.5, -8.0, 0.0], 5.0, [-2.5, -19.0, 0.0], 5.4, 3.0, 1.0)
        .ellipsoid([-2.5, -34.0, 0.0], [8.0, 14.0, 14.0], straight, 4.0, none, 1.0);
    let first = body.len();
    body.cone([-2.5, -21.5, 3.0], 4.0, [-2.5, -25.0, 15.0], 4.8, 4.0, 1.0)
        .cone([-2.5, -25.0, 16.0], 4.6, [-2.5, -45.0, 18.0], 4.0, 3.0, 1.0)
        .ellipsoid([9.0, -0.6, 3.3], [1.5, 1.0, 1.8], straight, 1.4, none, 1.0)
        .carved()
        // Closed eyes: the upper lid overlaps the lower lid.
        .ellipsoid([6.8, -0.75, 3.1], [1.25, 0.95, 1.5], straight, 0.5, none, 1.0)
        .ellipsoid([6.75, -0.35, 3.1], [1.4, 0.75, 1.65], straight, 0.12, none, 1.0)
        // Brow, cheek bone and the wing of the nose.
        .cone([8.6, 1.1, 1.6], 0.5, [7.2, 1.0, 4.8], 0.4, 0.9, 1.0)
        .ellipsoid([6.0, -3.2, 4.0], [1.6, 1.2, 1.5], straight, 1.6, none, 1.0)
        .ellipsoid([9.3, -3.9, 0.75], [0.75, 0.5, 0.5], straight, 0.4, none, 1.0)
        .cone([8.75, -6.0, 0.0], 0.38, [7.9, -6.35, 1.75], 0.22, 0.25, 1.0)
        .cone([8.65, -6.85, 0.0], 0.45, [7.8, -6.5, 1.7], 0.22, 0.25, 1.0)
        .ellipsoid([-0.2, -1.8, 7.0], [1.7, 2.9, 0.8], straight, 0.8, none, 1.0)
        .mirrored_z(first)
}
