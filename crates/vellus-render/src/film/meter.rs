//! A light meter: how bright a film is, and which exposure suits it.

use crate::error::Error;
use crate::film::{Film, Layer};
use crate::{Settings, World};

/// The luminance that a picture has on average after metering, as the mean of logarithms. It is a little less than that
/// of a grey card, because the studio's background is darker.
const TARGET: f64 = 0.16;

/// Metering keeps at least this share of the pixels below white.
const BELOW_WHITE: f64 = 0.98;

/// Metering darkens a picture at most so many stops to keep its highlights.
const DARKEN: f64 = 1.0;

/// Exposures are multiples of this many stops, so that small changes of a scene do not change the exposure.
const STEP: f64 = 0.25;

/// Pixels on the longer side of the picture that is metered, and its samples.
const METERED: (usize, u64) = (64, 16);

/// The luminance of linear sRGB (Rec. 709).
pub(crate) fn luminance(c: [f64; 3]) -> f64 {
    0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]
}

impl Film {
    /// The luminance of each pixel and the share of the pixel that objects cover, row by row.
    pub(crate) fn luminances(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let places = (0..self.height()).flat_map(|y| (0..self.width()).map(move |x| (x, y)));
        places.map(move |(x, y)| {
            let color = [0, 1, 2].map(|c| self.mean(x, y, Layer::Beauty, c));
            (luminance(color), self.mean(x, y, Layer::Alpha, 0))
        })
    }

    /// The exposure that suits the film, in stops: a multiple of a quarter in [-100, 100].
    ///
    /// The mean of the logarithms of the luminance becomes 0.16, a little less than that of a grey card. Pixels count
    /// as far as objects cover them, and black pixels do not count. The exposure is up to one stop lower, to keep
    /// 98 % of these pixels below white. `None` if all pixels are black or empty.
    pub fn metered(&self) -> Option<f32> {
        let mut lit: Vec<(f64, f64)> = self.luminances().filter(|&(y, weight)| y > 0.0 && weight > 0.0).collect();
        let total: f64 = lit.iter().map(|(_, weight)| weight).sum();
        let mean = lit.iter().map(|(y, weight)| weight * y.log2()).sum::<f64>() / total;
        lit.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut below = 0.0;
        let (bright, _) = lit.iter().find(|(_, weight)| {
            below += weight;
            below >= BELOW_WHITE * total
        })?;
        let wanted = TARGET.log2() - mean;
        let stops = wanted.min((-bright.log2()).max(wanted - DARKEN));
        Some(((stops / STEP).round() * STEP).clamp(-100.0, 100.0) as f32)
    }
}

impl World {
    /// The exposure that suits the whole picture, in stops: [`Film::metered`] of a small, fixed number of samples.
    ///
    /// It depends on the scene, on the ratio of width and height, and on the mode of `settings`, and on nothing else:
    /// every part of a picture has the same exposure. `None` if the small picture is black or empty.
    ///
    /// # Errors
    /// Those of [`World::render`].
    pub fn metered(&self, settings: &Settings) -> Result<Option<f32>, Error> {
        let (longest, samples) = METERED;
        let scale = longest as f64 / settings.size[0].max(settings.size[1]) as f64;
        let size = settings.size.map(|n| ((n as f64 * scale).round() as usize).max(1));
        let settings = Settings { mode: settings.mode, ..Settings::new(size) };
        let mut film = Film::new(size, settings.area(), self.layout(&[]));
        self.render(&settings, &mut film, 0..samples, &())?;
        Ok(film.metered())
    }
}
