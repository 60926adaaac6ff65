//! The path tracer on a GPU against that of the processor. Mesa's lavapipe is enough.

use crate::common::device;
use glam::{Mat4, Quat, Vec3};
use std::sync::{Arc, Mutex};
use vellus::{Bcsdf, Parameter};
use vellus_gpu::Tracer;
use vellus_render::packed::{Lacking, SampleTracer};
use vellus_render::session::Options;
use vellus_render::{Checkpoint, Error, Film, Layer, Mode, Session, Settings, World};
use vellus_scene::{
    Light, LightShape, Link, NormalMap, Objects, Opacity, Profile, Scene, Shaping, Texture, Values, Wrap,
};
use vellus_testing::significance::max_abs_z;

fn settings(size: [usize; 2]) -> Settings {
    Settings { mode: Mode::Near, ..Settings::new(size) }
}

fn built_in(name: &str) -> Scene {
    vellus_groom::scene(name, true).unwrap_or_else(|| panic!("{name} is a built-in scene"))
}

/// A built-in scene whose lamps have profiles, and whose focus leaves a tint.
fn with_profiles(name: &str) -> Scene {
    let mut scene = built_in(name);
    let pixels = (0..12).map(|i| [1.0 + (7 * i % 5) as f32; 3]).collect();
    let profile = Profile { texture: scene.textures.len(), side: Vec3::new(0.3, -0.4, 0.8) };
    scene.textures.push(Texture { name: "lamp".to_owned(), width: 4, height: 3, pixels, wrap: Default::default() });
    let shaping =
        |axis| Shaping { axis, cone: 1.5, softness: 0.5, focus: 4.0, tint: [0.2, 0.4, 0.1], profile: Some(profile) };
    for light in &mut scene.lights {
        light.shaping = match light.shape {
            LightShape::Rect { to_world, .. } => Some(shaping(-to_world.z_axis.truncate())),
            LightShape::Sphere { center, .. } => Some(shaping(-center)),
            _ => None,
        };
    }
    assert!(scene.lights.iter().any(|light| light.shaping.is_some()), "{name} has no lamp");
    scene
}

/// A built-in scene with lights that light some things only, lack shadows of some things, and have gains.
fn with_links(name: &str) -> Scene {
    let mut scene = built_in(name);
    let fur: Vec<String> = scene.strands.iter().map(|strands| strands.name.clone()).collect();
    let meshes: Vec<String> = scene.meshes.iter().map(|mesh| mesh.name.clone()).collect();
    assert!(!fur.is_empty() && !meshes.is_empty(), "{name} has fur and meshes");
    let link = |lit, casters, [diffuse, specular]: [f32; 2]| Some(Link { lit, casters, diffuse, specular });
    let shape = |k: usize| -> LightShape { scene.lights[k % scene.lights.len()].shape.clone() };
    let sun = LightShape::Distant { direction: Vec3::new(0.4, 0.8, 0.4), half_angle: 0.1, irradiance: [1.0; 3] };
    let sky = LightShape::Dome { radiance: [0.3; 3], texture: None, rotation: glam::Mat3::IDENTITY, ground: None };
    let lights = [
        (shape(0), link(Objects::Only(fur.clone()), Objects::ALL, [1.0; 2])),
        (shape(1), link(Objects::ALL, Objects::Except(fur.clone()), [1.0; 2])),
        (sun, link(Objects::ALL, Objects::Only(meshes), [0.4, 1.5])),
        (sky, link(Objects::ALL, Objects::Except(fur), [1.3, 0.6])),
    ];
    scene.lights = lights.into_iter().map(|(shape, link)| Light { link, ..shape.into() }).collect();
    scene
}

/// A built-in scene whose meshes have holes and normals by images.
fn with_details(name: &str) -> Scene {
    let mut scene = built_in(name);
    let pixels = (0..64).map(|i| [(5 * i % 11) as f32 / 10.0, (3 * i % 7) as f32 / 6.0, 1.0]).collect();
    let (texture, wrap) = (scene.textures.len(), [Wrap::Repeat; 2]);
    scene.textures.push(Texture { name: "bumps".to_owned(), width: 8, height: 8, pixels, wrap });
    for (surface, threshold) in scene.surfaces.iter_mut().zip([0.0, 0.4].into_iter().cycle()) {
        surface.opacity = Opacity { value: 0.9, texture: Some(texture), threshold };
        surface.normals = Some(NormalMap { texture, scale: [2.0, 2.0, 1.0], bias: [-1.0, -1.0, 0.0] });
    }
    for mesh in &mut scene.meshes {
        let size = mesh.positions.iter().fold(0.0f32, |size, p| size.max(p.abs().max_element()));
        let uv = |v: u32| 8.0 / size * glam::Vec2::new(mesh.positions[v as usize].x, mesh.positions[v as usize].z);
        mesh.uv = Some(mesh.triangles.iter().map(|corners| corners.map(uv)).collect());
    }
    scene
}

/// A built-in scene in which strands, meshes and the camera move, each in its own way.
fn with_motion(name: &str) -> Scene {
    let mut scene = built_in(name);
    let (low, high) = scene.bounds().unwrap_or_else(|| panic!("{name} is empty"));
    let (middle, size) = (0.5 * (low + high), (high - low).length());
    let moved = |p: Vec3, angle: f32, by: Vec3| middle + Quat::from_rotation_y(angle) * (p - middle) + size * by;
    for strands in &mut scene.strands {
        let by = Vec3::new(0.05, -0.02, 0.03);
        strands.moved = Some(strands.points.iter().map(|p| moved(p.truncate(), 0.2, by)).collect());
    }
    for mesh in &mut scene.meshes {
        mesh.moved = Some(mesh.positions.iter().map(|p| moved(*p, -0.1, Vec3::new(0.0, -0.03, 0.02))).collect());
    }
    let camera = scene.camera.as_mut().unwrap_or_else(|| panic!("{name} has no camera"));
    let turn = Mat4::from_rotation_z(0.06) * Mat4::from_rotation_x(0.03);
    camera.moved = Some(Mat4::from_translation(size * Vec3::new(0.02, 0.03, -0.05)) * camera.to_world * turn);
    scene
}

/// The mean of a channel over a picture.
fn mean(film: &Film, layer: Layer, channel: usize) -> f64 {
    let [_, _, width, height] = film.area();
    let pixels = (0..width * height).map(|i| film.mean(i % width, i / width, layer, channel));
    pixels.sum::<f64>() / (width * height) as f64
}

/// The mean brightness of a picture, and its standard error: the variance of the samples of each pixel, as if they were
/// independent. They are stratified, so the error is smaller.
fn brightness(film: &Film) -> [f64; 2] {
    let [_, _, width, height] = film.area();
    let (mut sum, mut variance) = (0.0, 0.0);
    for i in 0..width * height {
        let value = |layer, c| film.mean(i % width, i / width, layer, c);
        let mean = (0..3).map(|c| value(Layer::Beauty, c)).sum::<f64>() / 3.0;
        sum += mean;
        variance += (value(Layer::SecondMoment, 0) - mean * mean).max(0.0) / film.samples() as f64;
    }
    let pixels = (width * height) as f64;
    [sum / pixels, variance.sqrt() / pixels]
}

/// The means of fourteen pictures agree. The false-alarm rate is 1 % over all scenes together.
#[test]
#[ignore = "full: a software GPU compiles the tracer in a minute, and needs 50 times as long as the processor"]
fn pictures_agree_with_those_of_the_processor() -> Result<(), Box<dyn std::error::Error>> {
    let Some(device) = device() else { return Ok(()) };
    let all = "hamster raccoon polar-bear cat hair-lock hair-bob lamps links details motion motion-bob \
               multiscale multiscale-lock far";
    let names: Vec<&str> = all.split(' ').collect();
    use Layer::{Albedo, Alpha, Depth, Fibers, Lobes, Motion, Normal, RootUv, Strand, Tangent};
    let layers = [Depth, Lobes, Albedo, Normal, Tangent, Strand, RootUv, Motion];
    let mut scores = Vec::new();
    for &name in &names {
        let scene = match name {
            "lamps" => with_profiles("hair-lock"),
            "links" => with_links("raccoon"),
            "details" => with_details("raccoon"),
            "multiscale" | "far" => built_in("raccoon"),
            "multiscale-lock" => built_in("hair-lock"),
            "motion" => with_motion("raccoon"),
            "motion-bob" => with_motion("hair-bob"),
            _ => built_in(name),
        };
        let world = World::with_model(scene, Bcsdf::new)?;
        // The raccoon's fur has more fibres than there may be tables.
        let mode = match name.split('-').next() {
            Some("multiscale") => Mode::MultiScale,
            Some("far") => Mode::Far,
            _ => Mode::Near,
        };
        let settings = Settings { mode, ..settings([48, 32]) };
        let layout = world.layout(&layers);
        let film = || Film::new(settings.size, settings.area(), layout.clone());
        let (mut ours, mut expected) = (film(), film());
        let mut tracer = Tracer::new(&device, &world, &settings, &layout)?;
        let gpu = world.render_packed(&settings, &mut ours, 0..32, &(), &mut tracer)?;
        let cpu = world.render(&settings, &mut expected, 0..128, &())?;
        assert_eq!((gpu.rejected, cpu.rejected), (0, 0));
        let ([a, error_a], [b, error_b]) = (brightness(&ours), brightness(&expected));
        let score = (a - b) / error_a.hypot(error_b);
        println!("{name}: GPU {a:.4}, processor {b:.4}, z = {score:.2}, noise {error_a:.5} {error_b:.5}");
        scores.push(score);
        // Lobes of fibres that the camera sees add up to the fibres' part of the beauty, on both devices.
        let lobes = |film: &Film| (0..18).map(|c| mean(film, Layer::Lobes, c)).sum::<f64>() / 3.0;
        let (lobes_a, lobes_b) = (lobes(&ours), lobes(&expected));
        assert!((lobes_a - lobes_b).abs() < 5.0 * error_a.hypot(error_b), "{name}: lobes {lobes_a} {lobes_b}");
        // Other layers depend on camera rays alone. 1,536 pixels with stratified samples resolve 1 % of the picture.
        for layer in [Alpha, Fibers, Albedo, Normal, Tangent, RootUv] {
            for c in 0..layer.channels() {
                let (a, b) = (mean(&ours, layer, c), mean(&expected, layer, c));
                assert!((a - b).abs() < 0.01, "{name}: {layer:?} {c}: {a} {b}");
            }
        }
        // Depth and motion jump from fur to what is behind. The pixels' own differences tell how much that matters.
        for (layer, c) in [(Depth, 0), (Motion, 0), (Motion, 1)] {
            let difference = |i: usize| {
                let [a, b] = [&ours, &expected].map(|film| film.mean(i % 48, i / 48, layer, c));
                a - b
            };
            let (sum, square) =
                (0..48 * 32).map(difference).fold((0.0, 0.0), |(sum, square), d| (sum + d, square + d * d));
            assert!(sum.abs() <= 4.0 * square.sqrt(), "{name}: {layer:?} {c}: {sum} of {square}");
            let all = mean(&expected, layer, c).abs() * 48.0 * 32.0;
            let shows = layer == Depth || name.starts_with("motion");
            assert!(!shows || 20.0 * square.sqrt() < all, "{name}: {layer:?} {c}: the test is too weak");
        }
        let rays = |statistics: vellus_render::Statistics, samples: f64| statistics.rays as f64 / samples;
        let (a, b) = (rays(gpu, 32.0), rays(cpu, 128.0));
        assert!((a / b - 1.0).abs() < 0.05, "{name}: {a} and {b} rays");
    }
    let limit = max_abs_z(names.len(), 0.01);
    assert!(scores.iter().all(|score| score.abs() < limit), "{scores:?}, limit {limit}");
    Ok(())
}

/// The far field from tables, at every hit and in multi-scale pictures, on both devices. Multi-scale pictures then have
/// the noise of the processor: 0.0008 with 32 samples. That of the near field is 0.0011. The false-alarm rate is 1 %.
#[test]
#[ignore = "full: a software GPU compiles the tracer in a minute"]
fn far_fields_agree_with_those_of_the_processor() -> Result<(), Box<dyn std::error::Error>> {
    let Some(device) = device() else { return Ok(()) };
    let mut scores = Vec::new();
    for (name, mode) in [("raccoon", Mode::Far), ("hair-lock", Mode::Far), ("hair-lock", Mode::MultiScale)] {
        let mut scene = built_in(name);
        // A fibre that varies would need a table for each of its values.
        scene.strands.iter_mut().for_each(|strands| strands.varying.clear());
        scene.looks.iter_mut().for_each(|look| look.textured.clear());
        let world = World::with_model(scene, Bcsdf::new)?;
        let settings = Settings { mode, ..settings([48, 32]) };
        let layout = world.layout(&[Layer::Lobes, Layer::Albedo]);
        let film = || Film::new(settings.size, settings.area(), layout.clone());
        let (mut ours, mut expected) = (film(), film());
        let mut tracer = Tracer::new(&device, &world, &settings, &layout)?;
        world.render_packed(&settings, &mut ours, 0..32, &(), &mut tracer)?;
        world.render(&settings, &mut expected, 0..128, &())?;
        let ([a, error_a], [b, error_b]) = (brightness(&ours), brightness(&expected));
        let score = (a - b) / error_a.hypot(error_b);
        println!("{name}, {mode:?}: GPU {a:.4}, processor {b:.4}, z = {score:.2}, noise {error_a:.5} {error_b:.5}");
        scores.push(score);
        for lobe in 0..6 {
            let [a, b] = [&ours, &expected].map(|f| (0..3).map(|c| mean(f, Layer::Lobes, 3 * lobe + c)).sum::<f64>());
            println!("    lobe {lobe}: GPU {a:.4}, processor {b:.4}");
            // The sum of three channels of one lobe varies at most three times as much as the mean of the whole light.
            assert!((a - b).abs() < 5.0 * 3.0 * error_a.hypot(error_b), "{name}: lobe {lobe}: {a} {b}");
        }
    }
    let limit = max_abs_z(scores.len(), 0.01);
    assert!(scores.iter().all(|score| score.abs() < limit), "{scores:?}, limit {limit}");
    Ok(())
}

/// The book's list is that of the code.
#[test]
fn generated_list_of_what_a_gpu_lacks() {
    let mut table = "| not on a GPU | option or parameter |\n|---|---|\n".to_owned();
    for [name, option] in Lacking::ALL.map(Lacking::names) {
        let option = if option.contains(' ') { option.to_owned() } else { format!("`{option}`") };
        table += &format!("| {name} | {option} |\n");
    }
    vellus_testing::generated::part("docs/book/src/rendering.md", "gpu", &table);
}

/// Colours that vary along the strands: dark tips. The processor interpolates the reflectance between two control
/// points, and the GPU draws one of the two. The false-alarm rate is 1 %.
#[test]
#[ignore = "full: a software GPU compiles the tracer in a minute"]
fn colors_along_strands_agree_with_those_of_the_processor() -> Result<(), Box<dyn std::error::Error>> {
    let Some(device) = device() else { return Ok(()) };
    let mut scores = Vec::new();
    for name in ["hamster", "hair-lock"] {
        let mut scene = built_in(name);
        for strands in &mut scene.strands {
            let mut values = vec![[0.0; 3]; strands.points.len()];
            for ends in strands.starts.windows(2) {
                let (first, last) = (ends[0] as usize, ends[1] as usize);
                for point in first..last {
                    let t = (point - first) as f32 / (last - first - 1) as f32;
                    values[point] = [0.8 - 0.7 * t, 0.6 - 0.5 * t, 0.4 - 0.35 * t];
                }
            }
            strands.varying = vec![(Parameter::Reflectance, Values::PerPoint(values))];
        }
        let world = World::with_model(scene, Bcsdf::new)?;
        let settings = settings([48, 32]);
        let layout = world.layout(&[]);
        let film = || Film::new(settings.size, settings.area(), layout.clone());
        let (mut ours, mut expected) = (film(), film());
        let mut tracer = Tracer::new(&device, &world, &settings, &layout)?;
        world.render_packed(&settings, &mut ours, 0..32, &(), &mut tracer)?;
        world.render(&settings, &mut expected, 0..128, &())?;
        let ([a, error_a], [b, error_b]) = (brightness(&ours), brightness(&expected));
        let score = (a - b) / error_a.hypot(error_b);
        println!("{name}: GPU {a:.4}, processor {b:.4}, z = {score:.2}");
        scores.push(score);
    }
    let limit = max_abs_z(scores.len(), 0.01);
    assert!(scores.iter().all(|score| score.abs() < limit), "{scores:?}, limit {limit}");
    Ok(())
}

/// A tracer that several sessions share.
#[derive(Clone, Debug)]
struct Shared(Arc<Mutex<Tracer>>);

impl SampleTracer for Shared {
    fn samples_at_once(&self) -> usize {
        self.0.lock().map_or(1, |tracer| tracer.samples_at_once())
    }

    fn trace(&mut self, samples: &[[u32; 2]]) -> Result<Vec<u32>, Error> {
        let mut tracer = self.0.lock().map_err(|_| Error::Device("the lock is broken".to_owned()))?;
        tracer.trace(samples)
    }
}

/// A picture changes its device with each of 100 samples, and is resumed from the bytes of a checkpoint each time. It
/// has the bits of the same samples, merged. A device that is lost then leaves the samples.
#[test]
#[ignore = "full: a software GPU compiles the tracer in a minute"]
fn a_picture_changes_its_device_a_hundred_times() -> Result<(), Box<dyn std::error::Error>> {
    let Some(device) = device() else { return Ok(()) };
    let world = World::with_model(built_in("hamster"), Bcsdf::new)?;
    let settings = Settings::new([24, 16]);
    let layers = [Layer::Depth, Layer::Strand, Layer::CryptoLook];
    let layout = world.layout(&layers);
    let tracer = Shared(Arc::new(Mutex::new(Tracer::new(&device, &world, &settings, &layout)?)));
    let options = |samples| Options { layers: layers.to_vec(), ..Options::new(settings, samples) };
    let new_film = || Film::new(settings.size, settings.area(), layout.clone());
    let (mut merged, mut kept): (Film, Option<Vec<u8>>) = (new_film(), None);
    for sample in 0..100 {
        let mut session = Session::new(&world, options(sample + 1))?;
        if let Some(bytes) = kept {
            session.resume(Checkpoint::from_bytes(&bytes)?)?;
        }
        let mut alone = new_film();
        if sample % 2 == 0 {
            session.set_tracer(Box::new(tracer.clone()));
            world.render_packed(&settings, &mut alone, sample..sample + 1, &(), &mut tracer.clone())?;
        } else {
            world.render(&settings, &mut alone, sample..sample + 1, &())?;
        }
        session.run(&(), |_| Ok::<(), Error>(()))?;
        merged.merge(&alone);
        assert!(*session.film() == merged, "sample {sample}");
        kept = Some(session.checkpoint().to_bytes());
    }
    device.destroy();
    let mut session = Session::new(&world, options(200))?;
    session.set_tracer(Box::new(tracer));
    session.resume(Checkpoint::from_bytes(&kept.unwrap_or_default())?)?;
    let lost = session.run(&(), |_| Ok::<(), Error>(()));
    assert!(matches!(lost, Err(Error::Device(_))) && *session.film() == merged, "{lost:?}");
    Ok(())
}

/// White fur in a white furnace is as bright as the furnace, within half a per cent.
#[test]
#[ignore = "full: a software GPU compiles the tracer in a minute"]
fn white_fur_loses_nothing() -> Result<(), Box<dyn std::error::Error>> {
    let Some(device) = device() else { return Ok(()) };
    let mut scene = built_in("hamster");
    scene.meshes.clear();
    scene.background = None;
    let white = LightShape::Dome { radiance: [1.0; 3], texture: None, rotation: glam::Mat3::IDENTITY, ground: None };
    scene.lights = vec![white.into()];
    scene.strands.iter_mut().for_each(|strands| strands.varying.clear());
    for look in &mut scene.looks {
        look.fiber = look.fiber.without_absorption();
        look.textured.clear();
    }
    let world = World::with_model(scene, Bcsdf::new)?;
    let settings = settings([48, 32]);
    let layout = world.layout(&[]);
    let mut film = Film::new(settings.size, settings.area(), layout.clone());
    let mut tracer = Tracer::new(&device, &world, &settings, &layout)?;
    world.render_packed(&settings, &mut film, 0..16, &(), &mut tracer)?;
    assert!(mean(&film, Layer::Fibers, 0) > 0.1);
    for c in 0..3 {
        let brightness = mean(&film, Layer::Beauty, c);
        println!("channel {c}: {brightness:.5}");
        assert!((brightness - 1.0).abs() < 5e-3, "{brightness}");
    }
    Ok(())
}
