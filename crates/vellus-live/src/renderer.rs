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
    denoised: Option<(u64, Denoised)>,
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
                let denoised = self.picture.as_ref().and_then(|picture| picture.denoised.as_ref());
                let denoised = denoised.filter(|_| self.session.denoise).map(|(_, denoised)| denoised);
                let bytes = save::bytes(what, &self.session, film, denoised);
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

    /// Sends the picture to all pages.
    fn redraw(&mut self) {
        let Some(picture) = self.picture.as_mut().filter(|picture| picture.film.samples() > 0) else { return };
        let (film, session) = (&picture.film, &mut self.session);
        let samples = film.samples();
        if session.denoise && picture.coarse == 1 {
            // The denoiser takes as long as some samples: it runs again when there are a quarter more.
            let due = picture.denoised.as_ref().is_none_or(|(at, _)| samples >= session.target || samples * 4 > at * 5);
            if due && picture.denoised.as_ref().is_none_or(|(at, _)| *at != samples) {
                match session.denoiser.as_ref().map(|denoiser| Denoised::new(denoiser, film, &[])) {
                    Ok(Ok(denoised)) => picture.denoised = Some((samples, denoised)),
                    Ok(Err(error)) => {
                        session.denoise = false;
                        session.denoiser = Err(error.to_string());
                        self.note = Some(error.to_string());
                    }
                    Err(_) => session.denoise = false,
                }
            }
        }
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
}
