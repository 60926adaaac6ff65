//! Rendering ranges of samples on all cores.

use crate::error::Error;
use crate::fill::Fill;
use crate::film::cryptomatte::Count;
use crate::film::cryptomatte::Thing;
use crate::film::{Film, Layer, Layout, add};
use crate::integrator::cache::{Indirect, RadianceCache, next_growth, samples_for};
use crate::integrator::path::{Seen, Shared};
use crate::integrator::settings::Settings;
use crate::world::World;
use rayon::prelude::*;
use std::ops::{AddAssign, Range};
use vellus_io::Progress;

/// Counts of what [`World::render`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Rays traced, shadow rays included.
    pub rays: u64,
    /// Samples that were omitted because a value was not finite.
    pub rejected: u64,
    /// Throughput of the paths that [`Settings::max_depth`] cut off, in millionths of a sample. The sum of integers
    /// does not depend on the order.
    cut: u64,
    /// The light that [`Settings::clamp_indirect`] removed, and the light that it left: sums over samples and channels.
    /// Both are 0 without that limit.
    removed: f64,
    left: f64,
}

impl Statistics {
    /// The throughput of the paths that [`Settings::max_depth`] cut off, in samples: 1 is a path that was cut off
    /// before its first scattering event.
    pub fn cut(&self) -> f64 {
        self.cut as f64 * 1e-6
    }

    /// The share of the light that [`Settings::clamp_indirect`] removed, from 0 to 1.
    pub fn removed(&self) -> f64 {
        if self.removed > 0.0 { self.removed / (self.removed + self.left) } else { 0.0 }
    }
}

impl AddAssign for Statistics {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.rejected += other.rejected;
        self.cut += other.cut;
        self.removed += other.removed;
        self.left += other.left;
    }
}

impl World {
    /// Adds a range of samples of every pixel to a film. Sample i of a pixel is the same in every range that contains
    /// i. Neither the number of threads nor the division into ranges changes a picture.
    ///
    /// This checks `progress` for cancellation at every pixel, but reports nothing to it. A [`Session`](crate::Session)
    /// reports progress. With [`Settings::radiance_cache`], each call fills a cache first. It grows with the number of
    /// samples.
    ///
    /// # Errors
    /// [`Error::OtherFilm`] if the size, area or layers of the film do not match `settings` and this scene.
    /// [`Error::Cancelled`] if `progress` stopped it. The film then does not change, but may have the samples before a
    /// growth of the cache.
    pub fn render(
        &self,
        settings: &Settings,
        film: &mut Film,
        samples: Range<u64>,
        progress: &dyn Progress,
    ) -> Result<Statistics, Error> {
        let Some(least) = settings.radiance_cache else {
            return self.render_cached(settings, None, film, samples, progress);
        };
        let (mut cache, mut statistics) = (None, Statistics::default());
        let Range { mut start, end } = samples;
        while start < end {
            let part = start..end.min(next_growth(least, start));
            let fill = Fill { settings, layout: film.layout(), shot: None, progress };
            cache = Some(fill.grow(self, cache, samples_for(least, start), &mut |_| {})?);
            statistics += self.render_cached(settings, cache.as_ref(), film, part.clone(), progress)?;
            start = part.end;
        }
        Ok(statistics)
    }

    /// As [`World::render`], with a cache that [`World::fill_cache`] filled for these settings, or with none.
    ///
    /// # Errors
    /// Those of [`World::render`], and [`Error::Settings`] if the cache was filled for other groups of lights.
    pub fn render_cached(
        &self,
        settings: &Settings,
        cache: Option<&RadianceCache>,
        film: &mut Film,
        samples: Range<u64>,
        progress: &dyn Progress,
    ) -> Result<Statistics, Error> {
        let [left, top, width, height] = settings.area();
        self.check_film(settings, film)?;
        let layout = film.layout();
        if cache.is_some_and(|cache| !cache.fits(layout)) {
            return Err(Error::Settings("the radiance cache was filled for other groups of lights".to_owned()));
        }
        let view = &self.geometry.view;
        let shared = Shared { settings, layout, view, indirect: cache.map_or(Indirect::Traced, Indirect::Cached) };
        let rows: Vec<Option<Row>> = (0..height)
            .into_par_iter()
            .map(|y| {
                let film = &*film;
                let mut row = Row::new(width * layout.words());
                let mut values = vec![0.0; layout.channels()];
                for x in 0..width {
                    if progress.is_cancelled() {
                        return None;
                    }
                    for index in film.range(x, y, &samples) {
                        let pixel = [left + x, top + y];
                        let seen = self.fibers.trace(&self.geometry, shared, pixel, index, &mut values);
                        row.add(settings, layout, [x, y * width + x], &values, &seen);
                    }
                    row.end_pixel();
                }
                Some(row)
            })
            .collect();
        let rows: Vec<Row> = rows.into_iter().collect::<Option<_>>().ok_or(Error::Cancelled)?;
        Ok(film.add_traced(rows, samples))
    }

    /// The names of the things that camera rays can hit: sets of strands first, then meshes. All instances of a
    /// prototype are one thing.
    pub fn things(&self) -> Vec<Thing> {
        let (looks, surfaces) = (&self.geometry.looks, &self.geometry.surfaces);
        let strands = self.geometry.all_strands().map(|s| Thing::new(&s.name, &looks[s.look].name, true));
        let meshes = self.geometry.all_meshes().map(|m| Thing::new(&m.name, &surfaces[m.surface].name, false));
        strands.chain(meshes).collect()
    }

    pub(crate) fn check_film(&self, settings: &Settings, film: &Film) -> Result<(), Error> {
        let fail = |what: String| Err(Error::OtherFilm(what));
        if settings.size != film.whole() {
            return fail(format!("its size is {:?}, that of the settings {:?}", film.whole(), settings.size));
        }
        if settings.area() != film.area() {
            return fail(format!("its area is {:?}, that of the settings {:?}", film.area(), settings.area()));
        }
        let groups = film.layout().groups();
        if film.layout().has(Layer::Lights) && groups != self.group_names() {
            return fail(format!("its light groups are {groups:?}, those of the scene {:?}", self.group_names()));
        }
        if film.layout().has_counts() && film.layout().things() != self.layout(&Layer::CRYPTOMATTE).things() {
            return fail("its objects, looks and groups of strands are not those of the scene".to_owned());
        }
        Ok(())
    }
}

/// The samples of a row of pixels.
pub(crate) struct Row {
    sums: Vec<u32>,
    /// Sorted by pixel and thing.
    counts: Vec<Count>,
    /// The first of the counts of this pixel.
    first: usize,
    statistics: Statistics,
    cut: f64,
}

impl Row {
    /// A row without samples.
    pub(crate) fn new(words: usize) -> Self {
        Row { sums: vec![0; words], counts: Vec::new(), first: 0, statistics: Statistics::default(), cut: 0.0 }
    }

    /// Adds a sample to the pixel that is the first of these in the row, and the second in the film.
    #[inline]
    pub(crate) fn add(
        &mut self,
        settings: &Settings,
        layout: &Layout,
        [x, pixel]: [usize; 2],
        values: &[f32],
        seen: &Seen,
    ) {
        self.statistics.rays += seen.rays;
        self.cut += f64::from(seen.cut);
        if settings.clamp_indirect.is_some() {
            self.statistics.removed += f64::from(seen.removed);
            self.statistics.left += values[..3].iter().map(|&x| f64::from(x)).sum::<f64>();
        }
        let sums = &mut self.sums[x * layout.words()..][..layout.words()];
        let added = add(layout, sums, values, seen.strand);
        self.statistics.rejected += u64::from(!added);
        if let (true, Some(thing)) = (added && layout.has_counts(), seen.thing) {
            if self.counts.get(self.first).is_some_and(|count| count.pixel != pixel as u32) {
                self.end_pixel();
            }
            count(&mut self.counts, self.first, pixel as u32, thing);
        }
    }

    /// Ends a pixel. The next one ends it, too.
    pub(crate) fn end_pixel(&mut self) {
        self.counts[self.first..].sort_unstable_by_key(|count| count.thing);
        self.first = self.counts.len();
    }
}

impl Film {
    /// Adds the rows of all pixels, with these samples of each.
    pub(crate) fn add_traced(&mut self, rows: Vec<Row>, samples: Range<u64>) -> Statistics {
        let mut all = Statistics::default();
        for row in &rows {
            all += Statistics { cut: (row.cut * 1e6) as u64, ..row.statistics };
        }
        self.add_counts(&rows.iter().flat_map(|row| row.counts.iter().copied()).collect::<Vec<_>>());
        self.add_rows(rows.into_par_iter().map(|row| row.sums));
        self.advance(samples.end.saturating_sub(samples.start));
        all
    }
}

/// Counts a sample of a pixel, whose counts begin at `first`.
fn count(counts: &mut Vec<Count>, first: usize, pixel: u32, thing: u32) {
    match counts[first..].iter_mut().find(|count| count.thing == thing) {
        Some(count) => count.samples += 1,
        None => counts.push(Count { pixel, thing, samples: 1 }),
    }
}
