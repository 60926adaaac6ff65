//! One picture: its job, and how it ended.

use super::screen::Screen;
use super::{Args, check_crop};
use crate::interrupt::Interrupt;
use crate::say::note;
use anyhow::{Result, anyhow};
use std::sync::Arc;
use std::time::{Duration, Instant};
use vellus_io::Digest;
use vellus_open::{Backdrop, Opened, Staging};
use vellus_render::denoise::Denoiser;
use vellus_render::session::{
    BACKGROUND_NOTE, End, Event, Identity, Job, Options, Outcome, Picture, Rescue, Store, fiber_notes,
};
use vellus_render::tev::Viewer;
use vellus_render::{Denoise, Display, Error, Kept, Lod, Notes, PixelType, Settings, Shot, World, prepare};
use vellus_scene::Scene;

/// The size of a picture before its scene is read.
const SIZE: [usize; 2] = [960, 640];

/// The longest pass: Ctrl-C, checkpoints and the bar wait for its end.
const PASS: Duration = Duration::from_secs(2);

/// A scene that was read, and the identity of its picture.
pub struct Loaded {
    scene: Scene,
    /// The options, with the size of the picture and the part to render.
    args: Args,
    pub identity: Digest,
    /// When and with which lens the picture is taken.
    notes: Notes,
    seconds: f64,
    is_metered: bool,
    /// The exposure, if it is known already.
    pub stops: Option<f32>,
    /// The frames that help to fill its radiance cache.
    shot: Option<Shot>,
}

impl Loaded {
    /// Reads or grows the scene. `kept` is what the frames of an animation share.
    pub fn new(args: &Args, kept: Arc<Kept>) -> Result<Self> {
        let start = Instant::now();
        let opened = args.input.open_with(&args.options()?)?;
        let args = args.sized(&opened)?;
        let identity = args.digest(opened.sources.digest())?;
        let seconds = start.elapsed().as_secs_f64();
        let notes = opened.shot_notes(args.settings().size);
        let frame = args.input.frame.filter(|_| !opened.earlier.is_empty());
        let shot = frame.map(|frame| Shot { frame: frame as i32, earlier: opened.earlier, kept });
        let (scene, is_metered) = (opened.scene, opened.is_metered);
        Ok(Loaded { scene, args, identity, notes, seconds, is_metered, stops: None, shot })
    }

    /// The exposure of all frames of an animation: that of its first frame. `None` if this frame needs none.
    pub fn first_stops(&self) -> Result<Option<f32>> {
        if !self.is_metered {
            return Ok(None);
        }
        let mut first = self.args.clone();
        first.input.frame = None;
        let mut scene = first.input.open_quietly(first.staging())?.scene;
        let settings = first.settings();
        prepare(&mut scene, settings.size, first.min_pixel_width, first.lod);
        Ok(first.model.world(scene)?.metered())
    }
}

/// Renders a scene, and writes the result: a picture, and a film if `--samples` is given. `pictures` is how many
/// pictures will be written to the folder of this one.
///
/// # Errors
/// [`Interrupted`](crate::exit::Interrupted) if a signal stopped it; the message says what was kept.
pub fn run(loaded: Loaded, interrupt: &Interrupt, pictures: u64, viewer: &mut Option<Viewer>) -> Result<()> {
    let args = &loaded.args.clone();
    let denoiser = args.denoise.then(Denoiser::load).transpose()?;
    let (world, job) = prepare_job(args, loaded)?;
    let job = Job { denoiser: denoiser.map(|denoiser| Box::new(denoiser) as Box<dyn Denoise>), pictures, ..job };
    let mut screen = Screen::new(&args.output, viewer);
    let outcome = job.run(&world, &*interrupt.stop, |event| {
        if matches!(event, Event::Started(_)) {
            interrupt.set_immediate(false);
        }
        screen.show(event);
    });
    drop(screen);
    let Outcome { end, checkpoint, kept, .. } = outcome.map_err(|error| explain(args, error))?;
    if end != End::Interrupted {
        return Ok(());
    }
    let samples = checkpoint.film.samples();
    if samples == 0 {
        return Err(interrupt.error("rendering had not begun, no file was changed".to_owned()).into());
    }
    let film = kept.as_ref().map_or(String::new(), |path| format!(" and {}", path.display()));
    let next = if kept.is_some() { ", and the same command with --resume continues" } else { "" };
    let output = args.output.display();
    Err(interrupt.error(format!("{samples} samples a pixel are in {output}{film}{next}")).into())
}

/// Prepares a scene for rays, and the job of its picture.
fn prepare_job(args: &Args, loaded: Loaded) -> Result<(World, Job)> {
    let start = Instant::now();
    let Loaded { mut scene, identity, notes: of_shot, seconds, is_metered, stops, shot, .. } = loaded;
    let settings = args.settings();
    prepare(&mut scene, settings.size, args.min_pixel_width, args.lod);
    let mut notes = vec![
        ("vellus_version".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
        ("vellus_command".to_owned(), typed_command()),
        ("vellus_scene".to_owned(), args.input.scene.display().to_string()),
    ];
    notes.extend(args.identity(&settings).notes(identity));
    notes.extend(of_shot);
    notes.extend(fiber_notes(&scene));
    if args.staging.background == Some(Backdrop::Transparent) {
        notes.push((BACKGROUND_NOTE.to_owned(), "transparent".to_owned()));
    }
    let mut world = args.model.world(scene)?;
    args.input.warn(&world.unreached())?;
    let stops = if is_metered && stops.is_none() { world.metered() } else { stops };
    if let Some(stops) = stops {
        world.scale_lights(stops.exp2());
        notes.push(("vellus_light_stops".to_owned(), stops.to_string()));
    }
    note!("{}, ready in {:.1} s", world.summary(), seconds + start.elapsed().as_secs_f64());
    notes.push(("vellus_segments".to_owned(), world.segments().to_string()));
    let renderer = args.device.renderer(&world, &settings, &world.layout(&args.layers)).map_err(on_cpu)?;
    renderer.message.iter().for_each(|message| note!("{message}"));
    notes.extend(renderer.notes);
    args.display.measure(&world, &mut notes);
    let display = args.display.display(&notes)?;
    Ok((world, Job { tracer: renderer.tracer, shot, ..args.job(settings, identity, notes, display) }))
}

/// Adds the option that renders without a GPU.
pub fn on_cpu(error: Error) -> anyhow::Error {
    anyhow!("{error}; use --device cpu")
}

/// Names the options and files that an error is about.
fn explain(args: &Args, error: Error) -> anyhow::Error {
    let text = error.to_string();
    match error {
        Error::OtherCheckpoint(what) => {
            let path = Store::beside(&args.output).path().display().to_string();
            anyhow!("{path} {what}: delete it, or render without --resume")
        }
        Error::NotWritten { rescue, complete, source, .. } => {
            let next = match rescue {
                Rescue::Saved(path) => {
                    let gaps = if complete { "" } else { " --allow-gaps" };
                    let (path, output) = (path.display(), args.output.display());
                    format!(" (continue with --resume, or: vellus merge{gaps} {path} -o {output})")
                }
                Rescue::LastCheckpoint(_) => " (continue with --resume)".to_owned(),
                Rescue::Lost(_) => String::new(),
            };
            anyhow::Error::from(*source).context(text + &next)
        }
        Error::Device(_) => on_cpu(error),
        Error::DeviceLost { .. } => anyhow!("{text} (continue with --device cpu --resume)"),
        other => other.into(),
    }
}

/// This command, as it was typed.
pub fn typed_command() -> String {
    let arguments = std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned());
    std::iter::once("vellus".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")
}

impl Args {
    /// How paths are traced.
    pub fn settings(&self) -> Settings {
        Settings {
            size: self.size.unwrap_or(SIZE),
            crop: self.crop,
            mode: self.mode,
            filter: self.filter,
            seed: self.seed,
            max_depth: self.max_depth,
            clamp_indirect: self.clamp_indirect,
            radiance_cache: self.radiance_cache,
        }
    }

    /// How the scene is opened.
    fn options(&self) -> Result<vellus_open::Options> {
        let is_frame = self.input.frame.is_some_and(|frame| frame == f64::from(frame as i32));
        // These change strands for the camera.
        let changes = self.min_pixel_width > 0.0 || self.lod != Lod::Off;
        let earlier = if self.radiance_cache.is_some() && is_frame && !changes { Shot::FRAMES - 1 } else { 0 };
        Ok(vellus_open::Options { earlier, ..self.input.options(Some(self.staging()))? })
    }

    /// How the scene is staged.
    pub fn staging(&self) -> Staging {
        Staging { aspect: self.size.map(|[w, h]| w as f32 / h as f32), ..self.staging.clone() }
    }

    /// The options with the size of the picture, and the part of it to render: those of the command line, or those of
    /// the file.
    fn sized(&self, opened: &Opened) -> Result<Args> {
        let size = self.size.unwrap_or_else(|| opened.size());
        let crop = self.crop.or_else(|| opened.crop(size));
        check_crop(size, crop)?;
        Ok(Args { size: Some(size), crop, ..self.clone() })
    }

    /// Everything but the scene that can change a pixel.
    fn identity<'a>(&'a self, settings: &'a Settings) -> Identity<'a> {
        Identity {
            settings,
            layers: &self.layers,
            model: self.model.model.name(),
            eta_m: self.model.eta_m,
            min_pixel_width: self.min_pixel_width,
            lod: self.lod,
        }
    }

    /// What tells this picture from others. `sources` is the digest of the files that the scene was read from.
    fn digest(&self, sources: Digest) -> Result<Digest> {
        let builder = self.identity(&self.settings()).digest(sources);
        Ok(vellus_open::identify(builder, &self.input.scene, &self.options()?).finish())
    }

    fn job(&self, settings: Settings, identity: Digest, notes: Notes, display: Display) -> Job {
        let options = Options {
            settings,
            layers: self.layers.clone(),
            samples: self.samples.clone().unwrap_or(0..self.spp),
            exact: self.samples.is_some(),
            noise: self.noise,
            time: self.time,
            pass: PASS,
            identity,
            notes,
        };
        let picture = Picture {
            layers: self.layers.clone(),
            pixel_type: if self.float { PixelType::Float } else { PixelType::Half },
            display,
            ..Picture::new(&self.output)
        };
        let job = Job::new(options, picture);
        // A frame of an animation is complete. These options say that a single picture may be continued.
        let continues = self.resume || self.checkpoint.is_some() || self.samples.is_some();
        Job {
            film: self.samples.is_some(),
            resume: self.resume,
            interval: self.checkpoint.unwrap_or(job.interval),
            preview: self.preview,
            any_end_completes: self.frames.is_some() || !continues,
            ..job
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

    #[derive(Parser)]
    struct Command {
        #[command(flatten)]
        args: Args,
    }

    /// The identity of `vellus render` with these options.
    fn of(options: &str) -> Digest {
        let args = Command::parse_from(["vellus"].into_iter().chain(options.split_whitespace())).args;
        args.digest(Sources::new().digest()).unwrap()
    }

    #[test]
    fn every_option_that_changes_a_pixel_changes_the_identity() {
        let all = "|cat|--small|--size 640x960|--crop 0,0,8,8|--mode near|--filter box|--seed 1|--max-depth 9|\
            --min-pixel-width 0.5|--model yan2015|--model yan2015 --eta-m 1.5|--layers beauty|--strands 50%|\
            x.usda --width 0.5|x.usda --camera a|x.usda --frame 2|x.usda --set kappa=0.5|\
            x.usda --shutter off|x.usda --shutter 0:1|\
            x.usda --set kappa=0.5 --override|x.usda --view 1,2|x.usda --light sun|x.usda --background black|\
            x.usda --background transparent|cat --view 1,2|x.usda --clamp-indirect 2|x.usda --radiance-cache 8|\
            cat --set kappa=0.5|cat --fiber dog|cat --light studio|--lod auto|--lod 1";
        let mut seen = HashMap::new();
        for options in all.split('|') {
            assert_eq!(seen.insert(of(options), options), None, "{options}");
        }
        assert_eq!(seen.len(), 33);
    }

    #[test]
    fn what_changes_no_pixel_does_not_change_the_identity() {
        let same = "--spp 7|--samples 3..9|--threads 1|-o elsewhere/x.exr|--exposure 2|--noise 0.1 --time 9s --float|\
            --resume --checkpoint 1s";
        for options in same.split('|') {
            assert_eq!(of(options), of(""), "{options}");
        }
        assert_eq!(of("a/x.usda"), of("./a/../b/x.usda"));
        // A GPU computes other samples of the same picture: both may be merged.
        for options in ["--device gpu", "--device auto"] {
            assert_eq!(of(options), of(""), "{options}");
        }
    }

    /// Films contain the digest. It must be the same on every machine and in every release. It changes with
    /// [`PICTURE_VERSION`], the shipped tables and the fields of the digest, and with nothing else.
    #[test]
    fn the_identity_is_the_same_everywhere() {
        assert_eq!((PICTURE_VERSION, of("cat --small").short().as_str()), (10, "a02173946a07670d"));
    }
}
