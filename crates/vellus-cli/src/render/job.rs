//! One picture: what the user sees of its session, and what is written in the end.

use super::Args;
use super::keep::Keeper;
use crate::interrupt::Interrupt;
use crate::output;
use crate::say::{note, say};
use anyhow::{Result, bail};
use std::path::Path;
use std::time::{Duration, Instant};
use vellus_io::Digest;
use vellus_render::denoise::Denoiser;
use vellus_render::session::{
    End, IDENTITY_NOTE, Identity, Options, Pass, Picture, end_notes, fiber_notes, write_film,
};
use vellus_render::tev::Viewer;
use vellus_render::{Film, PixelType, Session, Settings, World, prepare};
use vellus_scene::Scene;

/// The longest pass: Ctrl-C, checkpoints and the bar wait for its end.
const PASS: Duration = Duration::from_secs(2);

/// A picture that can be rendered.
pub struct Job<'a> {
    args: &'a Args,
    world: World,
    options: Options,
    keeper: Keeper,
    picture: Picture,
    denoiser: Option<Denoiser>,
    interrupt: &'a Interrupt,
}

/// A scene that was read, and the identity of its picture.
pub struct Loaded {
    scene: Scene,
    pub identity: Digest,
    seconds: f64,
}

impl Loaded {
    /// Reads or grows the scene.
    pub fn new(args: &Args) -> Result<Self> {
        let start = Instant::now();
        let opened = args.input.open()?;
        let identity = args.identity(opened.sources.digest())?;
        Ok(Loaded { scene: opened.scene, identity, seconds: start.elapsed().as_secs_f64() })
    }
}

impl<'a> Job<'a> {
    /// Prepares a scene. `pictures` is how many pictures will be written to the folder of this one.
    pub fn new(args: &'a Args, loaded: Loaded, interrupt: &'a Interrupt, pictures: u64) -> Result<Self> {
        let start = Instant::now();
        let denoiser = args.denoise.then(Denoiser::load).transpose()?;
        let Loaded { mut scene, identity, seconds } = loaded;
        prepare(&mut scene, args.size, args.min_pixel_width);
        let mut all_notes = vec![
            ("vellus_version".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
            ("vellus_command".to_owned(), typed_command()),
            ("vellus_scene".to_owned(), args.input.scene.display().to_string()),
            ("vellus_model".to_owned(), args.model.name()?),
            ("vellus_mode".to_owned(), args.settings().mode.name().to_owned()),
            ("vellus_filter".to_owned(), args.settings().filter.name().to_owned()),
            ("vellus_min_pixel_width".to_owned(), args.min_pixel_width.to_string()),
            ("vellus_seed".to_owned(), args.seed.to_string()),
            (IDENTITY_NOTE.to_owned(), identity.to_string()),
        ];
        all_notes.extend(fiber_notes(&scene));
        let world = args.model.world(scene)?;
        let segments = world.curves().segments();
        let megabytes = world.curves().bytes() as f64 * 1e-6;
        let seconds = seconds + start.elapsed().as_secs_f64();
        note!("{segments} segments, {megabytes:.0} MB, ready in {seconds:.1} s");
        all_notes.push(("vellus_segments".to_owned(), segments.to_string()));
        let options = args.options(identity, all_notes);
        let picture = Picture {
            path: args.output.clone(),
            layers: args.layers.clone(),
            pixel_type: if args.float { PixelType::Float } else { PixelType::Half },
            exposure: args.exposure,
            notes: Vec::new(),
        };
        let keeper = Keeper::new(&args.output, args.resume);
        let pixels = options.settings.area()[2..].iter().product::<usize>() as u64;
        let layout = world.layout(&options.layers);
        let bytes = picture.max_bytes(pixels, &layout).saturating_mul(pictures);
        keeper.check_space(bytes, pixels * layout.bytes_per_pixel() as u64)?;
        Ok(Job { args, world, options, keeper, picture, denoiser, interrupt })
    }

    /// Renders, and writes the result: a picture, and a film if `--samples` is given.
    ///
    /// # Errors
    /// [`Interrupted`](crate::exit::Interrupted) if a signal stopped it; the message says what was kept.
    pub fn run(self, viewer: Option<&mut Live>) -> Result<()> {
        let Job { args, world, options, mut keeper, mut picture, denoiser, interrupt } = self;
        let goal = options.samples.clone();
        let mut session = Session::new(&world, options)?;
        keeper.resume(&mut session, if args.samples.is_some() { goal.clone() } else { 0..u64::MAX })?;
        interrupt.set_immediate(false);
        let (start, processor) = (Instant::now(), output::cpu_time());
        let before = session.film().samples();
        let end = render(&mut session, &mut keeper, args, interrupt, viewer)?;
        let seconds = start.elapsed().as_secs_f64();
        report(&session, args, seconds);
        if let (Some(a), Some(b)) = (processor, output::cpu_time()) {
            let cpu = (b - a).as_secs_f64();
            let pixels: usize = args.settings().area()[2..].iter().product();
            let rate = (session.film().samples() - before) as f64 * pixels as f64 * 1e-3 / cpu.max(1e-9);
            note!("{cpu:.3} s of processor time, {rate:.1} thousand samples a second of it");
        }
        let samples = session.film().samples();
        let interrupted = end == End::Interrupted;
        if samples == 0 {
            // All other goals need a sample.
            return Err(interrupt.error("rendering had not begun, no file was changed".to_owned()).into());
        }
        session.notes_mut().push(("vellus_seconds".to_owned(), format!("{seconds:.1}")));
        let checkpoint = session.checkpoint();
        if args.samples.is_some() && !interrupted {
            let path = args.output.with_extension("film");
            write_film(&path, checkpoint).or_else(|e| keeper.rescue(checkpoint, e))?;
            say!("wrote {}", path.display());
            if checkpoint.samples.end < goal.end {
                note!("warning: it has samples {:?} of {goal:?}", checkpoint.samples);
            }
        }
        // A frame of an animation that ends by time or noise is done; a single picture may be continued.
        let done = end == End::Samples || (!interrupted && args.frames.is_some());
        let kept = !done && keeper.keep(checkpoint);
        picture.notes = [checkpoint.notes.clone(), end_notes(&checkpoint.film, end)].concat();
        write_picture(&picture, &checkpoint.film, denoiser.as_ref()).or_else(|e| keeper.rescue(checkpoint, e))?;
        if done {
            keeper.remove();
        }
        if interrupted {
            let film = if kept { format!(" and {}", keeper.path().display()) } else { String::new() };
            let next = if kept { ", and the same command with --resume continues" } else { "" };
            let output = args.output.display();
            return Err(interrupt.error(format!("{samples} samples a pixel are in {output}{film}{next}")).into());
        }
        Ok(())
    }
}

/// This command, as it was typed.
pub fn typed_command() -> String {
    let arguments = std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned());
    std::iter::once("vellus".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")
}

/// Runs the session with a bar, checkpoints and a live view.
fn render(
    session: &mut Session,
    keeper: &mut Keeper,
    args: &Args,
    interrupt: &Interrupt,
    mut viewer: Option<&mut Live>,
) -> Result<End> {
    let bar = output::bar(1000, "[{wide_bar}] {percent}% {msg}");
    bar.enable_steady_tick(Duration::from_secs(1));
    let (mut kept, mut preview) = (Instant::now(), args.preview);
    let end = session.run(&*interrupt.stop, |pass| {
        bar.set_message(message(pass));
        bar.set_position((1000.0 * pass.goals.done(&pass.state)) as u64);
        if let Some(viewer) = &mut viewer {
            bar.suspend(|| viewer.show(&pass.checkpoint.film, &args.output));
        }
        if std::mem::take(&mut preview) {
            bar.suspend(|| write_preview(&pass.checkpoint.film, &args.output));
        }
        if kept.elapsed() >= args.checkpoint {
            bar.suspend(|| keeper.keep(pass.checkpoint));
            kept = Instant::now();
        }
        Ok::<(), anyhow::Error>(())
    });
    bar.finish_and_clear();
    end
}

/// The text of the bar.
fn message(pass: &Pass) -> String {
    let Pass { state, goals, statistics, .. } = pass;
    let rate = statistics.rays as f64 * 1e-6 / state.spent.as_secs_f64().max(1e-9);
    let left = goals.time_left(state).map_or(String::new(), |left| format!(", {} left", clock(left)));
    let noise = state.noise.map_or(String::new(), |noise| format!("noise {noise:.4}, "));
    format!("{} samples, {noise}{rate:.2} Mrays/s{left}", state.samples)
}

/// 0:07, 12:34, 1:02:03.
fn clock(time: Duration) -> String {
    let s = time.as_secs_f64().round() as u64;
    let (h, m, s) = (s / 3600, s / 60 % 60, s % 60);
    if h > 0 { format!("{h}:{m:02}:{s:02}") } else { format!("{m}:{s:02}") }
}

fn report(session: &Session, args: &Args, seconds: f64) {
    let (film, statistics) = (session.film(), session.statistics());
    let (samples, rays) = (film.samples(), statistics.rays as f64 * 1e-6);
    let noise = film.noise().map_or("unknown".to_owned(), |noise| format!("{noise:.4}"));
    let rate = rays / seconds.max(1e-9);
    note!("{samples} samples a pixel, {rays:.2} Mrays in {seconds:.1} s ({rate:.2} Mrays/s), noise {noise}");
    if statistics.rejected > 0 {
        note!("warning: {} samples were not finite and were left out", statistics.rejected);
    }
    warn_of_full_pixels(film);
    if let Some(max) = args.max_depth {
        let share = 100.0 * statistics.cut() / (samples.max(1) as f64 * (film.width() * film.height()) as f64);
        note!("paths cut after {max} events had {share:.3} % of a sample's throughput left on average");
    }
}

/// Warns of pixels whose sums are full: see [`Film::full_pixels`].
pub fn warn_of_full_pixels(film: &Film) {
    let full = film.full_pixels();
    if full > 0 {
        note!(
            "warning: {full} pixels are brighter or further away than a film can sum: they are too dark in the \
             picture (scale the lights or the scene down, or render fewer samples)"
        );
    }
}

/// Writes a picture, and reports its files. If the denoiser fails, the picture is written without it.
pub fn write_picture(picture: &Picture, film: &Film, denoiser: Option<&Denoiser>) -> Result<(), vellus_render::Error> {
    let denoised = denoiser.and_then(|d| d.clean(film).inspect_err(|e| note!("warning: cannot denoise: {e}")).ok());
    for path in picture.write(film, denoised.as_deref())? {
        say!("wrote {}", path.display());
    }
    Ok(())
}

/// Writes the first, noisy picture as PNG beside the output.
fn write_preview(film: &Film, output: &Path) {
    let path = output.with_extension("png");
    match Picture::new(&path).write(film, None) {
        Ok(_) => note!("a first picture is in {} ({} sample per pixel)", path.display(), film.samples()),
        Err(e) => note!("warning: no first picture: {e}"),
    }
}

/// A live view of the pictures.
pub struct Live(Option<Viewer>);

impl Live {
    /// Connects to tev.
    pub fn connect(address: &str) -> Result<Self> {
        match Viewer::connect(address) {
            Ok(viewer) => Ok(Live(Some(viewer))),
            Err(e) => bail!("--tev {address}: no viewer answers there ({e}); start tev first"),
        }
    }

    /// Shows a film under the name of its file. A viewer that is gone is reported once.
    fn show(&mut self, film: &Film, path: &Path) {
        let Some(viewer) = &mut self.0 else { return };
        if let Err(e) = viewer.show(film, &path.display().to_string()) {
            note!("warning: the viewer at {} is gone ({e}): rendering goes on without it", viewer.address());
            self.0 = None;
        }
    }
}

impl Args {
    /// How paths are traced.
    fn settings(&self) -> Settings {
        Settings {
            size: self.size,
            crop: self.crop,
            mode: self.mode,
            filter: self.filter,
            seed: self.seed,
            max_depth: self.max_depth,
        }
    }

    /// What tells this picture from others. `sources` is the digest of the files that the scene was read from.
    pub fn identity(&self, sources: Digest) -> Result<Digest> {
        let model = self.model.kind()?.to_string();
        let identity = Identity {
            settings: &self.settings(),
            layers: &self.layers,
            model: &model,
            eta_m: self.model.eta_m,
            min_pixel_width: self.min_pixel_width,
        };
        let builder = identity.digest(sources);
        Ok(vellus_open::identify(builder, &self.input.scene, &self.input.options()?).finish())
    }

    fn options(&self, identity: Digest, notes: vellus_render::Notes) -> Options {
        Options {
            settings: self.settings(),
            layers: self.layers.clone(),
            samples: self.samples.clone().unwrap_or(0..self.spp),
            exact: self.samples.is_some(),
            noise: self.noise,
            time: self.time,
            pass: PASS.min(self.checkpoint),
            identity,
            notes,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use std::collections::HashMap;
    use vellus_io::Sources;
    use vellus_render::PICTURE_VERSION;

    #[test]
    fn times_are_written_as_on_a_clock() {
        assert_eq!(["0:07", "12:34", "1:02:03"], [6.6, 754.0, 3723.0].map(|s| clock(Duration::from_secs_f64(s))));
    }

    #[derive(Parser)]
    struct Command {
        #[command(flatten)]
        args: Args,
    }

    /// The identity of `vellus render` with these options.
    fn of(options: &str) -> Digest {
        let args = Command::parse_from(["vellus"].into_iter().chain(options.split_whitespace())).args;
        args.identity(Sources::new().digest()).unwrap()
    }

    #[test]
    fn every_option_that_changes_a_pixel_changes_the_identity() {
        let all = "|cat|--small|--size 640x960|--crop 0,0,8,8|--mode near|--filter box|--seed 1|--max-depth 9|\
            --min-pixel-width 0.5|--model yan2015|--model yan2015 --eta-m 1.5|--layers beauty|--strands 50%|\
            x.usda --width 0.5|x.usda --camera a|x.usda --frame 2|x.usda --set kappa=0.5";
        let mut seen = HashMap::new();
        for options in all.split('|') {
            assert_eq!(seen.insert(of(options), options), None, "{options}");
        }
        assert_eq!(seen.len(), 18);
    }

    #[test]
    fn what_changes_no_pixel_does_not_change_the_identity() {
        let same = "--spp 7|--samples 3..9|--threads 1|-o elsewhere/x.exr|--exposure 2|--noise 0.1 --time 9s --float|\
            --resume --checkpoint 1s";
        for options in same.split('|') {
            assert_eq!(of(options), of(""), "{options}");
        }
        assert_eq!(of("a/x.usda"), of("./a/../b/x.usda"));
    }

    /// Films contain the digest. It must be the same on every machine and in every release. It changes with
    /// [`PICTURE_VERSION`], the shipped tables and the fields of the digest, and with nothing else.
    #[test]
    fn the_identity_is_the_same_everywhere() {
        assert_eq!((PICTURE_VERSION, of("cat --small").short().as_str()), (1, "2687decfdbf32395"));
    }
}
