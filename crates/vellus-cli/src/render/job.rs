//! One picture: passes, progress, checkpoints, and what is written in the end.

use super::Args;
use super::denoise::Denoiser;
use super::goals::{End, Goals, State, clock};
use super::identity::{IDENTITY_NOTE, identity};
use super::keep::{Keeper, check_same};
use super::tev::Viewer;
use super::write::{self, Picture};
use crate::interrupt::Interrupt;
use crate::output;
use crate::say::{note, say};
use anyhow::Result;
use std::ops::Range;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use vellus_io::Digest;
use vellus_render::{Checkpoint, Film, Layer, PixelType, Settings, Statistics, World, widen};
use vellus_scene::Scene;

/// A pass takes about that long: Ctrl-C, checkpoints and the bar wait for no more.
const PASS: Duration = Duration::from_secs(2);

/// A run.
pub struct Job<'a> {
    args: &'a Args,
    world: World,
    settings: Settings,
    part: Checkpoint,
    goal: Range<u64>,
    keeper: Keeper<'a>,
    interrupt: &'a Interrupt,
    viewer: Option<&'a mut Viewer>,
    denoiser: Option<Denoiser>,
}

/// A scene that was read, and what tells its picture from others.
pub struct Loaded {
    scene: Scene,
    /// See [`identity`].
    pub identity: Digest,
    seconds: f64,
}

impl Loaded {
    /// Reads or grows the scene.
    pub fn new(args: &Args) -> Result<Self> {
        let start = Instant::now();
        let (scene, sources) = args.input.load_with_sources()?;
        Ok(Loaded { scene, identity: identity(args, &sources)?, seconds: start.elapsed().as_secs_f64() })
    }
}

impl<'a> Job<'a> {
    /// Makes a scene ready and reads the samples that it continues from. `pictures` is how many will be written in
    /// this folder.
    pub fn new(
        args: &'a Args,
        loaded: Loaded,
        interrupt: &'a Interrupt,
        viewer: Option<&'a mut Viewer>,
        pictures: u64,
    ) -> Result<Self> {
        let start = Instant::now();
        let denoiser = args.denoise.then(Denoiser::load).transpose()?;
        let Loaded { mut scene, identity, seconds } = loaded;
        let [width, height] = args.size.map(|n| n as f32);
        scene.camera = scene.camera.or_else(|| scene.framing(width / height));
        widen(&mut scene, args.size, args.min_pixel_width);
        let mut notes = vec![
            ("vellus_version".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
            ("vellus_command".to_owned(), write::command()),
            ("vellus_scene".to_owned(), args.input.name()),
            ("vellus_model".to_owned(), args.model.name()?),
            ("vellus_mode".to_owned(), format!("{:?}", args.mode).to_lowercase()),
            ("vellus_filter".to_owned(), format!("{:?}", args.filter).to_lowercase()),
            ("vellus_min_pixel_width".to_owned(), args.min_pixel_width.to_string()),
            ("vellus_seed".to_owned(), args.seed.to_string()),
            (IDENTITY_NOTE.to_owned(), identity.to_string()),
        ];
        notes.extend(write::fibers(&scene));
        let world = args.model.world(scene)?;
        let segments = world.curves.segments();
        note!(
            "{} segments, {:.0} MB, ready in {:.1} s",
            segments,
            world.curves.bytes() as f64 * 1e-6,
            seconds + start.elapsed().as_secs_f64()
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
        keeper.check_space(picture.saturating_mul(pictures), pixels * layout.bytes_per_pixel() as u64)?;
        let film = Film::new(settings.size, settings.area(), layout);
        let samples = goal.start..goal.start;
        let mut part = Checkpoint { identity, samples, planned: goal.end, notes, film };
        if let Some(kept) = keeper.load(identity)? {
            check_same(&kept, &part, args, keeper.path())?;
            note!("continuing from {} samples a pixel", kept.film.samples());
            (part.samples, part.film) = (kept.samples, kept.film);
            part.planned = part.planned.max(part.samples.end);
        }
        Ok(Job { args, world, settings, part, goal, keeper, interrupt, viewer, denoiser })
    }

    /// Renders, and writes the result: a picture, and a film of `--samples`.
    ///
    /// # Errors
    /// [`Interrupted`](crate::exit::Interrupted) where a signal stopped it; it says what was kept.
    pub fn run(mut self) -> Result<()> {
        self.interrupt.set_immediate(false);
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
        let interrupted = end == End::Interrupted;
        if samples == 0 {
            // Goals other than interruption need a sample.
            return Err(self.interrupt.error("nothing was rendered yet, nothing is kept".to_owned()).into());
        }
        self.part.notes.push(("vellus_seconds".to_owned(), format!("{seconds:.1}")));
        if self.args.samples.is_some() && !interrupted {
            let path = self.args.output.with_extension("film");
            output::write(Some(&path), &self.part.to_bytes()).or_else(|e| self.keeper.rescue(&self.part, e))?;
            say!("wrote {}", path.display());
            if self.part.samples.end < self.goal.end {
                note!("warning: it has samples {:?} of {:?}", self.part.samples, self.goal);
            }
        }
        // A frame of an animation is done when it ends by time or noise; a single picture may be continued.
        let done = end == End::Samples || (!interrupted && self.args.frames.is_some());
        let kept = !done && self.keeper.keep(&self.part);
        let mut notes = self.part.notes.clone();
        notes.extend([
            ("vellus_samples".to_owned(), samples.to_string()),
            ("vellus_noise".to_owned(), self.part.film.noise().map_or("unknown".to_owned(), |x| format!("{x:.5}"))),
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
        if interrupted {
            let film = if kept { format!(" and {}", self.keeper.path().display()) } else { String::new() };
            let next = if kept { ", and the same command with --resume continues" } else { "" };
            let output = self.args.output.display();
            return Err(self.interrupt.error(format!("{samples} samples a pixel are in {output}{film}{next}")).into());
        }
        Ok(())
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
            let stop = &self.interrupt.stop;
            let stopped = stop.load(Ordering::Relaxed)
                || !self.world.render(&self.settings, &mut self.part.film, next.clone(), statistics, stop);
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
        let noise = self.part.film.noise().map_or("unknown".to_owned(), |noise| format!("{noise:.4}"));
        let rate = rays / seconds.max(1e-9);
        note!("{samples} samples a pixel, {rays:.2} Mrays in {seconds:.1} s ({rate:.2} Mrays/s), noise {noise}");
        let rejected = statistics.rejected.load(Ordering::Relaxed);
        if rejected > 0 {
            note!("warning: {rejected} samples were not finite and were left out");
        }
        write::warn_of_full_pixels(&self.part.film);
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
    let noise = state.noise.map_or(String::new(), |noise| format!("noise {noise:.4}, "));
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
    pub fn depth(&self) -> PixelType {
        if self.float { PixelType::Float } else { PixelType::Half }
    }
}
