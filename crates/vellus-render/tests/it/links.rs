//! Light linking: which things a light lights, whose shadows it lacks, and its gains.

use crate::common::{dome, mean, noise};
use glam::{Mat4, Vec3, Vec4};
use std::sync::atomic::AtomicBool;
use vellus::{Fiber, Species};
use vellus_render::{Film, Layer, Settings, World};
use vellus_scene::{
    Basis, Camera, Instance, Light, LightShape, Link, Look, Mesh, Objects, Prototype, Scene, Strands, Surface, Tint,
};

/// A square in the plane of this height, with half of this size.
fn square(name: &str, height: f32, half: f32, surface: usize) -> Mesh {
    let corner = |x: f32, z: f32| Vec3::new(half * x, height, half * z);
    Mesh {
        name: name.to_owned(),
        positions: vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)],
        moved: None,
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        normals: None,
        uv: None,
        surface,
    }
}

/// Strands over a glossy floor, under a lamp and a sky. The camera sees both.
fn scene() -> Scene {
    let points = (0..60).map(|i| {
        let (strand, k) = (i / 2, (i % 2) as f32);
        Vec4::new(0.8 * noise(strand, 1) - 0.4, 0.1 + 0.5 * k, 0.8 * noise(strand, 2) - 0.4, 0.02)
    });
    let hair = Strands {
        name: "hair".to_owned(),
        basis: Basis::Linear,
        starts: (0..=30).map(|i| 2 * i).collect(),
        points: points.collect(),
        moved: None,
        normals: None,
        root_uv: None,
        look: 0,
        varying: vec![],
    };
    let glossy = Surface {
        color: Tint { color: [0.6, 0.5, 0.3], texture: None },
        roughness: 0.4,
        ior: 1.6,
        ..Surface::diffuse("floor", [0.0; 3])
    };
    let down = Mat4::from_translation(Vec3::new(0.3, 2.0, 0.2)) * Mat4::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    Scene {
        strands: vec![hair],
        meshes: vec![square("floor", 0.0, 1.0, 0)],
        surfaces: vec![glossy],
        looks: vec![Look::constant("fox", Fiber::preset(Species::RedFox))],
        lights: [
            ("lamp", LightShape::Rect { to_world: down, radiance: [2.0; 3], texture: None }.into()),
            ("sky", dome()),
        ]
        .map(|(group, light): (&str, Light)| Light { group: Some(group.to_owned()), ..light })
        .to_vec(),
        camera: Some(Camera::look_at(Vec3::new(0.0, 1.2, 2.6), Vec3::ZERO, Vec3::Y, 0.6, 1.0)),
        ..Scene::default()
    }
}

/// A picture of light that is scattered once.
fn once(scene: &Scene) -> Film {
    render(scene, Settings { max_depth: Some(1), ..Settings::new([24, 24]) })
}

fn render(scene: &Scene, settings: Settings) -> Film {
    let world = World::new(scene.clone()).unwrap();
    let layout = world.layout(&[Layer::Beauty, Layer::Fibers, Layer::Alpha, Layer::Lights]);
    let mut film = Film::new(settings.size, settings.area(), layout);
    world.render(&settings, &mut film, 0..32, &AtomicBool::new(false)).unwrap();
    film
}

fn pixels(film: &Film) -> Vec<[f64; 3]> {
    let at = |i: usize| [0, 1, 2].map(|c| film.mean(i % 24, i / 24, Layer::Beauty, c));
    (0..24 * 24).map(at).collect()
}

/// The largest difference of two pictures, relative to the brightest pixel.
fn difference(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let most = a.as_flattened().iter().copied().fold(0.0, f64::max);
    a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| (a - b).abs() / most).fold(0.0, f64::max)
}

fn linked(link: Link) -> Scene {
    let mut scene = scene();
    scene.lights[0].link = Some(link);
    scene
}

fn named(name: &str) -> Vec<String> {
    vec![name.to_owned()]
}

#[test]
fn a_light_reaches_what_it_is_linked_to() {
    // Strands that the lamp does not light, and a floor that it does not light.
    let pictures = [linked(Link { lit: Objects::Except(named("hair")), ..Link::default() }), {
        linked(Link { lit: Objects::Only(named("hair")), ..Link::default() })
    }];
    for (picture, lit_hair) in pictures.into_iter().zip([false, true]) {
        let film = once(&picture);
        for i in 0..24 * 24 {
            let at = |layer, channel| film.mean(i % 24, i / 24, layer, channel);
            let (hair, lamp) = (at(Layer::Fibers, 0), at(Layer::Lights, 0));
            // Pixels that show one kind of thing only.
            if hair == 0.0 && at(Layer::Alpha, 0) == 1.0 {
                assert!(lamp == 0.0 || !lit_hair, "floor {i}: {lamp}");
            }
            if hair == 1.0 {
                assert!(lamp == 0.0 || lit_hair, "hair {i}: {lamp}");
            }
        }
        let lamp = mean(&film, Layer::Lights, 0);
        assert!(lamp > 1e-4, "{lit_hair} {lamp}");
    }
}

/// A link that excludes nothing changes no light, also with the weights of the two kinds of samples.
#[test]
fn a_link_to_all_things_changes_nothing() {
    let all = linked(Link { lit: Objects::Only(vec!["hair".into(), "floor".into()]), ..Link::default() });
    assert_eq!(pixels(&once(&scene())), pixels(&once(&all)));
}

/// Light goes through things without shadows as if they were not there: the light of a lamp, which two kinds of samples
/// find, and that of a sky, which only scattered rays find. The shadows of others stay.
#[test]
fn things_without_shadows_do_not_block() {
    let blocked = |link: Option<Link>| {
        let mut scene = scene();
        // Above the picture.
        scene.meshes.push(square("lid", 1.4, 0.7, 0));
        let fur = Prototype { name: "fur".to_owned(), strands: vec![], meshes: vec![square("high", 1.5, 0.6, 0)] };
        scene.prototypes.push(fur);
        scene.instances.push(Instance::new(0, Mat4::from_translation(Vec3::new(0.1, 0.0, 0.0))));
        scene.lights.iter_mut().for_each(|light| light.link.clone_from(&link));
        pixels(&once(&scene))
    };
    let open = pixels(&once(&scene()));
    let dark = blocked(None);
    let through =
        blocked(Some(Link { casters: Objects::Except(vec!["lid".to_owned(), "high".to_owned()]), ..Link::default() }));
    // The same samples are summed in another order.
    let [same, other] = [&through, &dark].map(|picture| difference(&open, picture));
    assert!(same < 1e-5 && other > 0.1, "{same} {other}");
    // Without any shadow, each pixel is at least as bright, and the strands' shadows on the floor are gone.
    let none = blocked(Some(Link { casters: Objects::NONE, ..Link::default() }));
    let sum = |picture: &[[f64; 3]]| picture.as_flattened().iter().sum::<f64>();
    assert!(sum(&none) > 1.02 * sum(&open), "{} {}", sum(&none), sum(&open));
    // One of the two still casts a shadow.
    let half = blocked(Some(Link { casters: Objects::Except(named("high")), ..Link::default() }));
    assert!(difference(&open, &half) > 0.1);
}

/// The gains divide light into what diffuse and what specular parts scatter: both together are all of it. Both halve it
/// if they are 0.5.
#[test]
fn gains_scale_diffuse_and_specular_light() {
    type Change = fn(&mut Scene);
    // At strands, shadow rays are left out at random, in proportion to what they would bring.
    let scenes: [(Change, f64); 2] = [(|s| s.strands.clear(), 1e-5), (|s| s.meshes.clear(), 0.02)];
    for (change, tolerance) in scenes {
        let gained = |diffuse: f32, specular: f32| {
            let link = Link { diffuse, specular, ..Link::default() };
            let mut scene = scene();
            for light in &mut scene.lights {
                (light.link, light.visible) = (Some(link.clone()), false);
            }
            change(&mut scene);
            let film = once(&scene);
            (0..3).map(|c| mean(&film, Layer::Beauty, c)).sum::<f64>()
        };
        let [plain, half, diffuse, specular] = [gained(1.0, 1.0), gained(0.5, 0.5), gained(1.0, 0.0), gained(0.0, 1.0)];
        assert_eq!(gained(0.0, 0.0), 0.0);
        assert!((half / plain - 0.5).abs() < tolerance, "{half} {plain}");
        assert!(((diffuse + specular) / plain - 1.0).abs() < tolerance, "{diffuse} + {specular} {plain}");
        assert!(diffuse > 0.1 * plain && specular > 0.1 * plain, "{diffuse} {specular} {plain}");
    }
}

/// Things that other lights reach share no cell of the radiance cache: strands that no light reaches stay black beside
/// equal strands that are lit.
#[test]
fn the_radiance_cache_keeps_linked_things_apart() {
    let mut scene = scene();
    // Only what two fibres scatter would be left: no floor, and black fibres.
    scene.meshes.clear();
    let mut twin = scene.strands[0].clone();
    twin.name = "twin".to_owned();
    twin.points.iter_mut().for_each(|p| *p += Vec4::new(0.02, 0.0, 0.03, 0.0));
    scene.strands.push(twin);
    let link = Link { lit: Objects::Only(named("hair")), ..Link::default() };
    scene.lights.iter_mut().for_each(|light| light.link = Some(link.clone()));
    let cached = |cache| {
        let settings = Settings { radiance_cache: cache, max_depth: Some(3), ..Settings::new([24, 24]) };
        pixels(&render(&scene, settings))
    };
    let sum = |picture: Vec<[f64; 3]>| picture.as_flattened().iter().sum::<f64>();
    let (full, quick) = (sum(cached(None)), sum(cached(Some(64))));
    assert!((quick / full - 1.0).abs() < 0.02, "{quick} {full}");
}
