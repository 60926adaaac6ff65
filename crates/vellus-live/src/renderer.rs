//! What the thread of the engine does: it takes jobs, and refines the picture while there are none.

use crate::engine::{Job, Reply, Shared};
use crate::files::Files;
use crate::frame::{Frame, Header};
use crate::save::{self, Save};
use crate::session::{Effect, Session};
use serde_json::Value;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use vellus_render::{Curves, Denoised, Film};
use vellus_scene::Strands;
use vellus_usd::Format;

/// The time in seconds in which the first picture after a change should be rendered.
const FIRST: f64 = 0.035;

/// The largest width of a pixel in that picture, in pixels of the full resolution.
const COARSEST: usize = 16;

/// Pictures are sent at most this often while the picture refines.
const BETWEEN: Duration = Duration::from_millis(250);

/// The picture that is refined.
struct Picture {
    film: Film,
    coarse: usize,
    /// Whether pages have it in this form.
    sent: Option<Instant>,
    /// With the samples that the picture had.
    denoised: Option<(u64, Denoised)>,
}

/// What the denoiser does, on another thread.
#[derive(Default)]
struct Denoising {
    /// Counts pictures: what was denoised for an earlier one is dropped.
    picture: u64,
    /// When it began, if it is at work.
    since: Option<Instant>,
    /// How long it took, and when it ended.
    last: Option<(Duration, Instant)>,
}

pub struct Renderer {
    session: Session,
    shared: Arc<Shared>,
    files: Option<Files>,
    /// For temporary files.
    folder: PathBuf,
    /// Counts sessions: strands that were built for an earlier one are dropped.
    number: u64,
    revision: u64,
    frame: u64,
    picture: Option<Picture>,
    /// The picture at full resolution, which is saved.
    full: bool,
    /// Seconds per pixel, on all cores.
    cost: f64,
    mrays: f64,
    /// The first command that no picture shows.
    since: Option<Instant>,
    building: bool,
    outdated: bool,
    opening: bool,
    denoising: Denoising,
    note: Option<String>,
}

impl Renderer {
    pub fn new(session: Session, shared: Arc<Shared>, files: Option<Files>, folder: PathBuf) -> Self {
        Renderer {
            session,
            shared,
            files,
            folder,
            number: 0,
            revision: 0,
            frame: 0,
            picture: None,
            full: false,
            cost: 1e-6,
            mrays: 0.0,
            since: None,
            building: false,
            outdated: false,
            opening: false,
            denoising: Denoising::default(),
            note: None,
        }
    }

    /// Works until the engine is dropped.
    pub fn run(mut self) {
        while let Some(jobs) = self.shared.take(self.is_idle()) {
            let any = !jobs.is_empty();
            jobs.into_iter().for_each(|job| self.work(job));
            if any {
                self.publish_state();
            }
            if !self.is_idle() {
                self.step();
            }
        }
    }

    /// Whether the picture needs no more samples.
    fn is_idle(&self) -> bool {
        self.picture.as_ref().is_some_and(|picture| {
            self.session.paused || (picture.coarse == 1 && picture.film.samples() >= self.session.target)
        })
    }

    fn restart(&mut self) {
        self.picture = None;
        self.full = false;
        self.denoising.picture += 1;
    }

    fn work(&mut self, job: Job) {
        match job {
            Job::Command(command, reply, at) => {
                let answer = self.session.apply(command, at).and_then(|(answer, effect)| {
                    self.revision += 1;
                    match effect {
                        Effect::None => {}
                        Effect::Redraw => self.redraw(),
                        Effect::Restart => {
                            self.since.get_or_insert(at);
                            self.restart();
                        }
                        Effect::Groom(restart) => {
                            if restart {
                                self.restart();
                            }
                            self.build();
                        }
                        Effect::Open(file) => self.open(&file)?,
                    }
                    Ok(answer)
                });
                // A page that has closed its connection needs no answer.
                let _ = reply.send(answer);
            }
            // The request was given up.
            Job::Save(_, reply, _) if reply.is_closed() => {}
            // Many strands may take seconds to write.
            Job::Save(Save::Scene, reply, place) => {
                let scene = self.session.scene();
                self.spawn(move || {
                    let file = save::usd(&scene, Format::Crate, || reply.is_closed());
                    // Whoever has the answer may ask for the next file.
                    drop(place);
                    let _ = reply.send(file);
                });
            }
            Job::Save(what, reply, place) => {
                let film = self.picture.as_ref().filter(|_| self.full).map(|picture| &picture.film);
                // All samples of the picture, and not those of the last time.
                let denoiser = self.session.denoiser.as_ref().ok().filter(|_| self.session.denoise);
                let denoised = denoiser.zip(film).map(|(denoiser, film)| Denoised::new(&**denoiser, film, &[]));
                let bytes = match denoised.transpose() {
                    Ok(denoised) => save::bytes(what, &self.session, film, denoised.as_ref()),
                    Err(error) => Err(error.to_string()),
                };
                drop(place);
                let _ = reply.send(bytes);
            }
            Job::Load(name, bytes, reply) => self.load(name, bytes, reply),
            Job::Built(number, curves) => {
                self.building = false;
                if number == self.number {
                    if let Err(error) = self.session.set_curves(curves) {
                        self.note = Some(error);
                    }
                    self.restart();
                }
                // Strands of an earlier session may have kept those of this one waiting.
                if std::mem::take(&mut self.outdated) {
                    self.build();
                }
            }
            Job::Denoised(number, samples, result) => self.take_denoised(number, samples, result),
            Job::Opened(result, reply) => {
                self.opening = false;
                let answer = result.map(|session| {
                    self.session = *session;
                    self.number += 1;
                    self.outdated = false;
                    self.note = None;
                    self.restart();
                    Value::Null
                });
                if let (Err(error), None) = (&answer, &reply) {
                    self.note = Some(error.clone());
                }
                if let Some(reply) = reply {
                    let _ = reply.send(answer);
                }
            }
        }
    }

    /// Sends the state to all pages.
    pub fn publish_state(&mut self) {
        let busy = match (self.opening, self.building) {
            (true, _) => Some("opening the scene".to_owned()),
            (_, true) => Some("building the groom".to_owned()),
            _ => None,
        };
        let files = self.files.as_mut().map(Files::names).unwrap_or_default();
        let state = self.session.state(self.revision, busy, files, self.note.clone());
        if let Ok(text) = serde_json::to_string(&state) {
            self.shared.states.send_replace(Arc::from(text));
        }
    }

    /// Renders some samples, and sends the picture.
    fn step(&mut self) {
        let is_first = self.picture.is_none();
        let picture = self.picture.get_or_insert_with(|| {
            let [.., width, height] = self.session.settings(1).area();
            let coarse = (self.cost * (width * height) as f64 / FIRST).sqrt().ceil();
            let coarse = (coarse as usize).clamp(1, COARSEST).next_power_of_two();
            empty(&self.session, coarse)
        });
        let settings = self.session.settings(picture.coarse);
        let [.., width, height] = settings.area();
        let pixels = (width * height) as f64;
        let samples = picture.film.samples();
        let chunk = if picture.coarse > 1 || samples == 0 {
            1
        } else {
            let fitting = (BETWEEN.as_secs_f64() / (self.cost * pixels)) as u64;
            fitting.clamp(1, samples).min(self.session.target.saturating_sub(samples)).max(1)
        };
        // The first picture after a change is always finished. Otherwise a drag would show none.
        self.shared.interruptible.store(!is_first, Ordering::Relaxed);
        let started = Instant::now();
        let range = samples..samples + chunk;
        let rendered = if is_first {
            self.session.world.render(&settings, &mut picture.film, range, &())
        } else {
            self.session.world.render(&settings, &mut picture.film, range, &self.shared.cancel)
        };
        self.shared.interruptible.store(true, Ordering::Relaxed);
        match rendered {
            Ok(statistics) => {
                self.shared.questioned.store(false, Ordering::Relaxed);
                let seconds = started.elapsed().as_secs_f64().max(1e-6);
                self.cost = 0.5 * self.cost + 0.5 * seconds / (pixels * chunk as f64);
                self.mrays = statistics.rays as f64 * 1e-6 / seconds;
            }
            Err(vellus_render::Error::Cancelled) => return,
            Err(error) => {
                self.note = Some(error.to_string());
                self.session.paused = true;
                self.publish_state();
                return;
            }
        }
        self.full = picture.coarse == 1;
        let done = self.full && picture.film.samples() >= self.session.target;
        if is_first || done || !self.full || picture.sent.is_none_or(|sent| sent.elapsed() >= BETWEEN) {
            self.redraw();
        }
        if let Some(picture) = self.picture.as_mut().filter(|picture| picture.coarse > 1) {
            let next = picture.coarse / 2;
            if !self.session.paused {
                self.picture = Some(empty(&self.session, next));
                self.full = false;
            }
        }
    }

    /// Denoises the picture on another thread, if that is due: with a quarter more samples, and at most half of the
    /// time. The last samples are always denoised.
    fn begin_denoising(&mut self) {
        let Some(picture) = self.picture.as_ref().filter(|picture| self.session.denoise && picture.coarse == 1) else {
            return;
        };
        let (samples, done) = (picture.film.samples(), picture.film.samples() >= self.session.target);
        let more = picture.denoised.as_ref().is_none_or(|(at, _)| samples * 4 > at * 5 || (done && samples > *at));
        let rested = self.denoising.last.is_none_or(|(took, ended)| done || ended.elapsed() >= took);
        let (Ok(denoiser), true) = (&self.session.denoiser, samples > 0 && more && rested) else { return };
        if self.denoising.since.is_some() {
            return;
        }
        let (denoiser, film, number) = (Arc::clone(denoiser), picture.film.clone(), self.denoising.picture);
        let shared = Arc::clone(&self.shared);
        let begun = self.spawn(move || {
            let denoised = Denoised::new(&*denoiser, &film, &[]).map_err(|error| error.to_string());
            shared.push(Job::Denoised(number, samples, denoised));
        });
        self.denoising.since = begun.then(Instant::now);
    }

    fn take_denoised(&mut self, number: u64, samples: u64, result: Result<Denoised, String>) {
        self.denoising.last = self.denoising.since.take().map(|since| (since.elapsed(), Instant::now()));
        match result {
            Ok(denoised) => {
                if let Some(picture) = self.picture.as_mut().filter(|_| number == self.denoising.picture) {
                    picture.denoised = Some((samples, denoised));
                }
                self.redraw();
            }
            Err(error) => {
                self.session.denoise = false;
                self.session.denoiser = Err(error.clone());
                self.note = Some(error);
            }
        }
    }

    /// Sends the picture to all pages.
    fn redraw(&mut self) {
        self.begin_denoising();
        let Some(picture) = self.picture.as_mut().filter(|picture| picture.film.samples() > 0) else { return };
        let (film, session) = (&picture.film, &mut self.session);
        let samples = film.samples();
        let denoised = picture.denoised.as_ref().filter(|_| session.denoise);
        let pixels = match denoised {
            Some((_, denoised)) => film.denoised_to_srgb(&denoised.beauty, session.display()),
            None => film.to_srgb(session.display()),
        };
        let [left, top, width, height] = film.area().map(|x| x as f32);
        let [w, h] = film.whole().map(|x| x as f32);
        self.frame += 1;
        let header = Header {
            frame: self.frame,
            revision: self.revision,
            size: [film.width(), film.height()],
            area: [left / w, top / h, (left + width) / w, (top + height) / h],
            samples,
            coarse: picture.coarse,
            noise: film.noise(),
            mrays: self.mrays,
            denoised: denoised.is_some(),
            done: picture.coarse == 1 && samples >= session.target,
            latency: self.since.take().map_or(0.0, |at| at.elapsed().as_secs_f64() * 1e3),
        };
        picture.sent = Some(Instant::now());
        if let Some(frame) = Frame::new(&header, &pixels) {
            self.shared.frames.send_replace(Some(Arc::new(frame)));
        }
    }

    /// Builds the strands of the groom on another thread.
    fn build(&mut self) {
        if self.building {
            self.outdated = true;
            return;
        }
        let (source, groom) = (Arc::clone(&self.session.source), self.session.groom());
        let (shared, number) = (Arc::clone(&self.shared), self.number);
        let work = move || {
            let strands: Vec<Strands> = source.iter().map(|set| groom.apply(set)).collect();
            shared.push(Job::Built(number, Curves::new(strands)));
        };
        self.building = self.spawn(work);
    }

    /// Opens a file of the folder on another thread.
    fn open(&mut self, file: &str) -> Result<(), String> {
        let files = self.files.as_ref().ok_or("the server has no --folder")?;
        let path = files.path(file).ok_or("there is no such scene in the folder")?;
        // Pages see names in the folder only.
        let folder = format!("{}{}", files.folder().display(), std::path::MAIN_SEPARATOR);
        let shown = move |error: crate::Error| save::chain(&error).replace(&folder, "");
        self.spawn_open(move || Session::open(&path, false).map_err(shown), None)
    }

    /// Opens a dropped file on another thread.
    fn load(&mut self, name: String, bytes: Vec<u8>, reply: Reply<Value>) {
        if self.opening {
            let _ = reply.send(Err("another scene is being opened".to_owned()));
            return;
        }
        // `spawn_open` refuses only while a scene is being opened.
        let folder = self.folder.clone();
        let _ = self.spawn_open(move || save::load(&name, bytes, &folder), Some(reply));
    }

    fn spawn_open(
        &mut self,
        open: impl FnOnce() -> Result<Session, String> + Send + 'static,
        reply: Option<Reply<Value>>,
    ) -> Result<(), String> {
        if self.opening {
            return Err("another scene is being opened".to_owned());
        }
        let shared = Arc::clone(&self.shared);
        let work = move || {
            shared.push(Job::Opened(open().map(Box::new), reply));
        };
        self.opening = self.spawn(work);
        Ok(())
    }

    /// Starts a thread. Returns false, and notes it, if the system refuses one.
    fn spawn(&mut self, work: impl FnOnce() + Send + 'static) -> bool {
        // A pool of its own: in the common one, each step of the work would wait for a whole sample of the picture.
        let work = move || match rayon::ThreadPoolBuilder::new().build() {
            Ok(pool) => pool.install(work),
            Err(_) => work(),
        };
        let thread = std::thread::Builder::new().name("vellus-live work".to_owned()).spawn(work);
        if let Err(error) = &thread {
            self.note = Some(format!("the system refuses a thread: {error}"));
        }
        thread.is_ok()
    }
}

fn empty(session: &Session, coarse: usize) -> Picture {
    let settings = session.settings(coarse);
    let film = Film::new(settings.size, settings.area(), session.world.layout(&session.layers()));
    Picture { film, coarse, sent: None, denoised: None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Shared;
    use crate::request::{Command, Groom};
    use std::path::Path;

    /// A groom command for a scene that was opened while the groom of the scene before was built.
    #[test]
    fn a_groom_after_another_scene_is_built() {
        let session = || Session::open(Path::new("hair-lock"), true).unwrap();
        let shared = Arc::new(Shared::default());
        let mut renderer = Renderer::new(session(), Arc::clone(&shared), None, PathBuf::new());
        let groom = |density: f32, clump: f32| {
            let (reply, _answer) = tokio::sync::oneshot::channel();
            let groom = Groom { density, clump, ..Groom::default() };
            Job::Command(Command::Groom(groom), reply, Instant::now())
        };
        let count =
            |renderer: &Renderer| renderer.session.world.curves().strands().iter().map(Strands::len).sum::<usize>();
        let all = count(&renderer);
        renderer.work(groom(1.0, 1.0));
        renderer.work(Job::Opened(Ok(Box::new(session())), None));
        renderer.work(groom(0.25, 0.0));
        while renderer.building {
            shared.take(true).unwrap().into_iter().for_each(|job| renderer.work(job));
        }
        let kept = count(&renderer) as f32 / all as f32;
        assert!((kept - 0.25).abs() < 0.1, "{kept}");
    }

    /// Makes pictures half as bright.
    #[derive(Debug)]
    struct Half;

    impl vellus_render::Denoise for Half {
        fn clean(&self, _: &Film, pictures: &[Vec<f32>]) -> Result<Vec<Vec<f32>>, vellus_render::Error> {
            Ok(pictures.iter().map(|picture| picture.iter().map(|x| 0.5 * x).collect()).collect())
        }
    }

    /// The picture is denoised on another thread while it refines, and once more when it is finished. What was denoised
    /// for an earlier picture is dropped.
    #[test]
    fn a_finished_picture_is_denoised() {
        let mut session = Session::open(Path::new("hair-lock"), true).unwrap();
        session.denoiser = Ok(Arc::new(Half));
        (session.denoise, session.target, session.size) = (true, 3, [48, 32]);
        let shared = Arc::new(Shared::default());
        let mut renderer = Renderer::new(session, Arc::clone(&shared), None, PathBuf::new());
        let finish = |renderer: &mut Renderer| {
            while !renderer.is_idle() {
                renderer.step();
            }
            while renderer.denoising.since.is_some() {
                shared.take(true).unwrap().into_iter().for_each(|job| renderer.work(job));
            }
            let picture = renderer.picture.as_ref().unwrap();
            assert_eq!(picture.denoised.as_ref().map(|(samples, _)| *samples), Some(3));
            let mean = |values: &[f32]| values.iter().map(|&x| f64::from(x)).sum::<f64>();
            let noisy = picture.film.values(vellus_render::Layer::Beauty).unwrap();
            let clean = &picture.denoised.as_ref().unwrap().1.beauty;
            assert!((mean(clean) / mean(&noisy) - 0.5).abs() < 1e-5);
            picture.denoised.as_ref().unwrap().1.clone()
        };
        let earlier = finish(&mut renderer);
        let number = renderer.denoising.picture;
        renderer.restart();
        renderer.step();
        renderer.work(Job::Denoised(number, 3, Ok(earlier)));
        assert!(renderer.picture.as_ref().unwrap().denoised.is_none());
        finish(&mut renderer);
        renderer.work(Job::Denoised(number, 3, Err("no memory".to_owned())));
        assert!(!renderer.session.denoise && renderer.note.as_deref() == Some("no memory"));
    }
}
