//! Pictures with other reflectance models.

use glam::{Mat3, Vec3, Vec4};
use vellus::{Bcsdf, Fiber, Model, Scattering, Window};
use vellus_models::{Chiang2016, DEon2011, KajiyaKay1989, Marschner2003, Yan2015, ZinkeWeber2007};
use vellus_render::{Film, Filter, Layer, Mode, Settings, World};
use vellus_scene::{Basis, Camera, LightShape, Look, Parameter, Scene, Strands, Texture, Value, Values};
use vellus_testing::significance::max_abs_z;

const SIZE: usize = 16;

fn fiber() -> Fiber {
    Fiber {
        eta: 1.5,
        kappa: 0.6,
        alpha: 0.05,
        beta_m: 0.15,
        beta_n: 0.2,
        sigma_ca: [0.1, 0.3, 0.7],
        sigma_ma: [0.02, 0.05, 0.09],
        sigma_ms: 0.8,
        g: 0.4,
        layers: 1.5,
        exit: vellus::ScatterExit::default(),
        medulla_pigment: 0.3,
        wet: 0.0,
        aspect_ratio: 1.0,
        medulla_air: 0.0,
        reflectance: None,
    }
}

/// One straight fibre that fills the picture from edge to edge, in white light. The picture shows its albedo over all
/// offsets.
fn scene(varying: bool) -> Scene {
    let points = (0..4).map(|i| Vec4::new(0.0, 20.0 * (i as f32 - 1.5), 0.0, 0.1)).collect();
    let values = Values::PerPoint(vec![fiber().sigma_ca; 4]);
    let strands = Strands {
        name: "one".to_owned(),
        basis: Basis::Linear,
        starts: vec![0, 4],
        points,
        moved: None,
        normals: None,
        root_uv: None,
        look: 0,
        varying: if varying { vec![(Parameter::SigmaCa, values)] } else { vec![] },
    };
    // A colour that the varying parameter replaces.
    let look = Fiber { sigma_ca: if varying { [0.4, 0.01, 0.2] } else { fiber().sigma_ca }, ..fiber() };
    Scene {
        strands: vec![strands],
        looks: vec![Look::constant("fur", look)],
        lights: vec![
            LightShape::Dome { radiance: [1.0; 3], texture: None, rotation: Mat3::IDENTITY, ground: None }.into(),
        ],
        // The camera is far away and its angle of view is narrow, so all rays are nearly parallel and hit the fibre.
        camera: Some(Camera::look_at(Vec3::new(0.0, 0.0, 100.0), Vec3::ZERO, Vec3::Y, 0.19 / 100.0, 1.0)),
        ..Scene::default()
    }
}

fn picture(world: &World) -> ([f64; 3], f64) {
    let settings = Settings {
        size: [SIZE; 2],
        crop: None,
        mode: Mode::Near,
        filter: Filter::Tent,
        seed: 3,
        max_depth: None,
        clamp_indirect: None,
        radiance_cache: None,
    };
    let mut film = Film::new(settings.size, settings.area(), world.layout(&[Layer::Lobes]));
    let statistics = world.render(&settings, &mut film, 0..64, &()).unwrap();
    assert_eq!(statistics.rejected, 0);
    let pixels = (SIZE * SIZE) as f64;
    let mean =
        |c: usize| (0..SIZE * SIZE).map(|i| film.mean(i % SIZE, i / SIZE, Layer::Beauty, c)).sum::<f64>() / pixels;
    let error = (0..SIZE * SIZE).map(|i| film.error(i % SIZE, i / SIZE).powi(2)).sum::<f64>().sqrt() / pixels;
    ([mean(0), mean(1), mean(2)], error)
}

/// The albedo over the offsets in the picture: up to 0.95, at normal incidence.
fn albedo<M: Model>(model: &M) -> [f64; 3] {
    let n = 400;
    let mut sum = [0.0; 3];
    for k in 0..n {
        let h = 0.95 * (2.0 * (k as f32 + 0.5) / n as f32 - 1.0);
        let energy = model.at(Vec3::Y, Window::near(h)).energy().total();
        (0..3).for_each(|c| sum[c] += f64::from(energy[c]) / f64::from(n));
    }
    sum
}

fn check<M: Model + Send + 'static>(name: &str, make: impl Fn(&Fiber) -> Result<M, vellus::Error>) {
    let expected = albedo(&make(&fiber()).unwrap());
    // There are seven models, each constant and varying, with three channels.
    let bound = max_abs_z(7 * 2 * 3, 0.01);
    for varying in [false, true] {
        let mut world = World::new(scene(varying)).unwrap();
        world.set_model(&make).unwrap();
        let (seen, error) = picture(&world);
        println!("{name}: {seen:.4?} ± {error:.4}, albedo {expected:.4?}");
        for c in 0..3 {
            // The film knows the error of the channels' mean. The error of the brightest channel is up to 1.5 times
            // that.
            // D'Eon's varying fibres are interpolated between tables.
            let tolerance = 1.5 * bound * error + if varying && name == "deon2011" { 0.005 } else { 5e-4 };
            assert!((seen[c] - expected[c]).abs() < tolerance, "{name}: {seen:?} {expected:?} ± {error}");
        }
    }
}

#[test]
fn a_fiber_in_white_light_shows_its_models_albedo() {
    check("vellus", Bcsdf::new);
    check("yan2015", |fiber| Yan2015::with_eta_m(fiber, 1.3));
    check("chiang2016", Chiang2016::new);
    check("deon2011", DEon2011::new);
    check("zinke-weber2007", ZinkeWeber2007::new);
    check("marschner2003", Marschner2003::new);
    check("kajiya-kay1989", KajiyaKay1989::new);
}

/// A scene with a texture of one pixel for β_m.
fn textured(pixel: f32, scale: f32) -> Scene {
    let mut scene = scene(false);
    scene.textures = vec![Texture {
        name: String::new(),
        width: 1,
        height: 1,
        pixels: vec![[pixel; 3]].into(),
        wrap: Default::default(),
    }];
    scene.looks[0].textured = vec![(Parameter::BetaM, Value { texture: 0, scale: [scale; 3] })];
    scene
}

#[test]
fn a_texture_gives_angles_in_degrees() {
    let mut constant = scene(false);
    constant.looks[0].fiber.beta_m = 12f32.to_radians();
    let expected = picture(&World::new(constant).unwrap());
    assert_eq!(picture(&World::new(textured(24.0, 0.5)).unwrap()), expected);
}

/// Sums and products of finite values may be infinite or NaN. The fibre then gets the nearest value in range.
#[test]
fn no_finite_value_of_a_texture_or_a_point_breaks_a_render() {
    for (pixel, scale) in [(f32::MAX, 0.0), (f32::MAX, -9.0), (f32::MAX, f32::MAX)] {
        picture(&World::new(textured(pixel, scale)).unwrap());
    }
    let mut steep = scene(true);
    let values = (0..4).map(|i| [f32::MAX * (-1f32).powi(i); 3]).collect();
    steep.strands[0].varying = vec![(Parameter::Kappa, Values::PerPoint(values))];
    picture(&World::new(steep).unwrap());
    for scale in [f32::INFINITY, f32::NAN] {
        let error = World::new(textured(0.0, scale)).err().unwrap().to_string();
        assert!(error.contains("fur: beta_m has a texture with the scale"), "{error}");
    }
}
