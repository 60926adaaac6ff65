//! Rendering ranges of samples on all cores.

use crate::film::{Film, add};
use crate::integrator::path::Settings;
use crate::world::World;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// What rendering did, besides the picture.
#[derive(Debug, Default)]
pub struct Statistics {
    /// Rays traced, shadow rays too.
    pub rays: AtomicU64,
    /// Samples that were not finite and were left out.
    pub rejected: AtomicU64,
    /// Throughput that the largest depth cut off, in millionths of a sample.
    cut: AtomicU64,
}

impl Statistics {
    /// Throughput that the largest depth cut off, in samples.
    pub fn cut(&self) -> f64 {
        self.cut.load(Ordering::Relaxed) as f64 * 1e-6
    }
}

impl World {
    /// Adds samples to a film; false where `stop` was set, and the film is as before. The picture does not depend on the
    /// number of threads, nor on how the samples are divided into ranges.
    pub fn render(
        &self,
        settings: &Settings,
        film: &mut Film,
        samples: Range<u64>,
        statistics: &Statistics,
        stop: &AtomicBool,
    ) -> bool {
        let [left, top, width, height] = settings.area();
        assert_eq!((settings.size, settings.area()), (film.whole(), film.area()), "the film is of another picture");
        let layout = film.layout();
        let rows: Vec<Option<Vec<u32>>> = (0..height)
            .into_par_iter()
            .map(|y| {
                let mut row = vec![0; width * layout.words()];
                let mut values = vec![0.0; layout.channels()];
                let (mut rays, mut rejected, mut cut) = (0, 0, 0.0);
                for x in 0..width {
                    if stop.load(Ordering::Relaxed) {
                        return None;
                    }
                    let sums = &mut row[x * layout.words()..][..layout.words()];
                    for index in samples.clone() {
                        let seen = self.fibers.trace(self, settings, layout, [left + x, top + y], index, &mut values);
                        rays += seen.rays;
                        cut += f64::from(seen.cut);
                        rejected += u64::from(!add(layout, sums, &values, seen.strand));
                    }
                }
                statistics.rays.fetch_add(rays, Ordering::Relaxed);
                statistics.rejected.fetch_add(rejected, Ordering::Relaxed);
                statistics.cut.fetch_add((cut * 1e6) as u64, Ordering::Relaxed);
                Some(row)
            })
            .collect();
        if rows.iter().any(Option::is_none) {
            return false;
        }
        film.add_rows(rows.into_iter().flatten());
        film.advance(samples.end - samples.start);
        true
    }
}
