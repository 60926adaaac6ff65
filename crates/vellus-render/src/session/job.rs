//! One picture from its checkpoint to its files.

use super::keeper::Keeper;
use super::notes::{layers_note, take_layers};
use super::{End, Event, Hint, Options, Pass, Picture, Session, end_notes, write_film};
use crate::error::Error;
use crate::fill::Shot;
use crate::film::attributes::camera_notes;
use crate::film::checkpoint::Checkpoint;
use crate::film::denoised::Denoise;
use crate::packed::SampleTracer;
use crate::world::World;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use vellus_io::{Progress, cpu_time};

/// Everything that is done for one picture. A job
///
/// 1. checks that the disk has room for its files,
/// 2. continues from the checkpoint or from a rescued film, if [`Job::resume`] is set,
/// 3. fills the radiance cache, if the settings ask for one, renders, and writes checkpoints meanwhile,
/// 4. writes the film, if [`Job::film`] is set, and the picture,
/// 5. removes the checkpoint of a finished picture, or updates that of an unfinished one.
///
/// If a file cannot be written, the samples are kept: see [`Store::rescue`](super::Store::rescue). A job prints
/// nothing. It reports each [`Event`] to a callback.
///
/// ```
/// use vellus_render::session::{End, Event, Job, Options, Picture};
/// use vellus_render::{Error, Settings, World};
/// # use vellus_scene::{Basis, Camera, Look, Scene, Strands};
/// # use glam::{Vec3, Vec4};
/// # let strands = Strands {
/// #     name: "fur".to_owned(), basis: Basis::Linear, starts: vec![0, 2],
/// #     points: vec![Vec4::new(-1.0, 0.0, 0.0, 0.1), Vec4::new(1.0, 0.0, 0.0, 0.1)],
/// #     moved: None, normals: None, root_uv: None, look: 0, varying: vec![],
/// # };
/// # let look = Look::constant("red-fox", vellus::Fiber::preset(vellus::Species::RedFox));
/// # let scene = Scene { strands: vec![strands], looks: vec![look], ..Scene::default() };
/// # let folder = tempfile::tempdir().unwrap();
/// # let folder = folder.path();
/// let world = World::new(scene)?;
/// let options = Options::new(Settings::new([16, 16]), 4);
/// let job = Job { resume: true, ..Job::new(options, Picture::new(folder.join("fur.exr"))) };
///
/// // An `AtomicBool` in place of `()` could stop it.
/// let outcome = job.run(&world, &(), |event| match event {
///     Event::Pass(pass) => eprintln!("{:.0} %: {pass}", 100.0 * pass.goals.done(&pass.state)),
///     other => eprintln!("{other}"),
/// })?;
/// assert_eq!((outcome.end, outcome.checkpoint.film.samples()), (End::Samples, 4));
/// assert_eq!(outcome.files, [folder.join("fur.exr"), folder.join("fur.png")]);
/// // The picture is complete: no checkpoint stays.
/// assert_eq!(outcome.kept, None);
/// # Ok::<(), Error>(())
/// ```
#[derive(Debug)]
pub struct Job {
    /// What is rendered. A pass takes at most [`Job::interval`].
    pub options: Options,
    /// How the film becomes a picture. The notes of the options and those of [`end_notes`] are added to its notes.
    pub picture: Picture,
    /// Write the film too, for [`Merge`](super::Merge): beside the picture, with the extension `.film`. An interrupted
    /// job writes no film.
    pub film: bool,
    /// Computes the samples instead of the processor: see [`Session::set_tracer`].
    pub tracer: Option<Box<dyn SampleTracer>>,
    /// The frames before, in a shot where only the camera moves: see [`Session::set_shot`].
    pub shot: Option<Shot>,
    /// The picture is also written without noise.
    pub denoiser: Option<Box<dyn Denoise>>,
    /// Continue from samples that an earlier job kept.
    pub resume: bool,
    /// A checkpoint is written this often. 60 seconds by default.
    pub interval: Duration,
    /// Write a PNG after the first pass.
    pub preview: bool,
    /// Is the picture complete if it ends by noise or time? Otherwise its checkpoint stays, so that a later job can
    /// continue.
    pub any_end_completes: bool,
    /// How many pictures of this size are still to be written to the same disk, this one included. For the check of
    /// free space; 1 by default.
    pub pictures: u64,
}

/// How a job ended.
#[derive(Debug)]
pub struct Outcome {
    /// Why rendering ended.
    pub end: End,
    /// All samples. A job that was interrupted before its first sample has none, and has written no file.
    pub checkpoint: Checkpoint,
    /// The files of the picture.
    pub files: Vec<PathBuf>,
    /// The checkpoint, if it was kept: a job with [`Job::resume`] continues from it.
    pub kept: Option<PathBuf>,
}

impl Job {
    /// Renders a picture and writes it, without a film, a denoiser or a preview. It does not resume.
    pub fn new(options: Options, picture: Picture) -> Self {
        Job {
            options,
            picture,
            film: false,
            tracer: None,
            shot: None,
            denoiser: None,
            resume: false,
            interval: Duration::from_secs(60),
            preview: false,
            any_end_completes: false,
            pictures: 1,
        }
    }

    /// Runs the job, until a goal is reached or `progress` cancels. After a cancellation, the picture of the samples so
    /// far is written, and its checkpoint is kept.
    ///
    /// # Errors
    /// [`Error::Settings`] if an option is out of its range. [`Error::Write`] if the disk has no room. [`Error::Read`],
    /// [`Error::Film`] or [`Error::OtherCheckpoint`] if the checkpoint cannot be used. [`Error::NotWritten`] if the
    /// film or the picture cannot be written: it says where the samples are. [`Error::DeviceLost`] if the tracer fails:
    /// the samples so far are written like those of a cancelled job.
    pub fn run(
        mut self,
        world: &World,
        progress: &dyn Progress,
        mut report: impl FnMut(Event<'_>),
    ) -> Result<Outcome, Error> {
        self.options.validate()?;
        self.options.pass = self.options.pass.min(self.interval);
        self.options.notes.extend(camera_notes(&world.camera(), self.options.settings.size));
        self.options.notes.push(layers_note(&self.picture.layers));
        let mut keeper = Keeper::new(&self.picture.path);
        self.check_space(world, &keeper)?;
        let mut session = Session::new(world, self.options.clone())?;
        if let Some(tracer) = self.tracer.take() {
            session.set_tracer(tracer);
        }
        if let Some(shot) = self.shot.take() {
            session.set_shot(shot);
        }
        if self.resume {
            keeper.resume(&mut session, &mut report)?;
        }
        let (start, cpu) = (Instant::now(), cpu_time());
        match session.fill_cache(progress, &mut |done| report(Event::Filling(done))) {
            Err(Error::Cancelled) => {}
            filled => filled?,
        }
        if let Some(cache) = session.cache() {
            report(Event::Filled { cells: cache.cells(), bytes: cache.bytes(), time: start.elapsed() });
        }
        report(Event::Started(&session));
        let before = session.film().total_samples();
        let start = Instant::now();
        let (end, lost) = match self.render(&mut session, &mut keeper, progress, &mut report) {
            Err(Error::Device(what)) => (End::Interrupted, Some(what)),
            result => (result?, None),
        };
        let time = start.elapsed();
        report(Event::Rendered { session: &session, time });
        self.report_statistics(&session, &mut report);
        if let (Some(from), Some(to)) = (cpu, cpu_time()) {
            let samples = session.film().total_samples() - before;
            report(Event::CpuTime { time: to - from, samples });
        }
        let mut checkpoint = session.into_checkpoint();
        if checkpoint.film.samples() == 0 {
            // Only an interruption or a lost device ends a job without samples.
            let outcome = Outcome { end, checkpoint, files: Vec::new(), kept: None };
            return lost.map_or(Ok(outcome), |what| Err(Error::Device(what)));
        }
        checkpoint.notes.push(("vellus_seconds".to_owned(), format!("{:.1}", time.as_secs_f64())));
        let samples = checkpoint.film.samples();
        let outcome = self.write(world, checkpoint, end, &mut keeper, &mut report)?;
        match lost {
            Some(what) => Err(Error::DeviceLost { what, samples, kept: outcome.kept }),
            None => Ok(outcome),
        }
    }

    fn check_space(&self, world: &World, keeper: &Keeper) -> Result<(), Error> {
        let [_, _, width, height] = self.options.settings.area();
        let pixels = (width * height) as u64;
        let layout = world.layout(&self.options.layers);
        let pictures = self.picture.max_bytes(pixels, &layout).saturating_mul(self.pictures);
        // Most pixels show at most four things, in 12 bytes each.
        let counts = if layout.has_counts() { 48 } else { 0 };
        keeper.store().check_space(pictures, pixels * (layout.bytes_per_pixel() + counts) as u64, &self.picture.path)
    }

    /// Renders. After the first pass it writes the preview, and from time to time a checkpoint.
    fn render(
        &self,
        session: &mut Session,
        keeper: &mut Keeper,
        progress: &dyn Progress,
        report: &mut dyn FnMut(Event<'_>),
    ) -> Result<End, Error> {
        let (mut kept, mut preview) = (Instant::now(), self.preview);
        session.run(progress, |pass| {
            report(Event::Pass(pass));
            if std::mem::take(&mut preview) {
                self.write_preview(pass, report);
            }
            if kept.elapsed() >= self.interval {
                keeper.keep(pass.checkpoint, report);
                kept = Instant::now();
            }
            Ok::<(), Error>(())
        })
    }

    fn write_preview(&self, pass: &Pass, report: &mut dyn FnMut(Event<'_>)) {
        let path = self.picture.path.with_extension("png");
        let film = &pass.checkpoint.film;
        match Picture::new(&path).write(film, None) {
            Ok(_) => report(Event::Preview { path: &path, samples: film.samples() }),
            Err(error) => report(Event::PreviewFailed(error)),
        }
    }

    /// Reports samples that were left out, full pixels, paths that were cut off, and light that was clamped.
    fn report_statistics(&self, session: &Session, report: &mut dyn FnMut(Event<'_>)) {
        let (film, statistics) = (session.film(), session.statistics());
        if statistics.rejected > 0 {
            report(Event::Rejected(statistics.rejected));
        }
        if let full @ 1.. = film.full_pixels() {
            report(Event::FullPixels(full));
        }
        if let Some(depth) = self.options.settings.max_depth {
            let share = statistics.cut() / film.total_samples().max(1) as f64;
            report(Event::Cut { depth, share });
        }
        if let Some(limit) = self.options.settings.clamp_indirect {
            report(Event::Clamped { limit, share: statistics.removed() });
        }
    }

    /// Writes the film and the picture, and keeps or removes the checkpoint.
    fn write(
        mut self,
        world: &World,
        checkpoint: Checkpoint,
        end: End,
        keeper: &mut Keeper,
        report: &mut dyn FnMut(Event<'_>),
    ) -> Result<Outcome, Error> {
        let interrupted = end == End::Interrupted;
        if self.film && !interrupted {
            let path = self.picture.path.with_extension("film");
            write_film(&path, &checkpoint).map_err(|error| keeper.rescue(&checkpoint, error))?;
            report(Event::WroteFilm(&path));
            let Checkpoint { samples, planned, .. } = &checkpoint;
            if samples.end < *planned {
                report(Event::IncompleteFilm { samples: samples.clone(), planned: samples.start..*planned });
            }
        }
        let complete = end == End::Samples || (!interrupted && self.any_end_completes);
        let kept = if complete { None } else { keeper.keep(&checkpoint, report) };
        let mut notes = checkpoint.notes.clone();
        take_layers(&mut notes);
        self.picture.notes.extend(notes);
        self.picture.notes.extend(end_notes(&checkpoint.film, end));
        let files = self.picture.write_denoised(&checkpoint.film, self.denoiser.as_deref(), &mut *report);
        let files = files.map_err(|error| keeper.rescue(&checkpoint, error))?;
        if complete {
            keeper.remove();
        }
        if let Some(hint) = Hint::new(world, &checkpoint.film, self.picture.display.exposure) {
            report(Event::Hint(hint));
        }
        Ok(Outcome { end, checkpoint, files, kept })
    }
}
