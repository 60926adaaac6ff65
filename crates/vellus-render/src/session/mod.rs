//! Render sessions: passes until a goal is reached, with progress, cancellation, checkpoints and resumption.
//!
//! A [`Job`] does everything for one picture: it resumes, renders, writes checkpoints, and writes the picture. It
//! reports each [`Event`] and prints nothing. The command `vellus render` runs one job for each picture.
//!
//! A job is built of smaller parts, which can be used without it. A [`Session`] renders one picture, or a range of its
//! samples, into a [`Checkpoint`] and writes no file. [`Store`] keeps checkpoints. [`Picture`] writes OpenEXR and PNG
//! files. [`Merge`] adds sample ranges that were rendered separately. [`Identity`] tells pictures apart.

mod event;
mod frames;
mod goals;
mod hint;
mod identity;
mod job;
mod keeper;
mod merge;
mod notes;
mod picture;
mod store;
mod text;

pub use crate::error::Rescue;
pub use crate::film::attributes::camera_notes;
pub use event::Event;
pub use frames::Frames;
pub use goals::{End, Goals, State};
pub use hint::Hint;
pub use identity::{IDENTITY_NOTE, Identity};
pub use job::{Job, Outcome};
pub use merge::{Merge, Merged};
pub use notes::fiber_notes;
pub use picture::{BACKGROUND_NOTE, Picture, SAMPLES_NOTE, end_notes, is_finished};
pub use store::{Found, Store, read_film, write_film};

use crate::error::Error;
use crate::fill::{Fill, Shot};
use crate::film::checkpoint::{Checkpoint, MAX_SAMPLES};
use crate::film::tiles::{is_planned_at, next_plan};
use crate::film::{Film, Layer, picture::Notes};
use crate::integrator::cache::{RadianceCache, next_growth, samples_for};
use crate::integrator::settings::Settings;
use crate::packed::SampleTracer;
use crate::render::Statistics;
use crate::world::World;
use std::ops::Range;
use std::time::{Duration, Instant};
use vellus_io::{Digest, Progress};

/// What a session renders, and when it ends.
#[derive(Clone, Debug)]
pub struct Options {
    /// How paths are traced.
    pub settings: Settings,
    /// Layers of the film. Beauty, alpha, the second moment and the fibres' coverage are always kept.
    pub layers: Vec<Layer>,
    /// The samples of each pixel, within [0, [`MAX_SAMPLES`]].
    pub samples: Range<u64>,
    /// Refuse to resume from a checkpoint with samples beyond [`Options::samples`]: for ranges that will be merged
    /// with others.
    pub exact: bool,
    /// End when the picture's noise is this low: see [`Film::noise`]. Above 0. It is tested at fixed numbers of
    /// samples, so that the picture does not depend on [`Options::pass`].
    ///
    /// Sampling is then adaptive: noisy parts of the picture get more samples. Exceptions are [`Options::exact`], and
    /// samples that do not begin with 0.
    pub noise: Option<f64>,
    /// End after rendering this long.
    pub time: Option<Duration>,
    /// A pass takes about this long: the callback of [`Session::run`] is called that often. 2 seconds by default.
    pub pass: Duration,
    /// What tells this picture from others: see [`Identity`].
    pub identity: Digest,
    /// Text attributes of the checkpoint: names and values.
    pub notes: Notes,
}

impl Options {
    /// So many samples a pixel of the beauty, without other goals.
    pub fn new(settings: Settings, samples: u64) -> Self {
        Options {
            settings,
            layers: vec![Layer::Beauty],
            samples: 0..samples,
            exact: false,
            noise: None,
            time: None,
            pass: Duration::from_secs(2),
            identity: Digest::default(),
            notes: Vec::new(),
        }
    }

    fn validate(&self) -> Result<(), Error> {
        let fail = |what: String| Err(Error::Settings(what));
        let Settings { size, .. } = self.settings;
        if !size.iter().all(|n| (1..=MAX_SIZE).contains(n)) {
            return fail(format!("the picture's size is {size:?}: width and height must be in [1, {MAX_SIZE}]"));
        }
        let [x, y, width, height] = self.settings.area();
        let inside = |first: usize, count: usize, all: usize| count > 0 && first < all && count <= all - first;
        if !(inside(x, width, size[0]) && inside(y, height, size[1])) {
            return fail(format!("the crop {:?} is not within the picture's {size:?}", [x, y, width, height]));
        }
        if self.settings.radiance_cache == Some(0) {
            return fail("the radiance cache needs at least 1 sample a pixel".to_owned());
        }
        let Range { start, end } = self.samples;
        if start >= end || end > MAX_SAMPLES {
            return fail(format!("the samples {start}..{end} must be a range within 0..{MAX_SAMPLES}, not empty"));
        }
        match self.noise {
            Some(noise) if noise.is_nan() || noise <= 0.0 => fail(format!("the noise {noise} must be above 0")),
            _ => Ok(()),
        }
    }
}

/// The largest width or height of a picture, in pixels.
pub const MAX_SIZE: usize = 1 << 15;

/// What the callback of [`Session::run`] sees after each pass.
#[derive(Clone, Copy, Debug)]
pub struct Pass<'a> {
    /// The samples so far.
    pub checkpoint: &'a Checkpoint,
    /// How far the run is.
    pub state: State,
    /// The goals.
    pub goals: &'a Goals,
    /// Rays and rejected samples of this run.
    pub statistics: &'a Statistics,
}

/// A picture, or a range of its samples, in the making.
///
/// ```
/// use std::sync::atomic::{AtomicBool, Ordering};
/// use vellus_render::session::{End, Options, Session};
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
/// let world = World::new(scene)?;
/// let options = Options::new(Settings::new([16, 16]), 4);
///
/// // A caller cancels after the first pass.
/// let stop = AtomicBool::new(false);
/// let mut session = Session::new(&world, options.clone())?;
/// let end = session.run(&stop, |_| -> Result<(), Error> {
///     stop.store(true, Ordering::Relaxed);
///     Ok(())
/// })?;
/// assert_eq!(end, End::Interrupted);
/// let checkpoint = session.into_checkpoint();
/// assert_eq!(checkpoint.film.samples(), 1);
///
/// // Another session continues.
/// let mut session = Session::new(&world, options)?;
/// session.resume(checkpoint)?;
/// let end = session.run(&(), |_| Ok::<(), Error>(()))?;
/// assert_eq!((end, session.film().samples()), (End::Samples, 4));
/// # Ok::<(), Error>(())
/// ```
#[derive(Debug)]
pub struct Session<'w> {
    world: &'w World,
    settings: Settings,
    /// Computes the samples instead of the processor.
    tracer: Option<Box<dyn SampleTracer>>,
    /// The frames that fill the cache, too.
    shot: Option<Shot>,
    /// Filled before the first pass, if the settings have one. It grows with the samples.
    cache: Option<RadianceCache>,
    goals: Goals,
    exact: bool,
    pass: Duration,
    checkpoint: Checkpoint,
    statistics: Statistics,
}

impl<'w> Session<'w> {
    /// A session without samples.
    ///
    /// # Errors
    /// [`Error::Settings`] if an option is out of its range. [`Error::Memory`] if the film has no room.
    pub fn new(world: &'w World, options: Options) -> Result<Self, Error> {
        options.validate()?;
        let Options { settings, mut layers, samples, exact, noise, time, pass, identity, notes } = options;
        if settings.radiance_cache.is_some() {
            layers.push(Layer::CacheError);
        }
        let film = Film::try_new(settings.size, settings.area(), world.layout(&layers))?;
        let goals = Goals { samples: samples.end - samples.start, noise, time };
        let empty = samples.start..samples.start;
        let checkpoint = Checkpoint { identity, samples: empty, planned: samples.end, notes, film };
        let statistics = Statistics::default();
        Ok(Session {
            world,
            settings,
            tracer: None,
            shot: None,
            cache: None,
            goals,
            exact,
            pass,
            checkpoint,
            statistics,
        })
    }

    /// Lets another tracer compute the samples: that of a GPU. It must be one for the world, the settings and the
    /// layers of this session.
    pub fn set_tracer(&mut self, tracer: Box<dyn SampleTracer>) {
        self.tracer = Some(tracer);
    }

    /// Lets the frames before fill the radiance cache, too.
    pub fn set_shot(&mut self, shot: Shot) {
        self.shot = Some(shot);
    }

    /// Continues from the samples of an earlier session. Its notes are not taken over.
    ///
    /// # Errors
    /// [`Error::OtherCheckpoint`] if it is of another picture, begins with another sample, or has samples that
    /// [`Options::exact`] excludes, or if it has adaptive samples and this session cannot continue them. The session is
    /// then as before.
    pub fn resume(&mut self, kept: Checkpoint) -> Result<(), Error> {
        let own = &mut self.checkpoint;
        if kept.identity != own.identity || !kept.film.fits(&own.film) {
            let what = "is of another picture: the scene, a file that it reads, or an option has changed";
            return Err(Error::OtherCheckpoint(what.to_owned()));
        }
        if kept.samples.start != own.samples.start || (self.exact && kept.samples.end > own.planned) {
            let (start, end) = (own.samples.start, own.planned);
            let what = format!("has the samples {:?}, which are not in {start}..{end}", kept.samples);
            return Err(Error::OtherCheckpoint(what));
        }
        if kept.film.is_adaptive() && self.exact {
            let what = "has other numbers of samples in each part of the picture, because it was rendered with a goal \
                        of noise: continue without a range of samples";
            return Err(Error::OtherCheckpoint(what.to_owned()));
        }
        (own.samples, own.film) = (kept.samples, kept.film);
        own.planned = own.planned.max(own.samples.end);
        Ok(())
    }

    /// Renders passes until a goal is reached or `progress` cancels, and returns which. The samples of a cancelled pass
    /// are discarded, those of earlier passes stay.
    ///
    /// After each pass the share of the work that is done is reported to `progress`, and `on_pass` is called: it may
    /// show the picture or write a checkpoint.
    ///
    /// # Errors
    /// What `on_pass` returns; rendering then ends after this pass.
    pub fn run<E: From<Error>>(
        &mut self,
        progress: &dyn Progress,
        mut on_pass: impl FnMut(&Pass<'_>) -> Result<(), E>,
    ) -> Result<End, E> {
        match self.fill_cache(progress, &mut |done| progress.report(done, "filling the radiance cache")) {
            Err(Error::Cancelled) => return Ok(End::Interrupted),
            filled => filled?,
        }
        let start = Instant::now();
        let (mut count, mut each) = (1, 0.0);
        loop {
            let film = &self.checkpoint.film;
            let state = State { samples: film.samples(), noise: film.noise(), spent: start.elapsed(), each };
            progress.report(self.goals.done(&state), "rendering");
            if each > 0.0 {
                let Session { checkpoint, goals, statistics, .. } = &*self;
                on_pass(&Pass { checkpoint, state, goals, statistics })?;
            }
            if let Some(end) = self.goals.reached(&state) {
                return Ok(end);
            }
            let mut samples = count.min(self.goals.samples_left(&state)).max(1).min(self.goals.next_test(&state));
            if self.is_adaptive() {
                samples = samples.min(next_plan(state.samples) - state.samples);
            }
            if let Some(least) = self.settings.radiance_cache {
                let first = self.checkpoint.samples.end;
                samples = samples.min(next_growth(least, first) - first);
            }
            let began = Instant::now();
            match self.fill_cache(progress, &mut |_| {}).and_then(|()| self.add(samples, progress)) {
                Ok(()) => {}
                Err(Error::Cancelled) => return Ok(End::Interrupted),
                Err(error) => return Err(error.into()),
            }
            // Never 0, which stands for "unknown".
            each = (began.elapsed().as_secs_f64() / samples as f64).max(1e-9);
            count = ((self.pass.as_secs_f64() / each) as u64).clamp(1, 2 * samples);
        }
    }

    /// Fills the radiance cache for the next samples, if the settings ask for one and samples are missing.
    /// [`Session::run`] does it, too.
    /// `report` receives the share that is done.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if `progress` stopped it. The session then has no cache.
    pub fn fill_cache(&mut self, progress: &dyn Progress, report: &mut dyn FnMut(f64)) -> Result<(), Error> {
        let Some(least) = self.settings.radiance_cache else { return Ok(()) };
        let (next, layout) = (self.checkpoint.samples.end, self.checkpoint.film.layout());
        if self.checkpoint.film.samples() < self.goals.samples {
            let (cache, samples) = (self.cache.take(), samples_for(least, next));
            let fill = Fill { settings: &self.settings, layout, shot: self.shot.as_ref(), progress };
            self.cache = Some(fill.grow(self.world, cache, samples, report)?);
        }
        Ok(())
    }

    /// The radiance cache, once it is filled.
    pub fn cache(&self) -> Option<&RadianceCache> {
        self.cache.as_ref()
    }

    /// Do noisy parts of the picture get more samples? A film that has such samples already goes on so.
    fn is_adaptive(&self) -> bool {
        let possible = !self.exact && self.checkpoint.samples.start == 0;
        self.checkpoint.film.is_adaptive() || (possible && self.goals.noise.is_some())
    }

    /// Renders this many samples a pixel more.
    fn add(&mut self, samples: u64, progress: &dyn Progress) -> Result<(), Error> {
        if progress.is_cancelled() {
            return Err(Error::Cancelled);
        }
        let first = self.checkpoint.samples.end;
        let next = first..first + samples;
        if self.is_adaptive() && is_planned_at(first) {
            self.checkpoint.film.plan();
        }
        let (settings, film) = (&self.settings, &mut self.checkpoint.film);
        self.statistics += match &mut self.tracer {
            Some(tracer) => self.world.render_packed(settings, film, next.clone(), progress, &mut **tracer)?,
            None => self.world.render_cached(settings, self.cache.as_ref(), film, next.clone(), progress)?,
        };
        self.checkpoint.samples.end = next.end;
        Ok(())
    }

    /// The samples so far.
    pub fn film(&self) -> &Film {
        &self.checkpoint.film
    }

    /// The samples so far, with what [`Session::resume`] needs to continue from them.
    pub fn checkpoint(&self) -> &Checkpoint {
        &self.checkpoint
    }

    /// The notes of the checkpoint, to add more.
    pub fn notes_mut(&mut self) -> &mut Notes {
        &mut self.checkpoint.notes
    }

    /// Ends the session.
    pub fn into_checkpoint(self) -> Checkpoint {
        self.checkpoint
    }

    /// Rays and rejected samples of this session.
    pub fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// The goals of this session.
    pub fn goals(&self) -> &Goals {
        &self.goals
    }
}
