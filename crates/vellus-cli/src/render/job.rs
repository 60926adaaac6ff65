//! One run of the renderer: passes, progress, checkpoints, and what is written in the end.

use super::Args;
use crate::output;
use anyhow::{Context, Result, anyhow};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use vellus_render::{Depth, Film, Layer, Part, Settings, Statistics, World};

/// A pass takes about that long: Ctrl-C, checkpoints and the bar wait for no more.
const PASS: Duration = Duration::from_secs(2);

/// What is lost at most when the program is killed.
const CHECKPOINT: Duration = Duration::from_secs(60);

/// A run.
pub struct Job<'a> {
    args: &'a Args,
    world: World,
    settings: Settings,
    fingerprint: u64,
    part: Part,
    goal: Range<u64>,
    stop: Arc<AtomicBool>,
}

impl<'a> Job<'a> {
    /// Loads the scene and, where asked for, what was rendered already.
    pub fn new(args: &'a Args) -> Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&stop);
        // A second Ctrl-C ends at once.
        ctrlc::set_handler(move || {
            if flag.swap(true, Ordering::Relaxed) {
                std::process::exit(130);
            }
        })
        .context("cannot watch for Ctrl-C")?;
        let start = Instant::now();
        let scene = args.input.load()?;
        let world = World::new(scene)?;
        let segments = world.curves.segments();
        eprintln!(
            "{} segments, {:.0} MB, ready in {:.1} s",
            segments,
            world.curves.bytes() as f64 * 1e-6,
            start.elapsed().as_secs_f64()
        );
        let settings = Settings {
            size: args.size,
            crop: args.crop,
            mode: args.mode.into(),
            seed: args.seed,
            max_depth: args.max_depth,
        };
        // Two pictures with the same fingerprint may be added.
        let mut hasher = DefaultHasher::new();
        (args.input.identity()?, args.size, args.crop, format!("{:?}", args.mode), args.seed, args.max_depth)
            .hash(&mut hasher);
        env!("CARGO_PKG_VERSION").hash(&mut hasher);
        let fingerprint = hasher.finish();
        let goal = args.samples.clone().unwrap_or(0..args.spp);
        let [_, _, width, height] = settings.area();
        let mut part = Part { fingerprint, samples: goal.start..goal.start, film: Film::new(width, height) };
        let checkpoint = checkpoint(args);
        if args.resume && checkpoint.exists() {
            let bytes = std::fs::read(&checkpoint).with_context(|| format!("cannot read {}", checkpoint.display()))?;
            let kept = Part::from_bytes(&bytes).map_err(|e| anyhow!("{}: {e}", checkpoint.display()))?;
            if kept.fingerprint != fingerprint {
                anyhow::bail!("{} is of another picture: delete it, or render without --resume", checkpoint.display());
            }
            eprintln!("going on from {} samples a pixel", kept.film.samples());
            part = kept;
        }
        Ok(Job { args, world, settings, fingerprint, part, goal, stop })
    }

    /// Renders, and writes what there is.
    pub fn run(mut self) -> Result<()> {
        let start = Instant::now();
        let statistics = Statistics::default();
        let bar = output::progress(self.goal.end - self.part.samples.start, "rendering");
        bar.set_position(self.part.samples.end - self.part.samples.start);
        let (mut pass, mut kept) = (1, Instant::now());
        while self.part.samples.end < self.goal.end && !self.stop.load(Ordering::Relaxed) {
            let spent = start.elapsed();
            if self.args.time.is_some_and(|time| spent >= time) {
                break;
            }
            let next = self.part.samples.end..(self.part.samples.end + pass).min(self.goal.end);
            let count = next.end - next.start;
            let began = Instant::now();
            if !self.world.render(&self.settings, &mut self.part.film, next.clone(), &statistics, &self.stop) {
                break;
            }
            self.part.samples.end = next.end;
            let each = began.elapsed().as_secs_f64() / count as f64;
            let left = self.args.time.map_or(PASS, |time| time.saturating_sub(start.elapsed()).min(PASS));
            pass = ((left.as_secs_f64() / each.max(1e-9)) as u64).clamp(1, 2 * pass);
            let noise = self.part.film.noise();
            let rays = statistics.rays.load(Ordering::Relaxed) as f64 / start.elapsed().as_secs_f64();
            bar.set_message(format!("{:.2} Mrays/s, noise {noise:.4}", rays * 1e-6));
            bar.set_position(self.part.samples.end - self.goal.start);
            if self.args.noise.is_some_and(|goal| self.part.film.samples() >= 8 && noise <= goal) {
                break;
            }
            if kept.elapsed() > CHECKPOINT {
                self.keep()?;
                kept = Instant::now();
            }
        }
        bar.finish_and_clear();
        let seconds = start.elapsed().as_secs_f64();
        let samples = self.part.film.samples();
        let [_, _, width, height] = self.settings.area();
        let pixels = (width * height) as f64;
        let rays = statistics.rays.load(Ordering::Relaxed) as f64;
        eprintln!(
            "{samples} samples a pixel, {:.2} Mrays in {seconds:.1} s ({:.2} Mrays/s), noise {:.4}",
            rays * 1e-6,
            rays * 1e-6 / seconds,
            self.part.film.noise()
        );
        let rejected = statistics.rejected.load(Ordering::Relaxed);
        if rejected > 0 {
            eprintln!("warning: {rejected} samples were not finite and were left out");
        }
        if let Some(max) = self.settings.max_depth {
            let share = statistics.cut() / (samples.max(1) as f64 * pixels);
            eprintln!(
                "paths cut after {max} events had {:.3} % of a sample's throughput left on average",
                100.0 * share
            );
        }
        if samples == 0 {
            anyhow::bail!("stopped before the first sample: nothing to write");
        }
        let finished = self.part.samples.end >= self.goal.end;
        if self.args.samples.is_some() {
            let path = self.args.output.with_extension("film");
            output::write(Some(&path), &self.part.to_bytes())?;
            println!("wrote {}", path.display());
        } else if finished {
            std::fs::remove_file(checkpoint(self.args)).ok();
        } else {
            self.keep()?;
        }
        let notes = [
            ("vellus_version", env!("CARGO_PKG_VERSION").to_owned()),
            ("vellus_command", std::env::args().collect::<Vec<_>>().join(" ")),
            ("vellus_samples", samples.to_string()),
            ("vellus_fingerprint", format!("{:016x}", self.fingerprint)),
        ];
        let layers = if self.args.layers.is_empty() { &Layer::ALL[..] } else { &self.args.layers };
        let depth = if self.args.float { Depth::Float } else { Depth::Half };
        write_picture(&self.part.film, &self.args.output, layers, depth, self.args.exposure, &notes)
    }

    fn keep(&self) -> Result<()> {
        output::write(Some(&checkpoint(self.args)), &self.part.to_bytes())
    }
}

/// Where a picture's checkpoint is.
fn checkpoint(args: &Args) -> PathBuf {
    args.output.with_extension("checkpoint")
}

/// Writes OpenEXR and PNG, and says so.
pub fn write_picture(
    film: &Film,
    path: &Path,
    layers: &[Layer],
    depth: Depth,
    exposure: f32,
    notes: &[(&str, String)],
) -> Result<()> {
    if path.extension().is_some_and(|e| e == "exr") {
        let bytes = film.to_exr(layers, depth, notes).map_err(|e| anyhow!("cannot encode OpenEXR: {e}"))?;
        output::write(Some(path), &bytes)?;
        println!("wrote {}", path.display());
    }
    let png = path.with_extension("png");
    output::write(Some(&png), &film.to_png(exposure).map_err(|e| anyhow!("cannot encode PNG: {e}"))?)?;
    println!("wrote {}", png.display());
    Ok(())
}
