//! Renders a part of a picture by several methods, and measures each method's error and time against its converged
//! picture.

use crate::Quality;
use crate::context::{Context, Interrupted};
use crate::printed_far::PrintedFar;
use anyhow::{Context as _, Result, anyhow};
use std::ops::Range;
use std::sync::OnceLock;
use std::time::{Duration, Instant};
use vellus_io::{DigestBuilder, cpu_time};
use vellus_models::ModelKind;
use vellus_models::yan2015::Profiles;
use vellus_render::session::{End, Options, read_film, write_film};
use vellus_render::{Display, Error, Film, Filter, Layer, Mode, PICTURE_VERSION, Session, Settings, World};
use vellus_scene::{Camera, Scene};

/// A method to compute the scattering: the model, and the part of the width that it averages over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Method {
    pub name: &'static str,
    /// The name in file names.
    pub key: &'static str,
    pub model: ModelKind,
    pub mode: Mode,
    /// For yan2015: the medulla's index, if it differs from the cortex'.
    pub eta_m: Option<f32>,
    /// For yan2015: trace paths, read large tables and sample as it was published in 2015.
    pub published: bool,
}

impl Method {
    /// The name at the start of a sentence.
    pub fn sentence(&self) -> String {
        let article = if self.model == ModelKind::Vellus { "Our " } else { "" };
        format!("{article}{}", self.name)
    }
}

const fn ours(name: &'static str, key: &'static str, mode: Mode) -> Method {
    Method { name, key, model: ModelKind::Vellus, mode, eta_m: None, published: false }
}

pub const NEAR: Method = ours("near field", "near", Mode::Near);
pub const FAR: Method = ours("far field", "far", Mode::Far);
pub const MULTI: Method = ours("multi-scale", "multiscale", Mode::MultiScale);
pub const YAN2015: Method = Method { model: ModelKind::Yan2015, ..ours("Yan et al. 2015", "yan2015", Mode::Near) };
pub const PUBLISHED: Method =
    Method { model: ModelKind::Yan2015, published: true, ..ours("2015 as published", "yan2015-published", Mode::Near) };

/// The tables of the model of 2015 as published. At smoke quality they are small, because filling tables of 755 MB
/// takes longer than everything else.
pub fn profiles(quality: Quality) -> &'static Profiles {
    static SMALL: OnceLock<Profiles> = OnceLock::new();
    match quality {
        Quality::Smoke => SMALL.get_or_init(|| Profiles::new([4, 4, 4, 36])),
        Quality::Draft | Quality::Paper => Profiles::published(),
    }
}

/// The time between checkpoints of long renderings.
const KEEP: Duration = Duration::from_secs(30);

/// The time of one pass.
const PASS: Duration = Duration::from_secs(1);

/// Seeds of the two halves of a converged picture, and of the measured pictures.
const REFERENCE: [u32; 2] = [101, 202];
const MEASURED: u32 = 7;

/// A scene prepared for rays, and the part of its picture to render.
pub struct Shot<'c> {
    context: &'c Context<'c>,
    name: String,
    world: World,
    size: [usize; 2],
    crop: [usize; 4],
    layers: Vec<Layer>,
    /// If set, the far field has the paper's segments, this many on each side.
    segments: Option<usize>,
}

/// A converged picture, and the variance of its mean in RGB, averaged over pixels and channels.
pub struct Converged {
    pub film: Film,
    halves: [Film; 2],
    variance: f64,
    /// Root mean square of the differences between pixels of the two halves, divided by their standard errors. It is 1
    /// if the standard errors are correct.
    pub spread: f64,
}

/// A measurement of a picture with this many samples.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    pub samples: u64,
    /// Processor time, seconds.
    pub time: f64,
    /// Mean square of the difference from the converged picture, minus the part from the noise of the converged
    /// picture.
    pub mse: f64,
    /// The same, with each square divided by the square of the converged picture plus a hundredth of the mean square.
    pub rel_mse: f64,
}

impl Point {
    /// A measurement of no samples.
    pub fn none() -> Self {
        Point { samples: 0, time: 0.0, mse: 0.0, rel_mse: 0.0 }
    }

    pub fn rmse(&self) -> f64 {
        self.mse.max(0.0).sqrt()
    }
}

impl<'c> Shot<'c> {
    /// `crop` is left, top, width and height in a picture of `size`.
    pub fn new(context: &'c Context<'c>, name: &str, scene: Scene, size: [usize; 2], crop: [usize; 4]) -> Result<Self> {
        let world = World::new(scene)?;
        let (name, layers) = (name.to_owned(), vec![Layer::Beauty]);
        Ok(Shot { context, name, world, size, crop, layers, segments: None })
    }

    /// Selects another part of the same scene. `name` identifies its files.
    pub fn aim(&mut self, name: &str, size: [usize; 2], crop: [usize; 4]) {
        (self.name, self.size, self.crop) = (name.to_owned(), size, crop);
    }

    /// Replaces the camera of the scene.
    pub fn set_camera(&mut self, camera: Camera) -> Result<()> {
        Ok(self.world.set_camera(camera)?)
    }

    /// Adds layers to the film.
    pub fn with_layers(self, layers: &[Layer]) -> Self {
        Shot { layers: layers.to_vec(), ..self }
    }

    /// Renders far fields by the paper's segments: see [`PrintedFar`]. The model of a method is not used.
    pub fn with_printed_segments(self, segments: usize) -> Self {
        Shot { segments: Some(segments), ..self }
    }

    fn settings(&self, method: Method, seed: u32) -> Settings {
        Settings {
            size: self.size,
            crop: Some(self.crop),
            mode: method.mode,
            filter: Filter::Tent,
            seed,
            max_depth: None,
            clamp_indirect: None,
            radiance_cache: None,
        }
    }

    pub fn empty(&self) -> Film {
        Film::new(self.size, self.crop, self.world.layout(&self.layers))
    }

    /// Sets the model of the strands.
    fn choose(&mut self, method: Method) -> Result<()> {
        if let Some(segments) = self.segments {
            return Ok(self.world.set_model(|fiber| PrintedFar::new(fiber, segments))?);
        }
        let Method { model: kind, eta_m, published, .. } = method;
        let published = published.then(|| profiles(self.context.quality));
        vellus_render_models::Method { kind, eta_m, published }.apply(&mut self.world)?;
        Ok(())
    }

    /// Adds samples and returns the processor time that they took.
    fn add(&self, settings: &Settings, film: &mut Film, samples: Range<u64>) -> Result<f64> {
        let before = cpu_time().context("this system does not report processor time")?;
        match self.world.render(settings, film, samples, self.context.progress()) {
            Err(Error::Cancelled) => return Err(Interrupted.into()),
            result => result.map(drop)?,
        }
        Ok((cpu_time().unwrap_or_default() - before).as_secs_f64())
    }

    /// Renders a picture with this many samples per pixel. The experiment's folder keeps its film. A finished film is
    /// read, and an interrupted one is continued.
    pub fn render(&mut self, method: Method, seed: u32, samples: u64) -> Result<Film> {
        self.choose(method)?;
        let file = self.context.path(&format!("{}-{}-{seed}.film", self.name, method.key));
        let what = format!("{} {:?} {:?} {method:?} {seed} {:?}", self.name, self.size, self.crop, self.layers);
        let identity = DigestBuilder::new()
            .field("picture version", PICTURE_VERSION.to_le_bytes())
            .field("what", what)
            .field("segments", (self.world.curves().segments() as u64).to_le_bytes())
            .finish();
        let options = Options {
            layers: self.layers.clone(),
            exact: true,
            pass: PASS,
            identity,
            ..Options::new(self.settings(method, seed), samples)
        };
        let mut session = Session::new(&self.world, options)?;
        if !self.context.again()
            && let Ok(kept) = read_film(&file)
        {
            // Replaces a film of another picture.
            session.resume(kept).ok();
        }
        let before = session.film().samples();
        let mut kept = Instant::now();
        let end = session.run(self.context.progress(), |pass| -> Result<()> {
            if kept.elapsed() > KEEP {
                write_film(&file, pass.checkpoint)?;
                kept = Instant::now();
            }
            Ok(())
        })?;
        if session.film().samples() > before {
            write_film(&file, session.checkpoint())?;
        }
        if end == End::Interrupted {
            return Err(Interrupted.into());
        }
        Ok(session.into_checkpoint().film)
    }

    /// Renders two halves of `half` samples each, with two seeds that no other method uses. Returns their mean, and
    /// the variance from their difference.
    pub fn converge(&mut self, method: Method, half: u64) -> Result<Converged> {
        let [first, second] = REFERENCE.map(|seed| own(method, seed));
        let halves = [self.render(method, first, half)?, self.render(method, second, half)?];
        let (a, b) = (colors(&halves[0]), colors(&halves[1]));
        let variance = a.iter().zip(&b).map(|(a, b)| 0.25 * (a - b).powi(2)).sum::<f64>() / a.len() as f64;
        let (_, _, spread) = difference(&halves[0], &halves[1]);
        let mut film = halves[0].clone();
        film.merge(&halves[1]);
        Ok(Converged { film, halves, variance, spread })
    }

    /// Each method's error and time at 1, 2, 4, … `most` samples, and its last picture. The methods alternate, so
    /// that other load on the machine affects all of them alike.
    pub fn measure(&mut self, methods: &[(Method, &Converged)], most: u64) -> Result<Vec<(Vec<Point>, Film)>> {
        let mut found: Vec<(Vec<Point>, Film)> = methods.iter().map(|_| (Vec::new(), self.empty())).collect();
        let mut times = vec![0.0; methods.len()];
        let mut from = 0;
        let stage = self.context.stage(most, "measuring");
        while from < most {
            let to = if from == 0 { 1 } else { (2 * from).min(most) };
            for (i, (method, converged)) in methods.iter().enumerate() {
                self.choose(*method)?;
                let settings = self.settings(*method, MEASURED);
                let (points, film) = &mut found[i];
                times[i] += self.add(&settings, film, from..to)?;
                points.push(converged.error(film, times[i]));
            }
            from = to;
            stage.set(to);
        }
        Ok(found)
    }

    /// Adds this many samples, with a seed that no other method uses. Returns the processor time that they took.
    pub fn extend(&mut self, method: Method, film: &mut Film, samples: u64) -> Result<f64> {
        self.choose(method)?;
        let settings = self.settings(method, own(method, MEASURED));
        self.add(&settings, film, film.samples()..film.samples() + samples)
    }

    /// Three channels of a layer as a PNG.
    pub fn layer_png(&self, film: &Film, layer: Layer, first: usize, exposure: f32) -> Result<Vec<u8>> {
        film.layer_to_png(layer, first, exposure).map_err(|e| anyhow!("cannot encode PNG: {e}"))
    }

    /// Writes a picture as NAME.png and NAME.exr and returns the name of the PNG.
    pub fn save(&self, film: &Film, name: &str, exposure: f32) -> Result<String> {
        let png = film.to_png(None, Display::srgb(exposure), &[]).map_err(|e| anyhow!("cannot encode PNG: {e}"))?;
        let exr = film.to_exr(&self.layers, None, vellus_render::PixelType::Half, &[]);
        self.context.write(&format!("{name}.exr"), &exr.map_err(|e| anyhow!("cannot encode OpenEXR: {e}"))?)?;
        self.context.write(&format!("{name}.png"), &png)?;
        Ok(format!("{name}.png"))
    }
}

/// A seed that no other method uses, so that noise is independent.
fn own(method: Method, seed: u32) -> u32 {
    method.key.bytes().fold(seed, |seed, byte| seed.wrapping_mul(31).wrapping_add(byte.into()))
}

/// Mean of a pixel's channels.
pub fn brightness(film: &Film, x: usize, y: usize) -> f64 {
    (0..3).map(|c| film.mean(x, y, Layer::Beauty, c)).sum::<f64>() / 3.0
}

/// Compares the fur in two pictures. Returns three numbers: the difference of the means in standard errors, the same
/// difference relative to the brightness, and the root mean square of the pixels' differences in their standard errors.
/// Only pixels with light and noise count. Each pixel is weighted by the share that fibres cover.
pub fn difference(a: &Film, b: &Film) -> (f64, f64, f64) {
    let (width, height) = (b.width(), b.height());
    let (mut sum, mut all, mut variance, mut squares, mut count) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (x, y) in (0..width * height).map(|i| (i % width, i / width)) {
        let (p, q) = (brightness(a, x, y), brightness(b, x, y));
        let error = a.error(x, y).powi(2) + b.error(x, y).powi(2);
        let weight = 0.5 * (a.mean(x, y, Layer::Fibers, 0) + b.mean(x, y, Layer::Fibers, 0));
        sum += weight * (p - q);
        all += weight * q;
        variance += weight * weight * error;
        if error > 0.0 {
            squares += weight * (p - q).powi(2) / error;
            count += weight;
        }
    }
    let safe = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
    (safe(sum, variance.sqrt()), safe(sum, all), safe(squares, count).sqrt())
}

/// All channels of all pixels.
pub fn colors(film: &Film) -> Vec<f64> {
    let (width, height) = (film.width(), film.height());
    (0..3 * width * height).map(|i| film.mean(i / 3 % width, i / 3 / width, Layer::Beauty, i % 3)).collect()
}

impl Converged {
    /// The two pictures with independent seeds. Their mean is the converged picture.
    pub fn halves(&self) -> [&Film; 2] {
        [&self.halves[0], &self.halves[1]]
    }

    pub fn error(&self, film: &Film, time: f64) -> Point {
        let (a, b) = (colors(film), colors(&self.film));
        let n = b.len() as f64;
        let floor = 0.01 * b.iter().map(|b| b * b).sum::<f64>() / n;
        let mse = a.iter().zip(&b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / n;
        let rel = |a: f64, b: f64| (a - b).powi(2) / (b * b + floor);
        let rel_mse = a.iter().zip(&b).map(|(a, b)| rel(*a, *b)).sum::<f64>() / n;
        // The variance of the converged picture is distributed like that of the measured one, so its share of the
        // relative error is the same.
        let left = 1.0 - self.variance / mse.max(1e-300);
        Point { samples: film.samples(), time, mse: mse * left, rel_mse: rel_mse * left }
    }

    /// Mean of all channels.
    pub fn mean(&self) -> f64 {
        let colors = colors(&self.film);
        colors.iter().sum::<f64>() / colors.len() as f64
    }
}

/// The time that `b` takes to reach the error of `a`, relative to the time of `a`. It is the geometric mean of the last
/// three points, where the error is proportional to one over time.
pub fn speedup(a: &[Point], b: &[Point], error: impl Fn(&Point) -> f64) -> f64 {
    let cost = |p: &Point| (error(p).max(1e-300) * p.time).ln();
    let last = a.len().min(b.len()).min(3);
    let sum: f64 = (1..=last).map(|k| cost(&b[b.len() - k]) - cost(&a[a.len() - k])).sum();
    (sum / last.max(1) as f64).exp()
}
