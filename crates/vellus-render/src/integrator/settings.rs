//! Settings of the path tracer.

use crate::integrator::view::Filter;

/// The part of a fibre's width over which its reflectance is averaged at a hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// If the camera sees the fibre, the part of its width in the pixel. At later hits, the whole width if the last
    /// scattering event spread the path that far (departure D15 in PAPER.md), otherwise the near field.
    MultiScale,
    /// Near field: only the offset at which the ray hits the fibre.
    Near,
    /// Far field: always the whole width.
    Far,
}

/// Everything that changes a picture, except the scene.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Width and height of the whole picture, in pixels.
    pub size: [usize; 2],
    /// The area that is rendered: left column, top row, width and height, in pixels. `None` is the whole picture.
    pub crop: Option<[usize; 4]>,
    /// Near field, far field, or multi-scale.
    pub mode: Mode,
    /// The pixel filter.
    pub filter: Filter,
    /// Seed of the random numbers. Another seed gives different noise.
    pub seed: u32,
    /// The largest number of scattering events of a path. If it is `None`, only Russian roulette ends paths, without
    /// bias.
    pub max_depth: Option<u32>,
    /// The brightest indirect light: what one scattering event after the first may add to a sample, as the radiance of
    /// its largest channel, above 0. Brighter light is scaled down to it, which removes fireflies and darkens the
    /// picture. If it is `None`, there is no limit and no bias.
    pub clamp_indirect: Option<f32>,
    /// The number of samples of each pixel, at least 1, that fill a [`RadianceCache`](crate::RadianceCache) before
    /// rendering. The cache grows to an eighth of the picture's samples. Paths end at their second hit, which is faster
    /// and has less noise, but has a small bias, which falls with the samples. If it is `None`, paths are traced to
    /// their ends, without bias.
    pub radiance_cache: Option<u32>,
}

impl Settings {
    /// A whole picture of this size: multi-scale, with the tent filter, seed 0 and no limits of depth and brightness,
    /// and without a radiance cache.
    pub fn new(size: [usize; 2]) -> Self {
        Settings {
            size,
            crop: None,
            mode: Mode::MultiScale,
            filter: Filter::Tent,
            seed: 0,
            max_depth: None,
            clamp_indirect: None,
            radiance_cache: None,
        }
    }

    /// The area that is rendered: left column, top row, width and height.
    pub fn area(&self) -> [usize; 4] {
        self.crop.unwrap_or([0, 0, self.size[0], self.size[1]])
    }
}
