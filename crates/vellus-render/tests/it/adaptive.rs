//! Adaptive sampling: with a goal of noise, noisy parts of a picture get more samples.

use crate::common::{mean, noise, settings, world};
use glam::{Vec3, Vec4};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use vellus::{Fiber, Species};
use vellus_render::packed::SampleTracer;
use vellus_render::session::{End, Merge, Options};
use vellus_render::{Checkpoint, Error, Layer, Session, Settings, World};
use vellus_scene::{Basis, Camera, LightShape, Look, Scene, Strands};
use vellus_testing::significance::{FALSE_ALARM, max_abs_z};

/// One strand in the middle, and an even background around it.
const SIZE: [usize; 2] = [44, 36];

fn options(samples: u64) -> Options {
    let layers = vec![Layer::Beauty, Layer::Depth, Layer::CryptoObject];
    Options { layers, noise: Some(1e-9), ..Options::new(Settings { size: SIZE, ..settings() }, samples) }
}

fn finish(world: &World, options: Options) -> Checkpoint {
    let mut session = Session::new(world, options).unwrap();
    assert_eq!(session.run(&(), |_| Ok::<(), Error>(())).unwrap(), End::Samples);
    session.into_checkpoint()
}

#[test]
fn noisy_tiles_get_more_samples_and_the_picture_less_noise() {
    let world = world();
    let size = [88, 72];
    let options = Options { settings: Settings::new(size), ..options(128) };
    let film = finish(&world, options.clone()).film;
    let uniform = finish(&world, Options { noise: None, ..options }).film;
    assert!(film.is_adaptive() && !uniform.is_adaptive());
    // The corner has no noise: the least share of the planned samples. The edges of the strand have most noise.
    assert_eq!(film.samples_of(0, 0), 32);
    let most = (0..size[0]).map(|x| film.samples_of(x, 36)).max().unwrap_or(0);
    assert!(most > 256, "{most}");
    // Rates are rounded to 1/64 in each of three plans, and counts to whole samples.
    let total = film.total_samples() as f64 / uniform.total_samples() as f64;
    assert!((total - 1.0).abs() < 0.02, "{total}");
    // At the root of the share of the tiles with noise, if it were even there. It is not, so there is some room.
    let [adaptive, even] = [&film, &uniform].map(|film| film.noise().unwrap());
    assert!(adaptive < 0.75 * even, "{adaptive} {even}");
    let matte = film.values(Layer::CryptoObject).unwrap();
    let ranks = matte.len() / (size[0] * size[1]);
    // Both converge to the same picture: beyond 5 standard errors with a probability of 6e-7 a pixel.
    for (x, y) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))) {
        let [a, b] = [&film, &uniform].map(|film| film.mean(x, y, Layer::Beauty, 0));
        let error = film.error(x, y).hypot(uniform.error(x, y));
        // Pixels of few events have a poor estimate of their error.
        assert!((a - b).abs() < 5.0 * error + 0.02, "{x} {y}: {a} {b} {error}");
        let covered = film.mean(x, y, Layer::Alpha, 0);
        assert!((f64::from(matte[(y * size[0] + x) * ranks + 1]) - covered).abs() < 1e-6, "{x} {y}");
    }
}

/// How much brighter adaptive pictures of 32 samples are than uniform ones, as a share, over many seeds, and its
/// standard error. Both have the same samples before the first plan, so pairs differ less than independent pictures.
fn bias(world: &World, seeds: u32) -> [f64; 2] {
    let picture = |seed, noise| {
        let options = Options { noise, ..Options::new(Settings { seed, ..Settings::new(SIZE) }, 32) };
        mean(&finish(world, options).film, Layer::Beauty, 0)
    };
    let pairs: Vec<[f64; 2]> = (0..seeds).map(|seed| [Some(1e-9), None].map(|noise| picture(seed, noise))).collect();
    let n = f64::from(seeds);
    let uniform = pairs.iter().map(|pair| pair[1]).sum::<f64>() / n;
    let shares: Vec<f64> = pairs.iter().map(|pair| (pair[0] - pair[1]) / uniform).collect();
    let bias = shares.iter().sum::<f64>() / n;
    let variance = shares.iter().map(|x| (x - bias).powi(2)).sum::<f64>() / (n - 1.0);
    [bias, (variance / n).sqrt()]
}

#[test]
fn the_mean_is_kept() {
    let [bias, error] = bias(&world(), 32);
    // Student's t with 31 degrees of freedom: beyond 5 with a probability of 2e-5.
    assert!(bias.abs() < 5.0 * error, "{bias} ± {error}");
    assert!(error < 1e-3, "the test would notice a change of 1 %, 10 standard errors");
}

/// A lock of hair in the sun, which few paths between the strands find. The seeds are fixed; others would fail with a
/// probability of 0.001. A bias of 0.8 %, 10 standard errors, is noticed with a probability above 0.9999. Over 4,000
/// seeds the bias is 0.007 ± 0.016 %.
#[test]
#[ignore = "full: 600 pictures take 2.5 minutes of a processor"]
fn the_sun_keeps_its_mean() {
    let point = |i: usize, end: f32| {
        Vec4::new(0.5 * end + 0.1 * noise(i, 1), 0.3 * noise(i, 2) - 0.15, 0.3 * noise(i, 3), 0.008)
    };
    let strands = Strands {
        name: "lock".to_owned(),
        basis: Basis::Linear,
        starts: (0..=300).map(|i| 2 * i).collect(),
        points: (0..300).flat_map(|i| [point(2 * i, -1.0), point(2 * i + 1, 1.0)]).collect(),
        moved: None,
        normals: None,
        root_uv: None,
        look: 0,
        varying: vec![],
    };
    let sun = LightShape::Distant {
        direction: Vec3::new(0.3, 1.0, -0.5).normalize(),
        half_angle: 0.005,
        irradiance: [3.0; 3],
    };
    let world = World::new(Scene {
        strands: vec![strands],
        looks: vec![Look::constant("hair", Fiber::preset(Species::RedFox))],
        lights: vec![sun.into()],
        camera: Some(Camera::look_at(Vec3::Z * 3.0, Vec3::ZERO, Vec3::Y, 0.5, 1.0)),
        ..Scene::default()
    })
    .unwrap();
    let [bias, error] = bias(&world, 300);
    assert!(bias.abs() < max_abs_z(1, FALSE_ALARM) * error, "{bias} ± {error}");
    assert!(error < 8e-4, "the test would notice a change of 0.8 %: {error}");
}

#[test]
fn passes_and_interruptions_do_not_change_the_picture() {
    let world = world();
    let whole = finish(&world, options(80));
    let passes = finish(&world, Options { pass: Duration::ZERO, ..options(80) });
    assert_eq!(passes, whole);
    for stop_at in [3, 16, 17, 32, 50, 64] {
        let stop = AtomicBool::new(false);
        let mut session = Session::new(&world, Options { pass: Duration::ZERO, ..options(80) }).unwrap();
        let end = session.run(&stop, |pass| {
            stop.store(pass.state.samples >= stop_at, Ordering::Relaxed);
            Ok::<(), Error>(())
        });
        assert_eq!(end.unwrap(), End::Interrupted);
        let kept = Checkpoint::from_bytes(&session.into_checkpoint().to_bytes()).unwrap();
        assert_eq!(kept.film.samples(), stop_at);
        let mut session = Session::new(&world, options(80)).unwrap();
        session.resume(kept).unwrap();
        session.run(&(), |_| Ok::<(), Error>(())).unwrap();
        assert_eq!(*session.checkpoint(), whole, "{stop_at}");
    }
    // Without a goal of noise, an adaptive film goes on as it is.
    let mut session = Session::new(&world, Options { noise: None, ..options(80) }).unwrap();
    session.resume(finish(&world, options(40))).unwrap();
    session.run(&(), |_| Ok::<(), Error>(())).unwrap();
    assert_eq!(session.film(), &whole.film);
}

/// The noise is tested at fixed numbers of samples.
#[test]
fn the_end_does_not_depend_on_passes() {
    let world = world();
    let render = |pass| {
        let mut session = Session::new(&world, Options { noise: Some(0.005), pass, ..options(4096) }).unwrap();
        assert_eq!(session.run(&(), |_| Ok::<(), Error>(())).unwrap(), End::Noise);
        session.into_checkpoint()
    };
    let [short, long] = [Duration::ZERO, Duration::from_secs(9)].map(render);
    assert!(short.film.noise().unwrap() <= 0.005 && short.samples.end > 16);
    assert_eq!(short, long);
}

#[test]
fn ranges_are_not_adaptive() {
    let world = world();
    let exact = finish(&world, Options { exact: true, ..options(40) });
    let later = finish(&world, Options { samples: 8..40, ..options(40) });
    assert!(!exact.film.is_adaptive() && !later.film.is_adaptive());
    let adaptive = finish(&world, options(40));
    let mut exact = Session::new(&world, Options { exact: true, ..options(40) }).unwrap();
    let error = exact.resume(adaptive.clone()).unwrap_err();
    assert!(error.to_string().contains("other numbers of samples"), "{error}");
    assert!(error.to_string().contains("continue without a range"), "{error}");
    let error = Merge::new().add("a.film", adaptive).unwrap_err();
    assert!(error.to_string().starts_with("a.film: its tiles have different numbers of samples"), "{error}");
}

/// Samples whose brightness and thing depend on the pixel and the index. The left half of the picture has no noise.
#[derive(Debug)]
struct Pattern {
    channels: usize,
    at_once: usize,
}

impl SampleTracer for Pattern {
    fn samples_at_once(&self) -> usize {
        self.at_once
    }

    fn trace(&mut self, samples: &[[u32; 2]]) -> Result<Vec<u32>, Error> {
        assert!(samples.len() <= self.at_once && samples.is_sorted());
        let words = samples.iter().flat_map(|&[pixel, index]| {
            let right = pixel as usize % SIZE[0] >= SIZE[0] / 2;
            let value = if right { noise(pixel as usize, index) } else { 0.5 };
            let thing = (pixel + index) % 2;
            let extra = [1f32.to_bits(), pixel + 1, thing, 1, 0, 0];
            std::iter::repeat_n(value.to_bits(), self.channels).chain(extra)
        });
        Ok(words.collect())
    }
}

/// Another tracer is adaptive, too. Each sample of a pixel is traced once, and the picture does not depend on how many
/// are traced at once.
#[test]
fn another_tracer_is_adaptive() {
    let world = world();
    let render = |at_once: usize, resumed: bool| {
        let tracer = || Box::new(Pattern { channels: world.layout(&options(1).layers).channels(), at_once });
        let mut session = Session::new(&world, options(if resumed { 19 } else { 60 })).unwrap();
        session.set_tracer(tracer());
        session.run(&(), |_| Ok::<(), Error>(())).unwrap();
        if resumed {
            let kept = session.into_checkpoint();
            session = Session::new(&world, options(60)).unwrap();
            session.set_tracer(tracer());
            session.resume(kept).unwrap();
            session.run(&(), |_| Ok::<(), Error>(())).unwrap();
        }
        session.into_checkpoint().film
    };
    let film = render(1 << 20, false);
    assert!(film.is_adaptive() && film == render(101, false) && film == render(1 << 20, true));
    for (x, y) in [(3, 5), (SIZE[0] - 4, 7)] {
        let (pixel, samples) = (y * SIZE[0] + x, film.samples_of(x, y) as u32);
        let value = |index| if x > SIZE[0] / 2 { noise(pixel, index) } else { 0.5 };
        let expected = (0..samples).map(|index| f64::from(value(index))).sum::<f64>() / f64::from(samples);
        assert!((film.mean(x, y, Layer::Beauty, 0) - expected).abs() < 1e-6, "{x} {y}");
    }
    assert!(film.samples_of(SIZE[0] - 4, 7) > 2 * film.samples_of(3, 5));
}

#[test]
fn damaged_plans_are_refused() {
    let world = world();
    let checkpoint = finish(&world, Options { layers: vec![Layer::Beauty], ..options(40) });
    let bytes = checkpoint.to_bytes();
    assert!(bytes.starts_with(b"VELLUSF4"));
    assert_eq!(Checkpoint::from_bytes(&bytes).unwrap(), checkpoint);
    let content = &bytes[..bytes.len() - 32];
    // The plan follows the header, whose lists of light groups and notes are short here: 8 bytes hold the number 32.
    let start = content.windows(8).position(|b| b == 32u64.to_le_bytes()).unwrap();
    // The start of the plan, and the samples and the rate of the first tile.
    for lie in [start, start + 8, start + 16] {
        let mut wrong = content.to_vec();
        wrong[lie..lie + 4].fill(0xff);
        let digest = vellus_io::Digest::of(&wrong);
        wrong.extend(digest.0);
        let error = Checkpoint::from_bytes(&wrong).unwrap_err().to_string();
        assert!(error.contains("numbers of samples"), "{error}");
    }
}
