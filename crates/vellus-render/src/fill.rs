//! Filling a radiance cache: from the paths of one camera, or from those of several frames of a shot.

use crate::error::Error;
use crate::film::{Layer, Layout};
use crate::integrator::cache::{Filling, RadianceCache, Record, Records};
use crate::integrator::path::Shared;
use crate::integrator::settings::Settings;
use crate::integrator::view::{Filter, View};
use crate::world::World;
use rayon::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};
use vellus_io::Progress;
use vellus_scene::Camera;

/// Changes the seed for the samples that fill a radiance cache.
const CACHE_SEED: u32 = 0x5eed_cace;

/// The number of records of a radiance cache that are kept until they are added to it.
const RECORDS_AT_ONCE: usize = 1 << 17;

/// A frame of a shot in which nothing moves but the camera. The frames before help to fill its radiance cache.
///
/// Sample s of the [`Settings::radiance_cache`] samples of each pixel comes from the latest frame up to this one whose
/// number has the same remainder as s, divided by [`Shot::FRAMES`]. If that frame sees something else, or is not known,
/// it comes from this frame's own camera. So two frames that follow each other share all samples but an eighth, the
/// error of the cache changes slowly, and a process that renders all frames traces an eighth of the samples for each.
/// Pictures do not depend on which frames a process rendered before.
#[derive(Clone, Debug, Default)]
pub struct Shot {
    /// The number of the frame.
    pub frame: i32,
    /// The cameras of the frames before, the nearest first. More than [`Shot::FRAMES`] − 1 are not used.
    pub earlier: Vec<Camera>,
    /// What the frames of one process share. They need the same settings, layers and lights.
    pub kept: Arc<Kept>,
}

/// The records of a frame's paths, for the next one: 52 bytes for each sample of a pixel, and 12 for each further group
/// of lights.
#[derive(Debug, Default)]
pub struct Kept(Mutex<Vec<Arc<Round>>>);

/// The records of one sample of each pixel.
#[derive(Debug)]
struct Round {
    camera: Camera,
    sample: u32,
    /// The triangles of each mesh. The reader of a scene divides surfaces for the camera.
    triangles: Vec<usize>,
    records: Records,
}

impl Shot {
    /// The number of frames that fill one cache. Measured: `docs/notes/2026-11-radiance-cache.md`, "From frame to
    /// frame".
    pub const FRAMES: usize = 8;

    /// How many frames before this one sample `s` comes from.
    fn age(&self, s: u32) -> usize {
        (i64::from(self.frame) - i64::from(s)).rem_euclid(Shot::FRAMES as i64) as usize
    }
}

/// How a cache is filled.
pub(crate) struct Fill<'a> {
    pub settings: &'a Settings,
    /// The layers of the picture.
    pub layout: &'a Layout,
    pub shot: Option<&'a Shot>,
    pub progress: &'a dyn Progress,
}

impl Fill<'_> {
    /// A cache with this many samples of each pixel: `cache` with more of them, or a new one. `report` receives the
    /// share that is done.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if [`Fill::progress`] stopped it.
    pub fn grow(
        &self,
        world: &World,
        cache: Option<RadianceCache>,
        samples: u32,
        report: &mut dyn FnMut(f64),
    ) -> Result<RadianceCache, Error> {
        let (first, cache) = match cache {
            Some(cache) if cache.samples() >= samples => return Ok(cache),
            Some(cache) => (cache.samples(), Some(cache)),
            None => (0, None),
        };
        let layers: &[Layer] = if self.layout.has(Layer::Lights) { &[Layer::Lights] } else { &[] };
        let layout = &world.layout(layers);
        let (eye, slope) = world.geometry.view.perspective(self.settings.size);
        let mut filling = cache.map_or_else(|| Filling::new(eye, slope, layout), RadianceCache::into_filling);
        let mut report = |index: u32, part: f64| report((f64::from(index - first) + part) / f64::from(samples - first));
        let rounds = self.shot.map(|shot| Rounds::new(world, self.settings, shot));
        let mut used = Vec::new();
        for index in first..samples {
            let shared = rounds.as_ref().filter(|_| Some(index) < self.settings.radiance_cache);
            let view = shared.map_or(world.geometry.view, |rounds| rounds.view(index));
            if let Some(round) = shared.and_then(|rounds| rounds.find(&view, index)) {
                filling.add(&round.records);
                used.push(round);
                continue;
            }
            let mut records = Records::default();
            self.trace(world, layout, &view, index, &mut filling, &mut |part, mut some| {
                report(index, part);
                if shared.is_some() {
                    records.append(&mut some);
                }
            })?;
            if let Some(Rounds { triangles, .. }) = shared {
                let triangles = triangles.clone();
                used.push(Arc::new(Round { camera: view.camera(), sample: index, triangles, records }));
            }
        }
        if let (Some(shot), 0) = (self.shot, first) {
            *shot.kept.lock() = used;
        }
        Ok(filling.finish(samples))
    }

    /// Traces sample `index` of each pixel, and adds its records. `done` receives the share that was done before, and
    /// the records of a part of the picture.
    fn trace(
        &self,
        world: &World,
        layout: &Layout,
        view: &View,
        index: u32,
        filling: &mut Filling,
        done: &mut dyn FnMut(f64, Records),
    ) -> Result<(), Error> {
        // The samples of the picture itself are independent of those of the cache.
        let settings = &Settings { seed: self.settings.seed ^ CACHE_SEED, radiance_cache: None, ..*self.settings };
        let shared = Shared { settings, layout, view, indirect: filling.recorded() };
        let [left, top, width, height] = settings.area();
        let at_once = (RECORDS_AT_ONCE / width).max(1);
        for top_row in (0..height).step_by(at_once) {
            let rows = (top_row..height.min(top_row + at_once)).into_par_iter().map(|y| {
                let mut values = vec![0.0; layout.channels()];
                let mut record = |x| {
                    let pixel = [left + x, top + y];
                    world.fibers.trace(&world.geometry, shared, pixel, index.into(), &mut values).record
                };
                let records = (0..width).map_while(|x| (!self.progress.is_cancelled()).then(|| record(x)));
                records.flatten().collect::<Vec<Box<Record>>>()
            });
            let rows: Vec<Vec<Box<Record>>> = rows.collect();
            if self.progress.is_cancelled() {
                return Err(Error::Cancelled);
            }
            // In the order of pixels, so that the sums do not depend on the number of threads.
            let mut records = Records::default();
            rows.iter().flatten().for_each(|record| records.push(record));
            filling.add(&records);
            done(top_row as f64 / height as f64, records);
        }
        Ok(())
    }
}

impl Kept {
    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<Arc<Round>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The frames that fill the cache of one.
struct Rounds<'a> {
    shot: &'a Shot,
    own: View,
    /// The cameras of the frames before. `None` if one sees something else.
    earlier: Vec<Option<View>>,
    triangles: Vec<usize>,
    kept: Vec<Arc<Round>>,
}

impl<'a> Rounds<'a> {
    fn new(world: &World, settings: &Settings, shot: &'a Shot) -> Self {
        let views = shot.earlier.iter().take(Shot::FRAMES - 1).map(|camera| View::new(*camera));
        let earlier = views.map(|view| world.sees_alike(settings, &view).then_some(view)).collect();
        let triangles = world.geometry.all_meshes().map(|mesh| mesh.triangles.len()).collect();
        Rounds { shot, own: world.geometry.view, earlier, triangles, kept: shot.kept.lock().clone() }
    }

    /// The camera of a sample.
    fn view(&self, sample: u32) -> View {
        let before = self.shot.age(sample).checked_sub(1);
        before.and_then(|i| *self.earlier.get(i)?).unwrap_or(self.own)
    }

    /// The records of a sample, if an earlier frame traced it.
    fn find(&self, view: &View, sample: u32) -> Option<Arc<Round>> {
        let same = |round: &&Arc<Round>| {
            round.sample == sample && round.camera == view.camera() && round.triangles == self.triangles
        };
        self.kept.iter().find(same).cloned()
    }
}

impl World {
    /// Traces [`Settings::radiance_cache`] samples of each pixel, and fills a cache with the light that they find.
    /// `None` without that setting. `layout` is that of the film: with [`Layer::Lights`] the cache keeps the light of
    /// each group.
    ///
    /// The cache depends on the scene and on the settings, not on the number of threads. It reports its progress. It
    /// does not grow with the samples of a picture, as those of [`World::render`] and of sessions do.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if `progress` stopped it.
    pub fn fill_cache(
        &self,
        settings: &Settings,
        layout: &Layout,
        progress: &dyn Progress,
    ) -> Result<Option<RadianceCache>, Error> {
        let Some(samples) = settings.radiance_cache else { return Ok(None) };
        let mut report = |done| progress.report(done, "filling the radiance cache");
        Fill { settings, layout, shot: None, progress }.grow(self, None, samples, &mut report).map(Some)
    }

    /// Whether a camera sees most of what the own one sees, from a direction within 30° and at half to twice its size.
    fn sees_alike(&self, settings: &Settings, other: &View) -> bool {
        const SIDE: usize = 16;
        let Settings { size, .. } = *settings;
        let own = &self.geometry.view;
        let (of_own, of_other) = (own.pixel_widths(size, 0.0), other.pixel_widths(size, 0.0));
        let (mut seen, mut alike) = (0, 0);
        for k in 0..SIDE * SIDE {
            let pixel = [0, 1].map(|axis| (2 * [k % SIDE, k / SIDE][axis] + 1) * size[axis] / (2 * SIDE));
            let ray = own.ray(size, pixel, Filter::Box, [0.5; 4], 0.0);
            let Some(hit) = self.geometry.intersect(&ray) else { continue };
            let point = ray.at(hit.t());
            let toward = (point - other.eyes()[0]).normalize_or_zero();
            let sizes = of_other(point) / of_own(point);
            let inside = other
                .seen(size, point, 0.0)
                .is_some_and(|p| (0..2).all(|axis| (0.0..=size[axis] as f32).contains(&p[axis])));
            seen += 1;
            alike += usize::from(
                inside && toward.dot(ray.direction) > 30f32.to_radians().cos() && (0.5..=2.0).contains(&sizes),
            );
        }
        4 * alike >= 3 * seen
    }
}
