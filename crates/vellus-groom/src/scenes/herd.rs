//! A hundred hamsters on a meadow. They are instances of one hamster, and the grass consists of instances of one lawn.

use super::noise::noise;
use super::{hamster, props, sky};
use crate::error::Error;
use crate::grow::grow;
use crate::roots::Site;
use crate::scenes::Preset;
use crate::settings::{Clump, Draw, GrowSettings, Maps};
use glam::{Mat4, Quat, Vec3};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f32::consts::{FRAC_PI_2, PI};
use vellus::Fiber;
use vellus_scene::{Camera, Instance, Look, Mesh, Parameter, Prototype, Scene, Strands};

/// Number of hamsters.
const COUNT: usize = 100;
/// Mean distance of neighbours. A hamster is 13 cm long and 9 cm wide.
const SPACING: f32 = 15.5;
/// Half the side of a lawn.
const HALF: f32 = 20.0;
/// Blades of grass on a lawn.
const BLADES: usize = 9_000;
/// Divisor of the number of blades in a small scene, and factor of their width.
const FEWER: (usize, f32) = (10, 2.5);
/// The meadow has lawns of this scale up to this distance from the middle of the herd. Farther lawns are larger, so
/// that a thousand reach the horizon.
const RINGS: [(f32, f32); 3] = [(1.0, 300.0), (3.0, 1200.0), (9.0, 5000.0)];

/// The angle between one seed of a sunflower and the next: π (3 − √5).
const GOLDEN_ANGLE: f32 = 2.399_963;

/// Index of the prototypes.
const HAMSTER: usize = 0;
const LAWN: usize = 1;

pub(super) fn scene(small: bool, preset: Preset) -> Result<Scene, Error> {
    let mut scene = hamster::animal(small, preset)?;
    let animal = Prototype {
        name: "hamster".to_owned(),
        strands: std::mem::take(&mut scene.strands),
        meshes: std::mem::take(&mut scene.meshes),
    };
    let grass = Strands { look: scene.looks.len(), ..blades(small)? };
    scene.looks.push(Look::constant("grass", leaf()));
    scene.prototypes = vec![animal, Prototype { name: "lawn".to_owned(), strands: vec![grass], meshes: Vec::new() }];
    scene.instances = herd();
    scene.instances.extend(meadow());
    props::ground(&mut scene, 20_000.0, [0.09, 0.1, 0.045]);
    sky::sky(&mut scene, Vec3::new(0.55, 0.75, 0.6));
    let eye = Vec3::new(285.0, 46.0, 0.0);
    let camera = Camera::look_at(eye, Vec3::new(0.0, 4.4, 0.0), Vec3::Y, 21f32.to_radians(), 1.5);
    // The front third of the herd is in focus, and the horizon is soft.
    scene.camera = Some(Camera { lens_radius: 0.7, focus_distance: 245.0, ..camera });
    Ok(scene)
}

/// The hamsters stand as seeds do in a sunflower, off their place by up to a seventh of the spacing. Most face the
/// camera, which is in the direction +x. Half are mirrored, so that fewer look the same.
fn herd() -> Vec<Instance> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
    let mut random = || 2.0 * rng.random::<f32>() - 1.0;
    let place = |i: usize| {
        // Each hamster has the area of a square of this side.
        let radius = SPACING * ((i as f32 + 0.5) / PI).sqrt();
        let (sin, cos) = (GOLDEN_ANGLE * i as f32).sin_cos();
        let off = SPACING / 7.0 * Vec3::new(random(), 0.0, random());
        // The cube makes large turns rare.
        let turn = Quat::from_rotation_y(PI * random().powi(3)) * Quat::from_rotation_z(0.12 * random());
        let size = 0.93 + 0.1 * random();
        let mirror = if random() < 0.0 { -1.0 } else { 1.0 };
        let root = radius * Vec3::new(cos, 0.0, sin) + off;
        let to_world = Mat4::from_scale_rotation_translation(Vec3::splat(size), turn, root)
            * Mat4::from_scale(Vec3::new(1.0, 1.0, mirror));
        Instance::new(HAMSTER, to_world)
    };
    (0..COUNT).map(place).collect()
}

/// Lawns side by side. Each is turned by a random number of right angles. Larger lawns begin half a side before smaller
/// ones end, so that no line shows.
fn meadow() -> Vec<Instance> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(6);
    let mut lawns = Vec::new();
    let mut inner = 0.0;
    for (scale, outer) in RINGS {
        let side = 2.0 * HALF * scale;
        let count = (2.0 * outer / side).round() as i32;
        for i in 0..count * count {
            let at = |k: i32| (k as f32 + 0.5 - 0.5 * count as f32) * side;
            let center = Vec3::new(at(i / count), 0.0, at(i % count));
            let turn = Quat::from_rotation_y(FRAC_PI_2 * f32::from(rng.random_range(0..4u8)));
            if center.length() < outer && center.length() >= inner - 0.5 * side {
                let to_world = Mat4::from_scale_rotation_translation(Vec3::splat(scale), turn, center);
                lawns.push(Instance::new(LAWN, to_world));
            }
        }
        inner = outer;
    }
    lawns
}

/// The grass of one lawn.
fn blades(small: bool) -> Result<Strands, Error> {
    let corner = |x: f32, z: f32| Vec3::new(x * HALF, 0.0, z * HALF);
    let soil = Mesh {
        name: "soil".to_owned(),
        positions: vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)],
        moved: None,
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        normals: None,
        uv: None,
        surface: 0,
    };
    let (fewer, wider) = if small { FEWER } else { (1, 1.0) };
    let settings = GrowSettings {
        name: "grass".to_owned(),
        count: BLADES / fewer,
        segments: 4,
        length: 2.6,
        length_variation: 0.6,
        radius: [0.07, 0.012].map(|radius| radius * wider),
        radius_variation: 0.3,
        lift: [1.35, 1.0],
        spread: 0.3,
        gravity: 0.5,
        clump: Clump { strands: 12, strength: 0.25, power: 1.0 },
        noise: 0.06,
        ..GrowSettings::default()
    };
    // Some blades are dry.
    let color = |_: &Site, draw: &Draw| {
        let pigment = if draw.random > 0.86 { [0.14, 0.22, 0.5] } else { [0.5, 0.24, 1.3] };
        pigment.map(|sigma| sigma * (0.8 + 0.5 * draw.random))
    };
    // Blades lean with the wind, which changes slowly.
    let comb = |site: &Site| Vec3::new(noise(0.12 * site.position), 0.0, noise(0.12 * site.position + 7.0));
    // Tufts.
    let length = |site: &Site| 0.8 + 0.4 * noise(0.2 * site.position) + 0.4 * noise(0.6 * site.position);
    let color = Some((Parameter::SigmaMa, &color as _));
    grow(&soil, &settings, &Maps { comb: &comb, length: &length, color, ..Maps::default() })
}

/// A blade of grass: a wide core that scatters and has the pigment, and a rough surface.
fn leaf() -> Fiber {
    Fiber { kappa: 0.85, sigma_ms: 2.5, g: 0.3, beta_m: 0.25, beta_n: 0.35, ..Fiber::hair() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All hamsters share the strands of one, and stand beside each other. Two bodies that face each other reach 13 cm,
    /// but hamsters may touch with their sides, 9 cm apart.
    #[test]
    fn a_hundred_hamsters_share_one_and_stand_apart() {
        let scene = scene(true, Fiber::preset).unwrap();
        let places = |prototype: usize| {
            let of = scene.instances.iter().filter(move |instance| instance.prototype == prototype);
            of.map(|instance| instance.to_world.w_axis.truncate()).collect::<Vec<Vec3>>()
        };
        let animals = places(HAMSTER);
        assert_eq!((animals.len(), scene.prototypes[HAMSTER].strands[0].len()), (COUNT, 14_500));
        for (i, a) in animals.iter().enumerate() {
            let nearest = animals[..i].iter().map(|b| a.distance(*b)).fold(f32::INFINITY, f32::min);
            assert!(nearest > 9.0, "hamster {i}: {nearest}");
        }
        let camera = scene.camera.unwrap();
        let to_camera = camera.to_world.inverse();
        let seen = animals.iter().map(|p| to_camera.transform_point3(*p)).filter(|p| {
            let [x, y] = [p.x / -p.z, p.y / -p.z];
            x.abs() < 0.5 * camera.film_width && y.abs() < 0.5 * camera.film_height
        });
        // Some at the sides are outside the picture.
        assert!(seen.count() >= 90);
    }

    /// Every place of the meadow has a lawn: a point is in the square of one of them.
    #[test]
    fn the_meadow_has_no_gaps() {
        let lawns = meadow();
        assert!(lawns.len() < 2000, "{}", lawns.len());
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        for _ in 0..2000 {
            let radius = 4500.0 * rng.random::<f32>();
            let (sin, cos) = (2.0 * PI * rng.random::<f32>()).sin_cos();
            let p = Vec3::new(radius * cos, 0.0, radius * sin);
            let local = |lawn: &Instance| lawn.to_world.inverse().transform_point3(p).abs().max_element();
            assert!(lawns.iter().any(|lawn| local(lawn) <= HALF * 1.001), "{p}");
        }
    }
}
