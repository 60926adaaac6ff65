//! A digest that tells pictures apart.

use crate::film::picture::Notes;
use crate::{Error, Filter, Layer, Lod, Mode, PICTURE_VERSION, Settings};
use std::str::FromStr;
use vellus::Tables;
use vellus_io::{Digest, DigestBuilder};

/// The note with the identity of a picture, in its files and checkpoints.
pub const IDENTITY_NOTE: &str = "vellus_identity";

/// Everything but the scene that can change a pixel.
///
/// An application digests it together with what identifies its scene. Films with the same digest are of the same
/// picture: their samples may be added. The digest does not depend on where files are stored, on their times, on the
/// machine or on the compiler. Two releases that render the same pictures have the same [`PICTURE_VERSION`].
///
/// ```
/// use vellus_io::Sources;
/// use vellus_render::session::Identity;
/// use vellus_render::{Layer, Lod, Settings};
///
/// let mut sources = Sources::new();
/// sources.add("", b"the bytes of a file");
/// let identity = |seed| {
///     let settings = Settings { seed, ..Settings::new([64, 64]) };
///     let layers = [Layer::Beauty];
///     let (model, eta_m, min_pixel_width, lod) = ("vellus", None, 0.0, Lod::Off);
///     Identity { settings: &settings, layers: &layers, model, eta_m, min_pixel_width, lod }
///         .digest(sources.digest())
///         .field("frame", 12f64.to_le_bytes())
///         .finish()
/// };
/// assert_eq!(identity(1), identity(1));
/// assert_ne!(identity(1), identity(2));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Identity<'a> {
    /// How paths are traced.
    pub settings: &'a Settings,
    /// The layers of the film.
    pub layers: &'a [Layer],
    /// The name of the reflectance model.
    pub model: &'a str,
    /// The refractive index of the medulla, for models that take one.
    pub eta_m: Option<f32>,
    /// The smallest width of strands in pixels: see [`widen`](crate::widen()). 0 is off.
    pub min_pixel_width: f32,
    /// The level of detail.
    pub lod: Lod,
}

impl Identity<'_> {
    /// Begins the digest of a scene that was read from files with this digest (see [`vellus_io::Sources::digest`]). Add
    /// a field for every option of the reader that changes the scene.
    pub fn digest(&self, sources: Digest) -> DigestBuilder {
        let numbers = |numbers: &[usize]| numbers.iter().flat_map(|&n| (n as u64).to_le_bytes()).collect::<Vec<u8>>();
        let Settings { size, crop, mode, filter, seed, max_depth, clamp_indirect, radiance_cache } = self.settings;
        let (later, first): (Vec<Layer>, Vec<Layer>) =
            Layer::ALL.iter().partition(|l| **l as usize >= Layer::CryptoObject as usize);
        let has = |layer: &Layer| self.layers.contains(layer);
        let mut layers: Vec<u8> = first.iter().map(|layer| u8::from(has(layer))).collect();
        // Films without Cryptomatte, or a later layer, have the identity that they had before there was such a layer.
        layers.extend(later.iter().filter(|layer| has(layer)).map(|layer| *layer as u8));
        let digest = DigestBuilder::new()
            .field("picture version", PICTURE_VERSION.to_le_bytes())
            .field("tables", Digest::of(Tables::SHIPPED).0)
            .field("model", self.model)
            .field("eta_m", optional(self.eta_m.map(f32::to_le_bytes)))
            .field("size", numbers(size))
            .field("crop", crop.map_or_else(Vec::new, |crop| numbers(&crop)))
            .field("mode", mode.name())
            .field("filter", filter.name())
            .field("seed", seed.to_le_bytes())
            .field("max depth", optional(max_depth.map(u32::to_le_bytes)))
            .field("clamp indirect", optional(clamp_indirect.map(f32::to_le_bytes)))
            .field("min pixel width", self.min_pixel_width.to_le_bytes())
            .field("layers", layers)
            .field("sources", sources.0);
        // Pictures without a cache have the identity that they had before there were caches. The same holds for others.
        let digest = match radiance_cache {
            Some(samples) => digest.field("radiance cache with error", samples.to_le_bytes()),
            None => digest,
        };
        match self.lod {
            Lod::Off => digest,
            Lod::Bias(_) => digest.field("level of detail", self.lod.pixels().to_le_bytes()),
        }
    }

    /// The notes of a picture with these settings. `digest` is its whole identity.
    pub fn notes(&self, digest: Digest) -> Notes {
        let model = self.eta_m.map_or_else(|| self.model.to_owned(), |eta_m| format!("{}, η_m {eta_m}", self.model));
        let notes = [
            ("vellus_model", model),
            ("vellus_mode", self.settings.mode.name().to_owned()),
            ("vellus_filter", self.settings.filter.name().to_owned()),
            ("vellus_min_pixel_width", self.min_pixel_width.to_string()),
            ("vellus_lod", self.lod.to_string()),
            ("vellus_seed", self.settings.seed.to_string()),
            (IDENTITY_NOTE, digest.to_string()),
        ];
        notes.map(|(name, value)| (name.to_owned(), value)).to_vec()
    }
}

/// The bytes of a value that is set, or none.
fn optional<const N: usize>(bytes: Option<[u8; N]>) -> Vec<u8> {
    bytes.map_or_else(Vec::new, |bytes| bytes.to_vec())
}

impl Mode {
    /// All modes.
    pub const ALL: [Mode; 3] = [Mode::MultiScale, Mode::Near, Mode::Far];

    /// Its name in notes and on command lines.
    pub fn name(self) -> &'static str {
        match self {
            Mode::MultiScale => "multiscale",
            Mode::Near => "near",
            Mode::Far => "far",
        }
    }
}

impl FromStr for Mode {
    type Err = Error;

    /// Reads [`Mode::name`].
    fn from_str(name: &str) -> Result<Self, Error> {
        Mode::ALL.into_iter().find(|mode| mode.name() == name).ok_or_else(|| {
            let known = Mode::ALL.map(Mode::name).join(", ");
            Error::Settings(format!("unknown mode '{name}': known are {known}"))
        })
    }
}

impl Filter {
    /// All filters.
    pub const ALL: [Filter; 2] = [Filter::Box, Filter::Tent];

    /// Its name in notes and on command lines.
    pub fn name(self) -> &'static str {
        match self {
            Filter::Box => "box",
            Filter::Tent => "tent",
        }
    }
}

impl FromStr for Filter {
    type Err = Error;

    /// Reads [`Filter::name`].
    fn from_str(name: &str) -> Result<Self, Error> {
        Filter::ALL.into_iter().find(|filter| filter.name() == name).ok_or_else(|| {
            let known = Filter::ALL.map(Filter::name).join(", ");
            Error::Settings(format!("unknown filter '{name}': known are {known}"))
        })
    }
}
