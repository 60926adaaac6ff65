//! Cameras (ICamera).

use crate::archive::{Archive, Object};
use crate::error::{Error, wrong};
use crate::geometry::Geometry;

/// A camera at a time. It looks along −z of its object, with y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Focal length in millimetres.
    pub focal_length: f64,
    /// Width of the film in centimetres.
    pub horizontal_aperture: f64,
    /// How far the film is to the right, in centimetres.
    pub horizontal_film_offset: f64,
    /// Height of the film in centimetres.
    pub vertical_aperture: f64,
    /// How far the film is up, in centimetres.
    pub vertical_film_offset: f64,
    /// How much wider the lens makes pictures than the film.
    pub lens_squeeze_ratio: f64,
    /// More of the picture at the left, right, top and bottom, relative to it.
    pub overscan: [f64; 4],
    /// Focal length over the diameter of the lens.
    pub f_stop: f64,
    /// The distance in focus, in centimetres.
    pub focus_distance: f64,
    /// When the shutter opens and closes, in seconds relative to the frame.
    pub shutter: [f64; 2],
    /// Distances of the near and far planes, in centimetres.
    pub clipping: [f64; 2],
}

impl Camera {
    /// The beginning of the names of this schema.
    pub const SCHEMA: &'static str = "AbcGeom_Camera_v";

    /// The numbers of the schema.
    pub(crate) fn core(&self) -> [f64; 16] {
        let [left, r, t, b] = self.overscan;
        let ([open, close], [near, far]) = (self.shutter, self.clipping);
        let film = [self.horizontal_aperture, self.horizontal_film_offset, self.vertical_aperture];
        let [width, right, height] = film;
        let (up, squeeze) = (self.vertical_film_offset, self.lens_squeeze_ratio);
        let (focal, stop, focus) = (self.focal_length, self.f_stop, self.focus_distance);
        [focal, width, right, height, up, squeeze, left, r, t, b, stop, focus, open, close, near, far]
    }

    /// Reads a camera at a time in seconds, between samples.
    ///
    /// # Errors
    /// [`Error::Damaged`], or [`Error::Property`] if it has fewer than 16 numbers.
    pub fn read(archive: &Archive, object: &Object, time: f64) -> Result<Self, Error> {
        let geometry = Geometry::new(archive, object, ".geom", time)?;
        let core = geometry.series(".core").ok_or_else(|| wrong(".core", "is missing"))?;
        let between = archive.times(core).between(time, core.samples);
        let [from, to] =
            [archive.sample(core, between.floor)?, archive.sample(core, between.ceil)?].map(|s| s.to_f64());
        let mix = |i: usize| Some(from.get(i)? + between.share * (to.get(i)? - from.get(i)?));
        let all: Option<Vec<f64>> = (0..16).map(mix).collect();
        let Some(&[focal, width, right, height, up, squeeze, left, r, t, b, stop, focus, open, close, near, far]) =
            all.as_deref().and_then(<[f64]>::first_chunk::<16>)
        else {
            return Err(wrong(".core", format!("has {} numbers: there must be 16", from.len())));
        };
        Ok(Camera {
            focal_length: focal,
            horizontal_aperture: width,
            horizontal_film_offset: right,
            vertical_aperture: height,
            vertical_film_offset: up,
            lens_squeeze_ratio: squeeze,
            overscan: [left, r, t, b],
            f_stop: stop,
            focus_distance: focus,
            shutter: [open, close],
            clipping: [near, far],
        })
    }
}
