//! Pictures as files.

use super::event::Event;
use super::goals::{End, Goals};
use super::identity::IDENTITY_NOTE;
use super::store::write;
use crate::Display;
use crate::error::Error;
use crate::film::cryptomatte::RANKS;
use crate::film::denoised::{Denoise, Denoised};
use crate::film::picture::{Notes, PixelType, check_picture};
use crate::film::{Film, Layer, layout::Layout};
use std::path::{Path, PathBuf};
use vellus_io::Digest;

/// How a film becomes files: an OpenEXR file with its layers and a PNG preview beside it, or a PNG alone.
#[derive(Clone, Debug)]
pub struct Picture {
    /// The file. With the extension `png` there is no OpenEXR file.
    pub path: PathBuf,
    /// Layers of the OpenEXR file; those that the film does not keep are left out.
    pub layers: Vec<Layer>,
    /// The type of colours in the OpenEXR file.
    pub pixel_type: PixelType,
    /// How the PNG shows the picture.
    pub display: Display,
    /// Text attributes in the header of both files: names and values. If [`BACKGROUND_NOTE`] is `transparent`, the PNG
    /// has an alpha channel.
    pub notes: Notes,
}

impl Picture {
    /// All layers in 16 bits, without notes.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Picture {
            path: path.into(),
            layers: Layer::ALL.to_vec(),
            pixel_type: PixelType::Half,
            display: Display::default(),
            notes: Vec::new(),
        }
    }

    /// Writes the files, and returns their paths. The PNG is written last: where it is, the picture is complete.
    ///
    /// `denoised` becomes layers of the OpenEXR file, and its beauty what the PNG shows.
    ///
    /// # Errors
    /// [`Error::Encode`] or [`Error::Write`].
    pub fn write(&self, film: &Film, denoised: Option<&Denoised>) -> Result<Vec<PathBuf>, Error> {
        let mut written = Vec::new();
        let png = self.path.with_extension("png");
        if self.path != png {
            write(&self.path, &film.to_exr(&self.layers, denoised, self.pixel_type, &self.notes)?)?;
            written.push(self.path.clone());
        }
        let transparent = self.notes.iter().any(|(name, value)| name == BACKGROUND_NOTE && value == "transparent");
        let encode = if transparent { Film::to_transparent_png } else { Film::to_png };
        write(&png, &encode(film, denoised.map(|denoised| &denoised.beauty[..]), self.display, &self.notes)?)?;
        written.push(png);
        Ok(written)
    }

    /// Writes the files with a denoised beauty and its parts, and reports each of them. If the denoiser fails, that is
    /// reported, and the files are written without it.
    ///
    /// # Errors
    /// As [`Picture::write`].
    pub fn write_denoised(
        &self,
        film: &Film,
        denoiser: Option<&dyn Denoise>,
        mut report: impl FnMut(Event<'_>),
    ) -> Result<Vec<PathBuf>, Error> {
        // A PNG alone shows no parts.
        let layers = if self.path.extension().is_some_and(|e| e == "png") { &[][..] } else { &self.layers };
        let denoised = denoiser.map(|denoiser| Denoised::new(denoiser, film, layers)).transpose();
        let denoised = denoised.unwrap_or_else(|error| {
            report(Event::DenoiserFailed(error));
            None
        });
        let files = self.write(film, denoised.as_ref())?;
        files.iter().for_each(|file| report(Event::Wrote(file)));
        Ok(files)
    }

    /// The most bytes that the files of a picture with this many pixels take. Noise hardly compresses.
    pub fn max_bytes(&self, pixels: u64, layout: &Layout) -> u64 {
        let count = |l: &Layer| layout.range(*l).map_or(0, |range| range.len());
        // The beauty, the lobes and the lights may be there twice: as they are, and denoised.
        let twice = self.layers.iter().filter(|l| matches!(l, Layer::Lobes | Layer::Lights)).map(count).sum::<usize>();
        let channels = 3 + twice + self.layers.iter().map(count).sum::<usize>();
        // A few channels always have 32 bits.
        let exr = if self.pixel_type == PixelType::Float { 4 * channels } else { 2 * channels + 10 };
        let crypto = Layer::CRYPTOMATTE.iter().filter(|l| self.layers.contains(l) && layout.has(**l)).count();
        let exr = exr + 8 * RANKS * crypto;
        pixels * (4 + if self.path.extension().is_some_and(|e| e == "exr") { exr as u64 } else { 0 })
    }
}

/// The notes that say how a picture ended: samples a pixel, noise, and why rendering stopped.
pub fn end_notes(film: &Film, end: End) -> Notes {
    let noise = film.noise().map_or("unknown".to_owned(), |x| format!("{x:.5}"));
    vec![
        (SAMPLES_NOTE.to_owned(), film.samples().to_string()),
        ("vellus_noise".to_owned(), noise),
        (END_NOTE.to_owned(), end.name().to_owned()),
    ]
}

/// The note with the number of samples a pixel.
pub const SAMPLES_NOTE: &str = "vellus_samples";

/// The note with the background. `transparent` gives the PNG an alpha channel.
pub const BACKGROUND_NOTE: &str = "vellus_background";

/// The note with [`End::name`].
const END_NOTE: &str = "vellus_ended_by";

/// Are the files of a picture complete? They must be undamaged, have this identity and the notes of [`end_notes`], and
/// have reached one of the goals.
pub fn is_finished(path: &Path, identity: Digest, goals: &Goals) -> bool {
    let notes = |path: &Path| check_picture(&vellus_io::read(path).ok()?).ok();
    // The PNG is written last.
    let (Some(png), Some(picture)) = (notes(&path.with_extension("png")), notes(path)) else { return false };
    let note = |notes: &Notes, name: &str| {
        notes.iter().find(|(key, _)| key == name).map(|(_, value)| value.clone()).unwrap_or_default()
    };
    let same = [&png, &picture].iter().all(|notes| note(notes, IDENTITY_NOTE) == identity.to_string());
    let samples = |notes| note(notes, SAMPLES_NOTE).parse().unwrap_or(0u64);
    let ended = note(&png, END_NOTE);
    let by = |end: End| ended == end.name();
    let reached = samples(&png) >= goals.samples
        || by(End::Noise) && goals.noise.is_some()
        || by(End::Time) && goals.time.is_some();
    same && samples(&png) == samples(&picture) && reached
}
