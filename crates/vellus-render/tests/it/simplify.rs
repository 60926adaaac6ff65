//! Properties of pictures with level of detail.

use crate::common::noise;
use glam::{Mat3, Mat4, Vec3, Vec4};
use vellus::{Fiber, Species};
use vellus_render::{Film, Layer, Lod, Settings, World, simplify};
use vellus_scene::{Basis, Camera, Instance, LightShape, Look, Prototype, Scene, Strands};
use vellus_testing::significance::max_abs_z;

const SIZE: [usize; 2] = [16, 16];

/// Fine light fur that fills the unit cube: 12,000 strands of length 1 and width 0.0015.
fn fur() -> Strands {
    const COUNT: usize = 12_000;
    let points = (0..COUNT).flat_map(|i| {
        let root = Vec3::new(noise(i, 1), 0.0, noise(i, 2)) - Vec3::new(0.5, 0.5, 0.5);
        let tip = root + Vec3::Y + 0.3 * (Vec3::new(noise(i, 3), 0.5, noise(i, 4)) - 0.5);
        [root, tip].map(|p| Vec4::from((p, 0.000_75)))
    });
    Strands {
        name: "fur".to_owned(),
        basis: Basis::Linear,
        starts: (0..=COUNT).map(|i| 2 * i as u32).collect(),
        points: points.collect(),
        moved: None,
        normals: None,
        root_uv: None,
        look: 0,
        varying: vec![],
    }
}

/// Light from above, so that shadows inside the fur matter.
fn scene() -> Scene {
    let fiber = Fiber::preset(Species::RedFox).with_absorption([0.02, 0.1, 0.3]);
    let sky = LightShape::Dome { radiance: [0.3; 3], texture: None, rotation: Mat3::IDENTITY, ground: None };
    let direction = -Vec3::new(0.3, 1.0, 0.5).normalize();
    Scene {
        strands: vec![fur()],
        looks: vec![Look::constant("fur", fiber)],
        lights: vec![sky.into(), LightShape::Distant { direction, half_angle: 0.05, irradiance: [2.0; 3] }.into()],
        camera: Some(Camera::look_at(Vec3::new(0.5, 1.0, 6.0), Vec3::ZERO, Vec3::Y, 0.2, 1.0)),
        ..Scene::default()
    }
}

/// The mean colour of each of some independent pictures.
fn colors(scene: &Scene, count: u32) -> Vec<[f64; 3]> {
    let world = World::new(scene.clone()).unwrap();
    let picture = |seed| {
        let settings = Settings { seed, ..Settings::new(SIZE) };
        let mut film = Film::new(SIZE, settings.area(), world.layout(&[Layer::Beauty]));
        world.render(&settings, &mut film, 0..16, &()).unwrap();
        let pixels = SIZE[0] * SIZE[1];
        let mean = |c| (0..pixels).map(|i| film.mean(i % SIZE[0], i / SIZE[0], Layer::Beauty, c)).sum::<f64>();
        [0, 1, 2].map(|c| mean(c) / pixels as f64)
    };
    (0..count).map(picture).collect()
}

/// The ratio of two mean colours, and its standard error, for each channel.
fn ratios(some: &[[f64; 3]], all: &[[f64; 3]]) -> [(f64, f64); 3] {
    [0, 1, 2].map(|c| {
        let of = |pictures: &[[f64; 3]]| {
            let n = pictures.len() as f64;
            let mean = pictures.iter().map(|p| p[c]).sum::<f64>() / n;
            let variance = pictures.iter().map(|p| (p[c] - mean).powi(2)).sum::<f64>() / (n - 1.0);
            (mean, variance / n)
        };
        let ((a, va), (b, vb)) = (of(some), of(all));
        (a / b, (va / (a * a) + vb / (b * b)).sqrt() * a / b)
    })
}

/// A tenth of the strands keep the colour within 3 %. The test allows the noise of twelve pictures beside it.
/// False alarms: once in a thousand runs with other seeds, if the means are normally distributed.
#[test]
fn fewer_strands_keep_the_color() {
    let all = scene();
    let mut some = all.clone();
    simplify(&mut some, SIZE, Lod::Bias(0.75));
    let share = some.strands[0].len() as f64 / all.strands[0].len() as f64;
    assert!((0.05..0.2).contains(&share), "{share}");
    let allowed = max_abs_z(3, 1e-3);
    for (ratio, error) in ratios(&colors(&some, 12), &colors(&all, 12)) {
        assert!((ratio - 1.0).abs() < 0.03 + allowed * error, "{ratio} ± {error}");
    }
}

/// Paths find both versions of instances, in proportion to their shares: the mean colour is the mean of that of the
/// pictures with only one version. False alarms: as above.
#[test]
fn paths_choose_between_two_versions() {
    let fur = fur();
    // The second version is not similar to the first, so that the shares show.
    let few = fur.select(|i| (Strands::rank(i) < 0.03).then_some(1.0));
    let of = |name: &str, strands| Prototype { name: name.to_owned(), strands: vec![strands], meshes: vec![] };
    let all = Scene { strands: vec![], prototypes: vec![of("all", fur), of("few", few)], ..scene() };
    let with = |prototype, share: Option<f32>| {
        let simplified = share.map(|share| vellus_scene::Simplified { prototype: 1, share });
        let instance = Instance { simplified, ..Instance::new(prototype, Mat4::IDENTITY) };
        colors(&Scene { instances: vec![instance], ..all.clone() }, 12)
    };
    let (fine, coarse, mixed) = (with(0, None), with(1, None), with(0, Some(0.3)));
    let expected: Vec<[f64; 3]> =
        fine.iter().zip(&coarse).map(|(a, b)| [0, 1, 2].map(|c| 0.7 * a[c] + 0.3 * b[c])).collect();
    let allowed = max_abs_z(6, 1e-3);
    for (ratio, error) in ratios(&mixed, &expected) {
        assert!((ratio - 1.0).abs() < allowed * error, "{ratio} ± {error}");
    }
    // The test would see a wrong share.
    for (ratio, error) in ratios(&mixed, &fine) {
        assert!((ratio - 1.0).abs() > 3.0 * allowed * error, "{ratio} ± {error}");
    }
    // A version that no path finds changes nothing, bit by bit.
    assert_eq!(with(0, Some(0.0)), fine);
}
