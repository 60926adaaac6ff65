//! Properties of pictures.

use crate::common::{dome, mean, noise};
use glam::{Mat4, Vec3, Vec4};
use std::sync::atomic::AtomicBool;
use vellus::{Fiber, Species};
use vellus_render::{Error, Film, Filter, Layer, Mode, Settings, World};
use vellus_scene::{Basis, Camera, Light, LightShape, Look, Mesh, Scene, Strands, Surface};
use vellus_testing::significance::max_abs_z;

fn fiber() -> Fiber {
    Fiber::preset(Species::RedFox).with_absorption([0.1, 0.3, 0.7])
}

/// Bent strands through the middle of a unit ball.
fn clump(count: usize, radius: f32, fiber: Fiber) -> Scene {
    let mut points = Vec::new();
    for i in 0..count {
        let mut p = 0.35 * (Vec3::new(noise(i, 1), noise(i, 2), noise(i, 3)) - 0.5) - 0.5 * Vec3::Y;
        let bend = 0.1 * (Vec3::new(noise(i, 4), noise(i, 5), noise(i, 6)) - 0.5);
        let mut step = 0.2 * Vec3::Y;
        for _ in 0..6 {
            points.push(Vec4::from((p, radius)));
            p += step;
            step += bend;
        }
    }
    let starts = (0..=count).map(|i| 6 * i as u32).collect();
    let strands = Strands {
        name: "clump".to_owned(),
        basis: Basis::BSpline,
        starts,
        points,
        moved: None,
        normals: None,
        root_uv: None,
        look: 0,
        varying: vec![],
    };
    Scene {
        strands: vec![strands],
        looks: vec![Look::constant("fur", fiber)],
        lights: vec![dome()],
        camera: Some(Camera::look_at(Vec3::new(0.1, 0.2, 3.0), Vec3::ZERO, Vec3::Y, 0.3, 1.0)),
        ..Scene::default()
    }
}

fn settings(size: usize, mode: Mode) -> Settings {
    Settings {
        size: [size, size],
        crop: None,
        mode,
        filter: Filter::Tent,
        seed: 1,
        max_depth: None,
        clamp_indirect: None,
        radiance_cache: None,
    }
}

fn empty(world: &World, settings: &Settings) -> Film {
    Film::new(settings.size, settings.area(), world.layout(&Layer::ALL))
}

fn render(world: &World, settings: &Settings, samples: u64) -> Film {
    let mut film = empty(world, settings);
    let statistics = world.render(settings, &mut film, 0..samples, &()).unwrap();
    assert_eq!(statistics.rejected, 0);
    film
}

/// Clamped indirect light: paths are the same, so the picture loses just the light that is reported, and no channel of
/// a pixel becomes brighter. A limit that no light reaches changes nothing.
#[test]
fn clamped_light_is_reported() {
    let mut scene = clump(300, 0.006, Fiber { kappa: 0.2, ..fiber() }.without_absorption());
    let to_sun = Vec3::new(-1.0, 0.5, 0.2).normalize();
    scene.lights.push(LightShape::Distant { direction: to_sun, half_angle: 0.05, irradiance: [3.0, 2.0, 1.0] }.into());
    let world = World::new(scene).unwrap();
    let clamped = |limit: f32| {
        let settings = Settings { clamp_indirect: Some(limit), ..settings(24, Mode::MultiScale) };
        let mut film = empty(&world, &settings);
        let statistics = world.render(&settings, &mut film, 0..16, &()).unwrap();
        (film, statistics.removed())
    };
    let (whole, without) = (render(&world, &settings(24, Mode::MultiScale), 16), clamped(1e30));
    assert_eq!(without.1, 0.0);
    let (less, removed) = clamped(0.5);
    let light = |film: &Film| (0..3).map(|c| mean(film, Layer::Beauty, c)).sum::<f64>();
    assert_eq!(light(&whole), light(&without.0));
    assert!(removed > 0.005 && removed < 0.5, "{removed}");
    // The film rounds each sample to 24 bits.
    assert!((1.0 - light(&less) / light(&whole) - removed).abs() < 1e-5, "{removed}");
    for (i, c) in (0..24 * 24).flat_map(|i| (0..3).map(move |c| (i, c))) {
        let [less, whole] = [&less, &whole].map(|film| film.mean(i % 24, i / 24, Layer::Beauty, c));
        assert!(less <= whole * (1.0 + 1e-6), "pixel {i}, channel {c}: {less} {whole}");
    }
}

/// A white furnace: white fibres in white light are invisible, for one fibre, for a clump of a thousand, and for
/// flat ones.
#[test]
#[ignore = "test: nine pictures of 1,024 pixels with 256 samples"]
fn furnace_is_white() {
    let white = Fiber { kappa: 0.86, sigma_ms: 4.0, ..fiber() }.without_absorption();
    for (count, radius, aspect_ratio) in [(1, 0.1, 1.0), (1000, 0.004, 1.0), (1000, 0.006, 0.5)] {
        let world = World::new(clump(count, radius, Fiber { aspect_ratio, ..white })).unwrap();
        for mode in [Mode::MultiScale, Mode::Near, Mode::Far] {
            let film = render(&world, &settings(32, mode), 256);
            let all = mean(&film, Layer::Beauty, 0);
            let covered = mean(&film, Layer::Alpha, 0);
            let pixels = (0..32 * 32).map(|i| film.error(i % 32, i / 32).powi(2)).sum::<f64>();
            let error = pixels.sqrt() / (32.0 * 32.0);
            println!("{count} strands of {aspect_ratio}, {mode:?}: {all} ± {error}, {covered} covered");
            assert!(covered > 0.05);
            assert!((all - 1.0).abs() < 0.005 * covered.max(0.2), "{count} strands, {mode:?}: {all}");
        }
    }
}

#[test]
fn lobe_layers_sum_to_beauty() {
    let world = World::new(clump(300, 0.006, fiber())).unwrap();
    for mode in [Mode::MultiScale, Mode::Near, Mode::Far] {
        let film = render(&world, &settings(24, mode), 8);
        for i in 0..24 * 24 {
            let at = |layer, channel| film.mean(i % 24, i / 24, layer, channel);
            // Beauty is the sum of the lobes and, where nothing covers the pixel, the dome.
            let background = 1.0 - at(Layer::Alpha, 0);
            for c in 0..3 {
                let lobes: f64 = (0..6).map(|p| at(Layer::Lobes, 3 * p + c)).sum();
                let beauty = at(Layer::Beauty, c);
                assert!(
                    (lobes + background - beauty).abs() < 1e-5,
                    "{mode:?} pixel {i}: {lobes} {background} {beauty}"
                );
            }
        }
    }
}

/// From a moonless night to the sun, the picture scales with the light, and its relative noise stays the same. Scenes
/// from millimetres to a hundred kilometres give the right picture.
#[test]
fn pictures_scale_with_light_and_size() {
    let scene = |light: f32| {
        let mut scene = clump(60, 0.01, fiber());
        let sun =
            LightShape::Distant { direction: Vec3::new(1.0, 2.0, 0.5), half_angle: 0.02, irradiance: [3.0, 2.0, 1.0] };
        scene.lights.push(sun.into());
        for l in &mut scene.lights {
            match &mut l.shape {
                LightShape::Dome { radiance: power, .. } | LightShape::Distant { irradiance: power, .. } => {
                    *power = power.map(|x| x * light);
                }
                _ => {}
            }
        }
        scene
    };
    let settings = settings(16, Mode::MultiScale);
    let expected = render(&World::new(scene(1.0)).unwrap(), &settings, 16);
    let noise = expected.noise().unwrap();
    for exponent in [-36, -30, -10, 10, 30, 36] {
        // Powers of two: scaling does not round.
        let light = 2f32.powi(exponent);
        let film = render(&World::new(scene(light)).unwrap(), &settings, 16);
        // The squares of the rounding errors of 16 samples to units of 2⁻⁶⁴ are far below this.
        assert!((film.noise().unwrap() / noise - 1.0).abs() < 1e-6, "{exponent}: {:?} {noise}", film.noise());
        for i in 0..16 * 16 {
            let at = |film: &Film| film.mean(i % 16, i / 16, Layer::Beauty, 1);
            let (found, scaled) = (at(&film), at(&expected) * f64::from(light));
            assert!((found - scaled).abs() <= 1e-6 * scaled + 1e-19, "{exponent}, pixel {i}: {found} {scaled}");
        }
        assert_eq!(film.full_pixels(), 0);
    }
}

/// The scene has lights of every kind and a mesh that emits. Two lights share a group, and one light is very bright.
/// The sum of the groups is the beauty. Each group equals the picture with only the lights of that group.
#[test]
fn light_groups_sum_to_beauty() {
    let mut scene = clump(100, 0.01, fiber());
    let place = |x: f32| Mat4::from_translation(Vec3::new(x, 0.2, 1.5));
    let lights = [
        LightShape::Distant { direction: Vec3::new(1.0, 2.0, 0.5), half_angle: 0.02, irradiance: [3.0, 2.0, 1.0] },
        LightShape::Rect { to_world: place(1.0), radiance: [0.5, 1.0, 2.0], texture: None },
        LightShape::Disk { to_world: place(-1.0), radiance: [1.0, 0.3, 0.2] },
        LightShape::Sphere { center: Vec3::new(0.4, 0.4, 0.2), radius: 0.1, radiance: [3.0, 1.0, 7.0] },
    ];
    scene.lights.extend(lights.map(Light::from));
    for (light, group) in scene.lights.iter_mut().zip(["sky", "sky", "key", "rim", "lamp"]) {
        light.group = Some(group.to_owned());
    }
    let corners = [Vec3::new(-0.4, -0.4, 0.3), Vec3::new(0.0, -0.4, 0.3), Vec3::new(-0.4, 0.0, 0.2)];
    let glowing = Surface { emission: [0.7, 0.2, 0.1], ..Surface::diffuse("glow", [0.3, 0.5, 0.7]) };
    scene.meshes = vec![Mesh {
        name: "glow".to_owned(),
        positions: corners.to_vec(),
        moved: None,
        triangles: vec![[0, 1, 2]],
        normals: None,
        uv: None,
        surface: 0,
    }];
    scene.surfaces = vec![glowing];
    let settings = settings(24, Mode::MultiScale);
    let sums_to_beauty = |scene: &Scene, samples: u64| {
        let film = render(&World::new(scene.clone()).unwrap(), &settings, samples);
        assert_eq!(film.layout().groups(), ["sky", "key", "rim", "lamp", "emission"]);
        let mut brightest = 0.0f64;
        for (i, c) in (0..24 * 24).flat_map(|i| (0..3).map(move |c| (i, c))) {
            let at = |layer, channel| film.mean(i % 24, i / 24, layer, channel);
            let (sum, beauty) = ((0..5).map(|g| at(Layer::Lights, 3 * g + c)).sum::<f64>(), at(Layer::Beauty, c));
            // Sums of a few hundred floats.
            assert!((sum - beauty).abs() < 1e-5 * beauty.max(1.0), "pixel {i}: {sum} {beauty}");
            brightest = brightest.max(beauty);
        }
        (film, brightest)
    };
    let (film, _) = sums_to_beauty(&scene, 64);
    let LightShape::Sphere { radiance, .. } = &mut scene.lights[4].shape else { panic!() };
    *radiance = [3e4, 1e4, 7e4];
    let (_, brightest) = sums_to_beauty(&scene, 4);
    // The camera sees this light directly, and its radiance is not clamped.
    assert!((brightest / 7e4 - 1.0).abs() < 1e-5, "{brightest}");
    // Only the group of two lights. The other lights are dark, but block as much light as before.
    for light in &mut scene.lights[2..] {
        if let LightShape::Rect { radiance, .. }
        | LightShape::Disk { radiance, .. }
        | LightShape::Sphere { radiance, .. } = &mut light.shape
        {
            *radiance = [0.0; 3];
        }
    }
    scene.surfaces[0].emission = [0.0; 3];
    let alone = render(&World::new(scene).unwrap(), &settings, 64);
    for c in 0..3 {
        let (part, alone) = (mean(&film, Layer::Lights, c), mean(&alone, Layer::Beauty, c));
        // 64 samples of 576 pixels with a relative standard deviation of about 1 have an error of 0.5 %.
        assert!((part / alone - 1.0).abs() < 0.02, "channel {c}: {part} {alone}");
    }
}

/// The strand of a pixel is the nearest one of its samples, and root coordinates come from strands only.
#[test]
fn strands_are_distinguished() {
    let mut scene = clump(1, 0.02, fiber());
    let points = |x: f32, z: f32| [Vec4::new(x, -2.0, z, 0.2), Vec4::new(x, 2.0, z, 0.2)];
    let set = |x: f32, z: f32, uv: [f32; 2]| Strands {
        basis: Basis::Linear,
        starts: vec![0, 2, 4],
        points: [points(x - 0.2, z), points(x + 0.2, z)].concat(),
        root_uv: Some(vec![uv.into(), uv.into()]),
        ..scene.strands[0].clone()
    };
    // Two strands are on the left, and two on the right. The first strand is behind those on the left.
    scene.strands = vec![
        Strands {
            points: points(-0.5, -1.0).to_vec(),
            basis: Basis::Linear,
            starts: vec![0, 2],
            ..set(0.0, 0.0, [0.0; 2])
        },
        set(-0.5, 0.0, [0.25, 0.75]),
        set(0.5, 0.0, [0.5, 0.125]),
    ];
    scene.strands[0].root_uv = None;
    scene.camera = Some(Camera::look_at(Vec3::new(0.0, 0.0, 6.0), Vec3::ZERO, Vec3::Y, 0.35, 1.0));
    let world = World::new(scene).unwrap();
    let film = render(&world, &settings(40, Mode::MultiScale), 8);
    let row: Vec<u32> = (0..40).map(|x| film.strand(x, 20)).collect();
    for id in [2, 3, 4, 5] {
        assert!(row.contains(&id), "{row:?}");
    }
    // The first strand is hidden by two others.
    let seen: Vec<u32> = row.iter().copied().filter(|&id| id > 0).collect();
    assert!(seen.is_sorted() && seen[0] == 2, "{row:?}");
    for (x, uv) in [(8, [0.25, 0.75]), (32, [0.5, 0.125])] {
        let covered = film.mean(x, 20, Layer::Fibers, 0);
        for k in 0..2 {
            assert!((film.mean(x, 20, Layer::RootUv, k) / covered - uv[k]).abs() < 1e-6);
        }
    }
}

/// The film has the same bits for any number of threads and any division of the samples.
#[test]
fn threads_and_ranges_do_not_change_the_image() {
    let world = World::new(clump(200, 0.006, fiber())).unwrap();
    let settings = settings(20, Mode::MultiScale);
    let whole = render(&world, &settings, 12);
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    assert_eq!(pool(1).install(|| render(&world, &settings, 12)), whole);
    let part = |range| {
        let mut film = empty(&world, &settings);
        world.render(&settings, &mut film, range, &()).unwrap();
        film
    };
    let mut merged = part(7..12);
    merged.merge(&part(0..3));
    merged.merge(&part(3..7));
    assert_eq!(merged, whole);
}

/// A film of another picture, a cancelled call and an invalid camera give errors and change nothing.
#[test]
fn films_and_cameras_that_do_not_fit_are_errors() {
    let mut world = World::new(clump(20, 0.006, fiber())).unwrap();
    let settings = settings(8, Mode::Near);
    let whole = render(&world, &settings, 2);
    let other = |settings: Settings| {
        let mut film = whole.clone();
        let error = world.render(&settings, &mut film, 2..3, &()).unwrap_err();
        assert!(matches!(error, Error::OtherFilm(_)) && film == whole, "{error}");
    };
    other(Settings { size: [9, 8], ..settings });
    other(Settings { crop: Some([0, 0, 8, 4]), ..settings });
    let groups = ["not in this scene".to_owned()];
    let layout = vellus_render::Layout::new(&[Layer::Lights], &groups);
    let mut film = Film::new(settings.size, settings.area(), layout);
    assert!(matches!(world.render(&settings, &mut film, 0..1, &()), Err(Error::OtherFilm(_))));
    let mut film = whole.clone();
    let error = world.render(&settings, &mut film, 2..3, &AtomicBool::new(true)).unwrap_err();
    assert!(matches!(error, Error::Cancelled) && film == whole);
    let camera = Camera::look_at(Vec3::Z * 4.0, Vec3::ZERO, Vec3::Y, 0.5, 1.0);
    assert!(world.set_camera(Camera { moved: Some(Mat4::NAN), ..camera }).is_err());
    assert_eq!(render(&world, &settings, 2), whole);
    assert!(world.set_camera(camera).is_ok());
}

/// A crop has the same bits as that part of the whole picture.
#[test]
fn crops_are_cut_from_the_whole() {
    let world = World::new(clump(200, 0.006, fiber())).unwrap();
    let whole = render(&world, &settings(20, Mode::MultiScale), 4);
    let crop = Settings { crop: Some([7, 3, 6, 9]), ..settings(20, Mode::MultiScale) };
    let part = render(&world, &crop, 4);
    for (x, y) in (0..6).flat_map(|x| (0..9).map(move |y| (x, y))) {
        let layers = Layer::ALL.into_iter().flat_map(|layer| (0..layer.channels()).map(move |k| (layer, k)));
        for (layer, k) in layers.filter(|(layer, _)| *layer != Layer::Strand) {
            assert_eq!(part.mean(x, y, layer, k), whole.mean(7 + x, 3 + y, layer, k));
        }
        assert_eq!(part.strand(x, y), whole.strand(7 + x, 3 + y));
    }
}

/// If a pixel covers many fibres, all three modes agree. Flat strands have directions of their own.
#[test]
fn modes_agree_from_afar() {
    for aspect_ratio in [1.0, 0.5] {
        modes_agree(Fiber { aspect_ratio, ..fiber() });
    }
}

fn modes_agree(fiber: Fiber) {
    let world = World::new(clump(400, 0.004, fiber)).unwrap();
    let film = |mode| render(&world, &settings(8, mode), 4096);
    let [multi, near, far] = [Mode::MultiScale, Mode::Near, Mode::Far].map(film);
    let error = |a: &Film, b: &Film| {
        let n = 64.0;
        (0..64).map(|i| a.error(i % 8, i / 8).powi(2) + b.error(i % 8, i / 8).powi(2)).sum::<f64>().sqrt() / n
    };
    for (name, other) in [("multi-scale", &multi), ("far", &far)] {
        let brightness = |film: &Film| (0..3).map(|c| mean(film, Layer::Beauty, c)).sum::<f64>() / 3.0;
        let (a, b, e) = (brightness(other), brightness(&near), error(other, &near));
        println!("{name}: {a} near {b} ± {e}");
        // The far field is not exact for fibres behind other fibres: which offsets h are hidden is not uniform.
        assert!((a - b).abs() < max_abs_z(4, 0.001) * e + 0.003 * b, "{name}: {a} near {b} ± {e}");
    }
}

/// A scene ten times as large gives the same picture, except for rounding.
#[test]
fn fibre_scale_does_not_matter() {
    let scene = clump(300, 0.006, fiber());
    let mut large = scene.clone();
    large.strands[0].points.iter_mut().for_each(|p| *p *= 10.0);
    let camera = Camera::look_at(Vec3::new(1.0, 2.0, 30.0), Vec3::ZERO, Vec3::Y, 0.3, 1.0);
    large.camera = Some(camera);
    let settings = settings(16, Mode::MultiScale);
    let (small, large) = (World::new(scene).unwrap(), World::new(large).unwrap());
    let (a, b) = (render(&small, &settings, 64), render(&large, &settings, 64));
    for c in 0..3 {
        let (a, b) = (mean(&a, Layer::Beauty, c), mean(&b, Layer::Beauty, c));
        // Paths are the same until rounding makes one hit another fibre.
        assert!((a / b - 1.0).abs() < 0.01, "channel {c}: {a} {b}");
    }
}

/// A diffuse floor under a rectangular light, compared with the integral over the light.
#[test]
fn light_on_a_floor_is_the_integral_over_the_light() {
    let corners =
        [Vec3::new(-5.0, 0.0, -5.0), Vec3::new(5.0, 0.0, -5.0), Vec3::new(5.0, 0.0, 5.0), Vec3::new(-5.0, 0.0, 5.0)];
    let floor = Mesh {
        moved: None,
        name: "floor".to_owned(),
        positions: corners.to_vec(),
        triangles: vec![[0, 2, 1], [0, 3, 2]],
        normals: None,
        uv: None,
        surface: 0,
    };
    // One unit above, facing down.
    let down = Mat4::from_cols(Vec4::X, Vec4::Z, -Vec4::NEG_Y, Vec4::new(0.3, 1.0, 0.2, 1.0));
    let scene = Scene {
        meshes: vec![floor],
        surfaces: vec![Surface::diffuse("grey", [0.5, 0.4, 0.3])],
        lights: vec![LightShape::Rect { to_world: down, radiance: [2.0, 3.0, 4.0], texture: None }.into()],
        camera: Some(Camera::look_at(Vec3::new(0.0, 0.9, 3.0), Vec3::ZERO, Vec3::Y, 0.002, 1.0)),
        ..Scene::default()
    };
    let world = World::new(scene).unwrap();
    let film = render(&world, &settings(4, Mode::Near), 4096);
    let n = 400;
    let mut integral = 0.0f64;
    for i in 0..n * n {
        let (x, z) = ((i % n) as f64 / n as f64 - 0.5 + 0.3, (i / n) as f64 / n as f64 - 0.5 + 0.2);
        integral += 1.0 / (x * x + z * z + 1.0).powi(2) / (n * n) as f64;
    }
    for c in 0..3 {
        let expected = [0.5, 0.4, 0.3][c] / std::f64::consts::PI * [2.0, 3.0, 4.0][c] * integral;
        let seen = mean(&film, Layer::Beauty, c);
        assert!((seen / expected - 1.0).abs() < 0.01, "channel {c}: {seen} {expected}");
    }
}

/// A picture with motion blur is the mean of static pictures. Strands, a mesh and the camera move, each differently.
#[test]
fn motion_blur_is_the_mean_of_moments() {
    let mut scene = clump(60, 0.02, fiber());
    let way = |i: usize| 0.3 * Vec3::new(noise(i / 6, 31), noise(i / 6, 32), 0.1 * noise(i, 33));
    let moved: Vec<Vec3> = scene.strands[0].points.iter().enumerate().map(|(i, p)| p.truncate() + way(i)).collect();
    scene.strands[0].moved = Some(moved);
    let plate = vec![Vec3::new(-0.5, -0.5, -0.3), Vec3::new(0.1, -0.5, -0.3), Vec3::new(-0.2, 0.1, -0.3)];
    scene.meshes.push(Mesh {
        name: "plate".to_owned(),
        moved: Some(plate.iter().map(|p| p + Vec3::new(0.3, 0.2, 0.0)).collect()),
        positions: plate,
        triangles: vec![[0, 1, 2]],
        normals: None,
        uv: None,
        surface: 0,
    });
    scene.surfaces.push(Surface::diffuse("plate", [0.7, 0.4, 0.2]));
    let camera = scene.camera.as_mut().unwrap();
    camera.moved = Some(Mat4::from_translation(Vec3::new(0.15, 0.0, 0.0)) * camera.to_world);
    const MOMENTS: usize = 24;
    let settings = settings(24, Mode::MultiScale);
    let blurred = render(&World::new(scene.clone()).unwrap(), &settings, 16 * MOMENTS as u64);
    let mut moments = Film::new([24; 2], [0, 0, 24, 24], World::new(scene.clone()).unwrap().layout(&Layer::ALL));
    for k in 0..MOMENTS {
        let time = (k as f32 + 0.5) / MOMENTS as f32;
        let mut still = scene.clone();
        let strands = &mut still.strands[0];
        for (p, moved) in strands.points.iter_mut().zip(strands.moved.take().unwrap()) {
            *p = p.truncate().lerp(moved, time).extend(p.w);
        }
        let mesh = &mut still.meshes[0];
        for (p, moved) in mesh.positions.iter_mut().zip(mesh.moved.take().unwrap()) {
            *p = p.lerp(moved, time);
        }
        let camera = still.camera.as_mut().unwrap();
        camera.to_world = Mat4::from_translation(Vec3::new(0.15 * time, 0.0, 0.0)) * camera.to_world;
        camera.moved = None;
        // With the same random numbers at each moment, the error of the mean would be larger than its estimate.
        let settings = Settings { seed: 2 + k as u32, ..settings };
        moments.merge(&render(&World::new(still).unwrap(), &settings, 16));
    }
    // The tolerance for blocks of 4 × 4 pixels is the noise, plus 0.004, because 24 moments sample the path of an edge
    // coarsely.
    let bound = max_abs_z(36, 0.01);
    let mut worst = 0f64;
    for block in 0..36 {
        let pixels = || (0..16).map(|i| (block % 6 * 4 + i % 4, block / 6 * 4 + i / 4));
        let sum =
            |film: &Film, layer: Layer, c: usize| pixels().map(|(x, y)| film.mean(x, y, layer, c)).sum::<f64>() / 16.0;
        let error = |film: &Film| pixels().map(|(x, y)| film.error(x, y).powi(2)).sum::<f64>().sqrt() / 16.0;
        let expected = bound * error(&blurred).hypot(error(&moments)) + 0.004;
        let light =
            (0..3).map(|c| sum(&blurred, Layer::Beauty, c) - sum(&moments, Layer::Beauty, c)).sum::<f64>().abs() / 3.0;
        let cover = (sum(&blurred, Layer::Alpha, 0) - sum(&moments, Layer::Alpha, 0)).abs();
        worst = worst.max(light / expected);
        assert!(light < expected && cover < 0.03, "block {block}: {light} of {expected}, cover {cover}");
    }
    println!("worst: {worst:.2} of the tolerance");
}

/// The motion layer of a wall that moves to the right and up has the number of pixels that the lens implies.
#[test]
fn motion_is_in_pixels() {
    let mut scene = clump(1, 0.001, fiber());
    scene.camera = Some(Camera::look_at(3.0 * Vec3::Z, Vec3::ZERO, Vec3::Y, 0.3, 1.0));
    let wall = vec![Vec3::new(-9.0, -9.0, 1.0), Vec3::new(9.0, -9.0, 1.0), Vec3::new(0.0, 9.0, 1.0)];
    scene.meshes.push(Mesh {
        name: "wall".to_owned(),
        moved: Some(wall.iter().map(|p| p + Vec3::new(0.03, 0.01, 0.0)).collect()),
        positions: wall,
        triangles: vec![[0, 1, 2]],
        normals: None,
        uv: None,
        surface: 0,
    });
    scene.surfaces.push(Surface::diffuse("wall", [0.5; 3]));
    let film = render(&World::new(scene).unwrap(), &settings(16, Mode::Near), 4);
    // At a distance of two units, 16 pixels cover 4 tan 0.15.
    let pixels = 16.0 / (4.0 * 0.15f64.tan());
    for (k, way) in [(0, 0.03), (1, 0.01)] {
        assert!((film.mean(8, 8, Layer::Motion, k) - way * pixels).abs() < 1e-4, "{k}");
    }
}
