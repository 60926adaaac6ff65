//! How paths are traced.

use crate::integrator::view::Filter;

/// Which offsets a hit stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Those the pixel sees where the camera sees a fibre; deeper, all where the path was spread over the whole width, else where it is
    /// hit.
    MultiScale,
    /// Where it is hit.
    Near,
    /// The whole width, always.
    Far,
}

/// How paths are traced.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Pixels a row, and rows, of the whole picture.
    pub size: [usize; 2],
    /// The part of it that is rendered: left column, top row, width, height. `None` is all of it.
    pub crop: Option<[usize; 4]>,
    /// Near, far or between.
    pub mode: Mode,
    /// What a pixel's samples see.
    pub filter: Filter,
    /// Another seed is another noise.
    pub seed: u32,
    /// Scattering events after which a path is cut; `None` lets Russian roulette alone end it.
    pub max_depth: Option<u32>,
}

impl Settings {
    /// A whole picture of a size: multi-scale, with the tent filter, seed 0 and no limit of depth.
    pub fn new(size: [usize; 2]) -> Self {
        Settings { size, crop: None, mode: Mode::MultiScale, filter: Filter::Tent, seed: 0, max_depth: None }
    }

    /// Left column, top row, width and height of what is rendered.
    pub fn area(&self) -> [usize; 4] {
        self.crop.unwrap_or([0, 0, self.size[0], self.size[1]])
    }
}
