//! Measures whether an animation with a radiance cache, or with level of detail, flickers.
//!
//! `cargo run --release --bin flicker -- [WIDTH [FILL [SAMPLES [SCENE...]]]]`
//!
//! Three moves: a zoom by 8 in 13 steps, a turn by 6° in 24 frames, and a sun as the only light that moves from above
//! the camera to the side, in 24 frames. Each is rendered without a cache (`plain`), with a cache of its own for each
//! frame (`own`), and for moves of the camera with caches that frames share (`shared`, see `vellus_render::Shot`). FILL
//! is the number of samples of each pixel that fill the cache of a frame. All frames have the same seed, as those of
//! `vellus render`. With `lod` for FILL, frames have level of detail instead of a cache.
//!
//! `jump` is the largest difference between the frame-to-frame changes of the mean brightness with a cache and those
//! without, in per cent of the brightness; `±` is the largest standard error of such a difference, without the noise
//! of the cache. `error` is the mean square error of the fur in the last frame, relative to its brightness, beside
//! full paths with 4 times the samples. `fill` is the processor time of filling the cache of a frame after the first,
//! and `all` that of the whole frame, in seconds. `blocks` are squares of 8 × 8 pixels of the turn: the root mean
//! square of their second difference over frames, divided by √6, in per cent of the picture's brightness. That is the
//! noise of one block in one frame, with what the turn itself changes.

use glam::{Mat4, Vec3};
use std::error::Error;
use std::f32::consts::FRAC_PI_2;
use vellus_groom::scene;
use vellus_render::session::{Options, Session};
use vellus_render::{Film, Layer, Lod, Settings, Shot, World, simplify};
use vellus_scene::{Camera, Light, LightShape, Scene};

/// The side of a block, in pixels.
const BLOCK: usize = 8;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize, default: u64| arguments.get(k).map_or(Ok(default), |text| text.parse());
    let is_lod = arguments.get(1).is_some_and(|text| text == "lod");
    let fill = if is_lod { None } else { Some(number(1, 16)? as u32) };
    let (width, samples) = (number(0, 144)? as usize, number(2, 64)?);
    let names: Vec<&str> = match arguments.get(3..) {
        Some(names) if !names.is_empty() => names.iter().map(String::as_str).collect(),
        _ => vec!["hamster", "polar-bear", "raccoon"],
    };
    println!("scene          move  cache    jump      ±      error    fill     all blocks");
    for name in names {
        measure(name, [width, width * 2 / 3], fill, samples)?;
    }
    Ok(())
}

/// Moves the camera or the light to a part of a move, in [0, 1].
type Move<'a> = &'a dyn Fn(&mut World, f32) -> Result<(), vellus_scene::Error>;

/// The brightness of blocks, of the picture, and the standard error of the latter.
struct Frame {
    blocks: Vec<f64>,
    mean: f64,
    error: f64,
}

fn frame(film: &Film) -> Frame {
    let (width, height) = (film.width() / BLOCK, film.height() / BLOCK);
    let mut blocks = vec![0.0; width * height];
    let mut variance = 0.0;
    for y in 0..height * BLOCK {
        for x in 0..width * BLOCK {
            let sum: f64 = (0..3).map(|c| film.mean(x, y, Layer::Beauty, c)).sum();
            blocks[y / BLOCK * width + x / BLOCK] += sum / (3 * BLOCK * BLOCK) as f64;
            variance += film.error(x, y).powi(2);
        }
    }
    let count = blocks.len() as f64;
    let mean = blocks.iter().sum::<f64>() / count;
    let pixels = count * (BLOCK * BLOCK) as f64;
    Frame { blocks, mean, error: variance.sqrt() / pixels }
}

/// The camera at part `t` of a move around the point it looks at.
fn zoomed(camera: Camera, t: f32) -> Camera {
    let mut camera = camera;
    camera.film_height *= 8f32.powf(-t);
    camera
}

fn turned(camera: Camera, target: Vec3, t: f32) -> Camera {
    let up = camera.to_world.y_axis.truncate();
    let turn = Mat4::from_axis_angle(up.normalize(), (6.0 * t).to_radians());
    let about = Mat4::from_translation(target) * turn * Mat4::from_translation(-target);
    Camera { to_world: about * camera.to_world, ..camera }
}

/// A sun, half as high as it is far, and dark lights: as many as the scene has.
fn sun(camera: Camera, t: f32, count: usize) -> Vec<Light> {
    let [right, up, away] = [camera.to_world.x_axis, camera.to_world.y_axis, camera.to_world.z_axis];
    let (sin, cos) = (FRAC_PI_2 * t).sin_cos();
    let direction = (sin * right + 0.5 * up + cos * away).truncate().normalize();
    let light = |k| {
        let irradiance = if k == 0 { [3.0; 3] } else { [0.0; 3] };
        LightShape::Distant { direction, half_angle: 0.0047, irradiance }.into()
    };
    (0..count).map(light).collect()
}

/// What the frames of a move have.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Plain,
    Lod,
    /// A cache with this many samples of each pixel.
    Own(u32),
    Shared(u32),
}

/// The frames of a move.
struct Frames {
    all: Vec<Frame>,
    last: Film,
    /// Processor time of filling the caches after the first frame, and of these frames, in seconds each.
    times: [f64; 2],
}

/// `fill` is the number of samples in the cache. `None` measures level of detail.
fn measure(name: &str, size: [usize; 2], fill: Option<u32>, samples: u64) -> Result<(), Box<dyn Error>> {
    let scene = scene(name, false).ok_or_else(|| format!("there is no scene {name}"))?;
    let camera = scene.camera.ok_or("the scene has no camera")?;
    let (low, high) = scene.bounds().ok_or("the scene is empty")?;
    let target = 0.5 * (low + high);
    let mut full = World::new(scene.clone())?;
    let now = || vellus_io::cpu_time().unwrap_or_default().as_secs_f64();
    let mut frames = |count: usize, kind: Kind, place: Move<'_>| -> Result<Frames, Box<dyn Error>> {
        let (mut all, mut last, mut times) = (Vec::new(), None, [0.0; 2]);
        let mut shot = Shot::default();
        for k in 0..count {
            let t = k as f32 / (count - 1) as f32;
            place(&mut full, t)?;
            let mut fewer = None;
            if kind == Kind::Lod {
                let mut scene = Scene { camera: Some(full.camera()), ..scene.clone() };
                simplify(&mut scene, size, Lod::AUTO);
                let mut world = World::new(scene)?;
                place(&mut world, t)?;
                fewer = Some(world);
            }
            let world = fewer.as_ref().unwrap_or(&full);
            let radiance_cache = match kind {
                Kind::Own(fill) | Kind::Shared(fill) => Some(fill),
                Kind::Plain | Kind::Lod => None,
            };
            let settings = Settings { seed: 1, radiance_cache, ..Settings::new(size) };
            let options = Options { layers: vec![Layer::Beauty, Layer::Fibers], ..Options::new(settings, samples) };
            let mut session = Session::new(world, options)?;
            if let Kind::Shared(_) = kind {
                session.set_shot(shot.clone());
            }
            let start = now();
            session.fill_cache(&(), &mut |_| {})?;
            let filled = now();
            session.run(&(), |_| Ok::<(), vellus_render::Error>(()))?;
            if k > 0 {
                times[0] += (filled - start) / (count - 1) as f64;
                times[1] += (now() - start) / (count - 1) as f64;
            }
            shot.frame += 1;
            shot.earlier.insert(0, world.camera());
            all.push(frame(session.film()));
            last = Some(session.into_checkpoint().film);
        }
        Ok(Frames { all, last: last.ok_or("no frames")?, times })
    };
    let moves: [(&str, usize, Move<'_>); 3] = [
        ("zoom", 13, &|world, t| world.set_camera(zoomed(camera, t))),
        ("turn", 24, &|world, t| world.set_camera(turned(camera, target, t))),
        ("light", 24, &|world, t| {
            world.set_camera(camera)?;
            world.set_lights(&sun(camera, t, scene.lights.len()))
        }),
    ];
    for (what, count, place) in moves {
        let plain = frames(count, Kind::Plain, place)?;
        let mut world = World::new(scene.clone())?;
        place(&mut world, 1.0)?;
        let settings = Settings { seed: 2, ..Settings::new(size) };
        let mut truth = Film::new(size, settings.area(), plain.last.layout().clone());
        world.render(&settings, &mut truth, 0..4 * samples, &())?;
        let kinds = match fill {
            None => vec![("lod", Kind::Lod)],
            Some(fill) if what == "light" => vec![("own", Kind::Own(fill))],
            Some(fill) => vec![("own", Kind::Own(fill)), ("shared", Kind::Shared(fill))],
        };
        show(name, what, "plain", &plain, &plain, &truth);
        for (kind, of) in kinds {
            show(name, what, kind, &frames(count, of, place)?, &plain, &truth);
        }
    }
    Ok(())
}

/// Prints a line of the table.
fn show(name: &str, what: &str, kind: &str, frames: &Frames, plain: &Frames, truth: &Film) {
    let (all, without) = (&frames.all, &plain.all);
    let change = |frames: &[Frame], k: usize| frames[k + 1].mean / frames[k].mean - 1.0;
    let between = 0..all.len() - 1;
    let jump = between.clone().map(|k| (change(all, k) - change(without, k)).abs()).fold(0.0, f64::max);
    let unsure = |k: usize| {
        let all = [&without[k], &without[k + 1], &all[k], &all[k + 1]];
        all.iter().map(|frame| (frame.error / frame.mean).powi(2)).sum::<f64>().sqrt()
    };
    let unsure = between.map(unsure).fold(0.0, f64::max);
    let [fill, time] = frames.times;
    print!("{name:<14} {what:<5} {kind:<6} {:6.2} {:6.2} ", 100.0 * jump, 100.0 * unsure);
    print!("{:9.5} {fill:7.2} {time:7.2}", error(&frames.last, truth));
    if what == "turn" {
        print!(" {:6.2}", 100.0 * flicker(all));
    }
    println!();
}

/// The mean square error over the fur, relative to its brightness, without that of the other picture.
fn error(film: &Film, truth: &Film) -> f64 {
    let pixels = (0..film.height()).flat_map(|y| (0..film.width()).map(move |x| (x, y)));
    let (mut square, mut light, mut count) = (0.0, 0.0, 0.0);
    for (x, y) in pixels.filter(|&(x, y)| truth.mean(x, y, Layer::Fibers, 0) > 0.5) {
        let [own, other] = [film, truth].map(|film| [0, 1, 2].map(|c| film.mean(x, y, Layer::Beauty, c)));
        square += own.iter().zip(other).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / 3.0;
        square -= truth.error(x, y).powi(2);
        light += other.iter().sum::<f64>() / 3.0;
        count += 1.0;
    }
    square / count / (light / count).powi(2)
}

/// The noise of a block in one frame, relative to the brightness of the picture.
fn flicker(frames: &[Frame]) -> f64 {
    let second = |w: &[Frame], b: usize| (w[0].blocks[b] - 2.0 * w[1].blocks[b] + w[2].blocks[b]).powi(2) / 6.0;
    let squares = frames.windows(3).flat_map(|w| (0..w[0].blocks.len()).map(move |b| second(w, b)));
    let count = (frames.len() - 2) * frames[0].blocks.len();
    (squares.sum::<f64>() / count as f64).sqrt() / frames[0].mean
}
