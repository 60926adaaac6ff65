//! One picture: passes, progress, checkpoints, and what is written in the end.

use super::Args;
use super::denoise::Denoiser;
use super::goals::{End, Goals, State, clock};
use super::keep::Keeper;
use super::tev::Viewer;
use super::write::{self, Picture};
use crate::output;
use crate::say::{note, say};
use anyhow::{Result, bail};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use vellus_render::{Depth, Film, Layer, Part, Settings, Statistics, World, widen};

/// A pass takes about that long: Ctrl-C, checkpoints and the bar wait for no more.
const PASS: Duration = Duration::from_secs(2);

/// A run.
pub struct Job<'a> {
    args: &'a Args,
    world: World,
    settings: Settings,
    part: Part,
    goal: Range<u64>,
    keeper: Keeper<'a>,
    stop: &'a AtomicBool,
    viewer: Option<&'a mut Viewer>,
    denoiser: Option<Denoiser>,
}

/// Two films with the same fingerprint may be added.
pub fn fingerprint(args: &Args) -> Result<u64> {
    let mut hasher = DefaultHasher::new();
    (
        args.input.identity()?,
        args.size,
        args.crop,
        format!("{:?}", (args.mode, args.filter)),
        args.seed,
        args.max_depth,
    )
        .hash(&mut hasher);
    args.min_pixel_width.to_bits().hash(&mut hasher);
    args.model.name()?.hash(&mut hasher);
    Layer::ALL.map(|layer| args.layers().contains(&layer)).hash(&mut hasher);
    env!("CARGO_PKG_VERSION").hash(&mut hasher);
    Ok(hasher.finish())
}

impl<'a> Job<'a> {
    /// Loads the scene and, where asked for, what was rendered already. `pictures` are so many to be written beside each other.
    pub fn new(args: &'a Args, stop: &'a AtomicBool, viewer: Option<&'a mut Viewer>, pictures: u64) -> Result<Self> {
        let start = Instant::now();
        let denoiser = args.denoise.then(Denoiser::load).transpose()?;
        let mut scene = args.input.load()?;
        let [width, height] = args.size.map(|n| n as f32);
        scene.camera = scene.camera.or_else(|| scene.framing(width / height));
        widen(&mut scene, args.size, args.min_pixel_width);
        let fingerprint = fingerprint(args)?;
        let mut notes = vec![
            ("vellus_version".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
            ("vellus_command".to_owned(), write::command()),
            ("vellus_scene".to_owned(), args.input.name()),
            ("vellus_model".to_owned(), args.model.name()?),
            ("vellus_mode".to_owned(), format!("{:?}", args.mode).to_lowercase()),
            ("vellus_filter".to_owned(), format!("{:?}", args.filter).to_lowercase()),
            ("vellus_min_pixel_width".to_owned(), args.min_pixel_width.to_string()),
            ("vellus_seed".to_owned(), args.seed.to_string()),
            ("vellus_fingerprint".to_owned(), format!("{fingerprint:016x}")),
        ];
        notes.extend(write::fibers(&scene));
        let world = args.model.world(scene)?;
        let segments = world.curves.segments();
        note!(
            "{} segments, {:.0} MB, ready in {:.1} s",
            segments,
            world.curves.bytes() as f64 * 1e-6,
            start.elapsed().as_secs_f64()
        );
        notes.push(("vellus_segments".to_owned(), segments.to_string()));
        let settings = Settings {
            size: args.size,
            crop: args.crop,
            mode: args.mode.into(),
            filter: args.filter.into(),
            seed: args.seed,
            max_depth: args.max_depth,
        };
        let goal = args.samples.clone().unwrap_or(0..args.spp);
        let keeper = Keeper::new(args);
        let layout = world.layout(args.layers());
        let pixels = settings.area()[2..].iter().product::<usize>() as u64;
        let picture = write::largest_size(pixels, &layout, &args.output, args.layers(), args.depth());
        keeper.check_space(picture * pictures, 8 * pixels * layout.channels() as u64)?;
        let film = Film::new(settings.size, settings.area(), layout);
        let mut part = Part { fingerprint, samples: goal.start..goal.start, notes, film };
        if let Some(kept) = keeper.load()? {
            let same = kept.fingerprint == fingerprint && kept.film.fits(&part.film);
            let fits = kept.samples.start == goal.start && (args.samples.is_none() || kept.samples.end <= goal.end);
            if !(same && fits) {
                let path = keeper.path().display();
                bail!("{path} is of another picture: delete it, or render without --resume");
            }
            note!("going on from {} samples a pixel", kept.film.samples());
            (part.samples, part.film) = (kept.samples, kept.film);
        }
        Ok(Job { args, world, settings, part, goal, keeper, stop, viewer, denoiser })
    }

    /// Renders, and writes what there is.
    pub fn run(mut self) -> Result<End> {
        let (start, processor) = (Instant::now(), output::cpu_time());
        let before = self.part.film.samples();
        let statistics = Statistics::default();
        let end = self.render(&statistics)?;
        let seconds = start.elapsed().as_secs_f64();
        self.report(&statistics, seconds);
        if let (Some(a), Some(b)) = (processor, output::cpu_time()) {
            let cpu = (b - a).as_secs_f64();
            let pixels: usize = self.settings.area()[2..].iter().product();
            let rate = (self.part.film.samples() - before) as f64 * pixels as f64 * 1e-3 / cpu.max(1e-9);
            note!("{cpu:.3} s of processor time, {rate:.1} thousand samples a second of it");
        }
        let samples = self.part.film.samples();
        if samples == 0 {
            bail!("stopped before the first sample: nothing to write");
        }
        self.part.notes.push(("vellus_seconds".to_owned(), format!("{seconds:.1}")));
        if self.args.samples.is_some() {
            let path = self.args.output.with_extension("film");
            output::write(Some(&path), &self.part.to_bytes()).or_else(|e| self.keeper.rescue(&self.part, e))?;
            say!("wrote {}", path.display());
            if self.part.samples.end < self.goal.end {
                note!("warning: it has samples {:?} of {:?}", self.part.samples, self.goal);
            }
        }
        // Whether a picture of an animation ended by time or noise, it is done; a single one may be gone on with.
        let done = end == End::Samples || (end != End::Interrupted && self.args.frames.is_some());
        if !done {
            self.keeper.keep(&self.part);
        }
        let mut notes = self.part.notes.clone();
        notes.extend([
            ("vellus_samples".to_owned(), samples.to_string()),
            ("vellus_noise".to_owned(), format!("{:.5}", self.part.film.noise())),
            ("vellus_ended_by".to_owned(), end.name().to_owned()),
        ]);
        let picture = Picture {
            path: &self.args.output,
            layers: self.args.layers(),
            depth: self.args.depth(),
            exposure: self.args.exposure,
            denoiser: self.denoiser.take(),
            notes,
        };
        picture.write(&self.part.film).or_else(|e| self.keeper.rescue(&self.part, e))?;
        if done {
            self.keeper.remove();
        }
        Ok(end)
    }

    fn render(&mut self, statistics: &Statistics) -> Result<End> {
        let start = Instant::now();
        let goals = Goals { samples: self.goal.end - self.goal.start, noise: self.args.noise, time: self.args.time };
        let bar = output::bar(1000, "[{wide_bar}] {percent}% {msg}");
        bar.enable_steady_tick(Duration::from_secs(1));
        let longest = PASS.min(self.args.checkpoint);
        let (mut pass, mut kept) = (1, Instant::now());
        let mut each = 0.0;
        let end = loop {
            let film = &self.part.film;
            let state = State { samples: film.samples(), noise: film.noise(), spent: start.elapsed(), each };
            if state.samples > 0 && each > 0.0 {
                bar.set_message(progress(&goals, &state, statistics));
                bar.set_position(done(&goals, &state));
            }
            if let Some(end) = goals.reached(&state) {
                break end;
            }
            let count = pass.min(goals.samples_left(&state)).max(1);
            let next = self.part.samples.end..self.part.samples.end + count;
            let began = Instant::now();
            let stopped = self.stop.load(Ordering::Relaxed)
                || !self.world.render(&self.settings, &mut self.part.film, next.clone(), statistics, self.stop);
            if stopped {
                break End::Interrupted;
            }
            self.part.samples.end = next.end;
            each = began.elapsed().as_secs_f64() / count as f64;
            pass = ((longest.as_secs_f64() / each.max(1e-9)) as u64).clamp(1, 2 * count);
            if let Some(viewer) = &mut self.viewer {
                bar.suspend(|| viewer.show(&self.part.film, &self.args.output));
            }
            if kept.elapsed() >= self.args.checkpoint {
                bar.suspend(|| self.keeper.keep(&self.part));
                kept = Instant::now();
            }
        };
        bar.finish_and_clear();
        Ok(end)
    }

    fn report(&self, statistics: &Statistics, seconds: f64) {
        let samples = self.part.film.samples();
        let rays = statistics.rays.load(Ordering::Relaxed) as f64 * 1e-6;
        let noise = self.part.film.noise();
        let rate = rays / seconds.max(1e-9);
        note!("{samples} samples a pixel, {rays:.2} Mrays in {seconds:.1} s ({rate:.2} Mrays/s), noise {noise:.4}");
        let rejected = statistics.rejected.load(Ordering::Relaxed);
        if rejected > 0 {
            note!("warning: {rejected} samples were not finite and were left out");
        }
        if let Some(max) = self.settings.max_depth {
            let [_, _, width, height] = self.settings.area();
            let share = 100.0 * statistics.cut() / (samples.max(1) as f64 * (width * height) as f64);
            note!("paths cut after {max} events had {share:.3} % of a sample's throughput left on average");
        }
    }
}

/// What the bar says.
fn progress(goals: &Goals, state: &State, statistics: &Statistics) -> String {
    let rate = statistics.rays.load(Ordering::Relaxed) as f64 * 1e-6 / state.spent.as_secs_f64().max(1e-9);
    let left = goals.time_left(state).map_or(String::new(), |left| format!(", {} left", clock(left)));
    // One sample does not tell how it varies.
    let noise = if state.samples > 1 { format!("noise {:.4}, ", state.noise) } else { String::new() };
    format!("{} samples, {noise}{rate:.2} Mrays/s{left}", state.samples)
}

/// The share of the work that is done, in thousandths.
fn done(goals: &Goals, state: &State) -> u64 {
    let left = goals.samples_left(state);
    1000 * state.samples / (state.samples + left).max(1)
}

impl Args {
    /// Layers that are rendered and written.
    pub fn layers(&self) -> &[Layer] {
        &self.layers.0
    }

    /// How colours are stored.
    pub fn depth(&self) -> Depth {
        if self.float { Depth::Float } else { Depth::Half }
    }
}
