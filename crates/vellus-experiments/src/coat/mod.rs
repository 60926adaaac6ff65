//! Colours of coats: renderings of [`reference_coat`], random fibres, and differences of colours.

mod difference;
mod random;
mod sheet;

pub use difference::{delta_e2000, delta_e2000_of_labs};
pub use random::{random_color, random_fiber};
pub use sheet::{Axis, Sheet};

use anyhow::Result;
use vellus::{Bcsdf, Fiber};
use vellus_groom::reference_coat;
use vellus_render::{Film, Filter, Layer, Mode, Settings, World};

/// Width and height of the picture whose mean is the colour of a coat.
const SIZE: usize = 24;

/// The reference coat, prepared for rendering with any fibre.
#[derive(Debug)]
pub struct Coat(World);

/// The colour of a coat in a rendering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// The mean radiance of the picture, RGB, linear. It is 1 for white.
    pub color: [f64; 3],
    /// The standard error of its brightness.
    pub error: f64,
}

impl Coat {
    /// Grows the coat.
    ///
    /// # Errors
    /// None in practice.
    pub fn new() -> Result<Self> {
        Ok(Coat(World::new(reference_coat(Fiber::hair())?)?))
    }

    /// A picture of the coat with another fibre.
    ///
    /// # Errors
    /// A parameter of the fibre out of range.
    pub fn render(&mut self, fiber: &Fiber, size: [usize; 2], samples: u64, seed: u32) -> Result<Film> {
        self.0.set_model(|_| Bcsdf::new(fiber))?;
        let settings = Settings {
            size,
            crop: None,
            mode: Mode::Near,
            filter: Filter::Box,
            seed,
            max_depth: None,
            clamp_indirect: None,
            radiance_cache: None,
        };
        let mut film = Film::new(size, settings.area(), self.0.layout(&[Layer::Beauty]));
        self.0.render(&settings, &mut film, 0..samples, &())?;
        Ok(film)
    }

    /// The colour of the coat with another fibre, from 576 pixels with this many samples. 16 samples have a standard
    /// error of about 0.002.
    ///
    /// # Errors
    /// A parameter of the fibre out of range.
    pub fn measure(&mut self, fiber: &Fiber, samples: u64, seed: u32) -> Result<Measured> {
        let film = self.render(fiber, [SIZE; 2], samples, seed)?;
        let pixels = || (0..SIZE * SIZE).map(|i| (i % SIZE, i / SIZE));
        let count = (SIZE * SIZE) as f64;
        let mean = |channel| pixels().map(|(x, y)| film.mean(x, y, Layer::Beauty, channel)).sum::<f64>() / count;
        let error = pixels().map(|(x, y)| film.error(x, y).powi(2)).sum::<f64>().sqrt() / count;
        Ok(Measured { color: [mean(0), mean(1), mean(2)], error })
    }
}
