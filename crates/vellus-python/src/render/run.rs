//! Rendering, with progress, cancellation and Ctrl-C.

use super::arrays::one_of;
use super::picture::Picture;
use super::scene::Scene;
use super::world::{self, Prepared};
use crate::checks::{positive, whole};
use crate::error::{rendering, with_causes};
use crate::threads::{POLL, Watch, pool};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::{Duration, Instant};
use vellus_render::session::{Options, Session, camera_notes};
use vellus_render::{Denoised, Error, Film, Filter, Layer, Lod, MAX_SAMPLES, Mode, Settings, denoise::Denoiser};

/// The layers that are rendered if none are named: those of `vellus render`.
const LAYERS: [&str; 11] =
    ["beauty", "alpha", "variance", "fibers", "lobes", "albedo", "normal", "tangent", "depth", "uv", "id"];

/// The largest width and height, pixels: that of `vellus render`.
const MAX_SIZE: usize = 32768;

/// What a callback gets after each pass.
#[pyclass(frozen, module = "vellus", name = "State")]
pub struct State {
    /// Samples a pixel so far.
    #[pyo3(get)]
    samples: u64,
    /// The samples that were asked for.
    #[pyo3(get)]
    total: u64,
    /// The share of the work that is done, from 0 to 1.
    #[pyo3(get)]
    done: f64,
    /// Seconds since rendering began.
    #[pyo3(get)]
    seconds: f64,
    /// The noise of the picture; `None` if it is unknown.
    #[pyo3(get)]
    noise: Option<f64>,
    film: Film,
    is_transparent: bool,
}

#[pymethods]
impl State {
    /// The picture so far, without denoising.
    fn picture(&self) -> Picture {
        Picture {
            film: self.film.clone(),
            denoised: None,
            notes: Vec::new(),
            is_transparent: self.is_transparent,
            rays: 0,
            rejected: 0,
            seconds: self.seconds,
        }
    }

    fn __repr__(&self) -> String {
        format!("<vellus.State: {} of {} samples, {:.0} s>", self.samples, self.total, self.seconds)
    }
}

/// The layers of a list of names. `cryptomatte` stands for three.
fn layers(names: &[String]) -> PyResult<Vec<Layer>> {
    let mut all = Vec::new();
    for name in names {
        match name.as_str() {
            "cryptomatte" => all.extend(Layer::CRYPTOMATTE),
            name => all.extend(Layer::list(name).map_err(|e| PyValueError::new_err(format!("layers: {e}")))?),
        }
    }
    Ok(all)
}

/// What the work and the calling thread tell each other.
enum Message {
    Pass(Box<State>),
    End(Result<Box<Finished>, PyErr>),
}

struct Finished {
    film: Film,
    denoised: Option<Denoised>,
    rays: u64,
    rejected: u64,
}

/// Everything that one run needs.
struct Run {
    prepared: Arc<Prepared>,
    options: Options,
    denoiser: Option<Denoiser>,
    is_transparent: bool,
    with_states: bool,
}

impl Run {
    /// Renders. After each pass, it waits for the answer of the calling thread if that wants to see it.
    fn go(&self, watch: &Watch, sender: &SyncSender<Message>, answers: &Receiver<bool>) -> PyResult<Box<Finished>> {
        let mut session = Session::new(&self.prepared.world, self.options.clone()).map_err(|e| rendering(&e))?;
        let total = self.options.samples.end;
        let run = session.run(watch, |pass| -> Result<(), Error> {
            if self.with_states {
                let state = State {
                    samples: pass.state.samples,
                    total,
                    done: pass.goals.done(&pass.state),
                    seconds: pass.state.spent.as_secs_f64(),
                    noise: pass.state.noise,
                    film: pass.checkpoint.film.clone(),
                    is_transparent: self.is_transparent,
                };
                let heard = sender.send(Message::Pass(Box::new(state))).is_ok();
                if !heard || !answers.recv().unwrap_or(false) {
                    watch.stop();
                }
            }
            Ok(())
        });
        run.map_err(|e| with_causes(&e))?;
        let (rays, rejected) = (session.statistics().rays, session.statistics().rejected);
        let film = session.into_checkpoint().film;
        let denoised = self.denoiser.as_ref().map(|denoiser| Denoised::new(denoiser, &film, &Layer::ALL)).transpose();
        Ok(Box::new(Finished { film, denoised: denoised.map_err(|e| with_causes(&e))?, rays, rejected }))
    }
}

/// Runs it on the threads of the pool. This thread handles signals and calls the callback.
fn run(py: Python<'_>, run: &Run, callback: Option<&Bound<'_, PyAny>>) -> PyResult<Box<Finished>> {
    let pool = pool()?;
    let callback = callback.map(|callback| callback.clone().unbind());
    let watch = Watch::default();
    py.detach(|| {
        let (sender, receiver) = sync_channel(0);
        let (answer, answers) = sync_channel(1);
        pool.in_place_scope(|scope| {
            let watch = &watch;
            scope.spawn(move |_| {
                let result = run.go(watch, &sender, &answers);
                // The receiver outlives the work.
                sender.send(Message::End(result)).ok();
            });
            let mut failed = None;
            loop {
                match receiver.recv_timeout(POLL) {
                    Ok(Message::End(result)) => {
                        Python::attach(|py| py.check_signals())?;
                        return failed.map_or(result, Err);
                    }
                    Ok(Message::Pass(state)) => {
                        let goes_on = Python::attach(|py| match &callback {
                            Some(callback) if failed.is_none() => {
                                py.check_signals()?;
                                let returned = callback.bind(py).call1((*state,))?;
                                Ok(!returned.extract::<bool>().is_ok_and(|goes_on| !goes_on))
                            }
                            _ => Ok(failed.is_none()),
                        });
                        failed =
                            failed.or(goes_on.as_ref().err().map(|e: &PyErr| Python::attach(|py| e.clone_ref(py))));
                        // The work waits for it.
                        answer.send(goes_on.unwrap_or(false)).ok();
                    }
                    Err(RecvTimeoutError::Timeout) => {
                        if failed.is_none()
                            && let Err(interrupt) = Python::attach(|py| py.check_signals())
                        {
                            watch.stop();
                            failed = Some(interrupt);
                        }
                    }
                    // The work panicked. The end of the scope passes the panic on.
                    Err(RecvTimeoutError::Disconnected) => {
                        return Err(PyRuntimeError::new_err("rendering ended without a result"));
                    }
                }
            }
        })
    })
}

#[pymethods]
impl Scene {
    /// Renders a picture.
    ///
    /// `width`, `height`: pixels. `samples`: of each pixel. `layers`: names as in `Picture`, `cryptomatte` or `all`;
    /// `None` is what `vellus render` writes. `mode`: `multiscale`, `near` or `far`. `filter`: `tent` or `box`. `seed`:
    /// another seed gives other noise. `crop`: left, top, width, height of the area to render. `noise`, `time`: also
    /// end at this noise, or after this many seconds. `max_depth`: the largest number of scattering events; no limit
    /// without. `clamp_indirect`: the brightest indirect light of one event. `radiance_cache`: paths end at their
    /// second hit, and this many samples of each pixel fill a cache with indirect light before; faster, with a small
    /// error. `lod`: `auto` keeps fewer, wider strands where they are thinner than an eighth of a pixel and a
    /// hundredth of their length; a number N in [-8, 8] multiplies both limits by 2^N. `denoise`: with Open Image
    /// Denoise.
    ///
    /// `callback(state)` is called after each pass, about every `interval` seconds; see `State`. If it returns `False`,
    /// rendering ends, and the result is the picture so far. `progress`: a bar, if this is a terminal or a notebook.
    ///
    /// The pixels are those of `vellus render`, bit for bit, for any number of threads. The interpreter's lock is
    /// released. The scene is prepared for rays in the first call, and again after a change.
    ///
    /// Raises `ValueError` for an argument or a scene that is not valid, and `KeyboardInterrupt` on Ctrl-C: the samples
    /// are lost then, unless a callback kept a picture.
    #[pyo3(signature = (width=960, height=640, samples=64, *, layers=None, mode="multiscale", filter="tent", seed=0,
        crop=None, noise=None, time=None, max_depth=None, clamp_indirect=None, radiance_cache=None,
        lod=None, denoise=false, callback=None, interval=2.0, progress=false))]
    fn render(
        &self,
        py: Python<'_>,
        width: i128,
        height: i128,
        samples: i128,
        layers: Option<Vec<String>>,
        mode: &str,
        filter: &str,
        seed: i128,
        crop: Option<[i128; 4]>,
        noise: Option<f64>,
        time: Option<f64>,
        max_depth: Option<i128>,
        clamp_indirect: Option<f32>,
        radiance_cache: Option<i128>,
        lod: Option<LodArgument>,
        denoise: bool,
        callback: Option<Bound<'_, PyAny>>,
        interval: f64,
        progress: bool,
    ) -> PyResult<Picture> {
        let start = Instant::now();
        let names = layers.unwrap_or_else(|| LAYERS.map(str::to_owned).to_vec());
        let layers = self::layers(&names)?;
        let modes = Mode::ALL.map(|mode| (mode.name(), mode));
        let mode = one_of("mode", mode, &modes)?;
        let filter = one_of("filter", filter, &Filter::ALL.map(|filter| (filter.name(), filter)))?;
        let samples = whole("samples", samples, 1..=MAX_SAMPLES)?;
        let [width, height] = [whole("width", width, 1..=MAX_SIZE)?, whole("height", height, 1..=MAX_SIZE)?];
        let seed = whole("seed", seed, 0..=u32::MAX)?;
        let crop = match crop {
            Some([x, y, w, h]) => {
                let [x, y] = [whole("crop", x, 0..=width - 1)?, whole("crop", y, 0..=height - 1)?];
                Some([x, y, whole("crop", w, 1..=width - x)?, whole("crop", h, 1..=height - y)?])
            }
            None => None,
        };
        let max_depth = max_depth.map(|n| whole("max_depth", n, 0..=u32::MAX)).transpose()?;
        let radiance_cache = radiance_cache.map(|n| whole("radiance_cache", n, 2..=65536)).transpose()?;
        let lod = lod.map_or(Ok(Lod::Off), LodArgument::read)?;
        positive("interval", interval, 3600.0)?;
        for (name, given) in [("noise", noise), ("time", time), ("clamp_indirect", clamp_indirect.map(f64::from))] {
            given.map_or(Ok(()), |x| positive(name, x, 1e9))?;
        }
        let settings =
            Settings { size: [width, height], crop, mode, filter, seed, max_depth, clamp_indirect, radiance_cache };
        let denoiser = denoise.then(Denoiser::load).transpose().map_err(|e| with_causes(&e))?;
        let setup = ([width, height], mode.name(), lod);
        let mut state = self.lock();
        let prepared = match &state.prepared {
            Some((kept, prepared)) if *kept == setup => prepared.clone(),
            _ => {
                state.prepared = None;
                let prepared = Arc::new(crate::threads::run(py, |_| world::new(&state, &settings, lod))??);
                let unreached = prepared.world.unreached();
                state.warnings.extend(unreached);
                state.prepared = Some((setup, prepared.clone()));
                prepared
            }
        };
        let is_transparent = state.is_transparent;
        drop(state);
        let bar = if progress { bar(py, callback.as_ref(), samples)? } else { None };
        let callback = bar.or(callback);
        let stops = prepared.stops.map(|stops| ("vellus_light_stops".to_owned(), stops.to_string()));
        let options = Options {
            layers,
            noise,
            time: time.map(Duration::from_secs_f64),
            pass: Duration::from_secs_f64(interval),
            ..Options::new(settings, samples)
        };
        let work = Run { prepared, options, denoiser, is_transparent, with_states: callback.is_some() };
        let finished = run(py, &work, callback.as_ref())?;
        let Finished { film, denoised, rays, rejected } = *finished;
        let version = ("vellus_version".to_owned(), env!("CARGO_PKG_VERSION").to_owned());
        let notes = camera_notes(&work.prepared.world.camera(), [width, height]);
        Ok(Picture {
            film,
            denoised,
            notes: notes.into_iter().chain([version]).chain(stops).collect(),
            is_transparent,
            rays,
            rejected,
            seconds: start.elapsed().as_secs_f64(),
        })
    }
}

/// A level of detail: a name or a number.
#[derive(FromPyObject)]
enum LodArgument {
    Name(String),
    Bias(f64),
}

impl LodArgument {
    fn read(self) -> PyResult<Lod> {
        let text = match self {
            LodArgument::Name(name) => name,
            LodArgument::Bias(bias) => bias.to_string(),
        };
        text.parse().map_err(|error| PyValueError::new_err(format!("lod = {text}: {error}")))
    }
}

/// A callback that shows a bar, and calls the given one. `None` where no bar can be shown.
fn bar<'py>(
    py: Python<'py>,
    callback: Option<&Bound<'py, PyAny>>,
    samples: u64,
) -> PyResult<Option<Bound<'py, PyAny>>> {
    let made = py.import("vellus._progress")?.call_method1("bar", (callback, samples))?;
    Ok((!made.is_none()).then_some(made))
}
