//! The layers of a picture.

use crate::error::Error;
use crate::film::cryptomatte;
use std::str::FromStr;

/// A layer of a picture. The order of the variants is that of a pixel's channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layer {
    /// RGB radiance.
    Beauty,
    /// Share of the pixel that fibres or meshes cover.
    Alpha,
    /// The square of the samples' brightness (mean of R, G and B). OpenEXR files store the variance of the pixel's mean
    /// instead, and users call this layer `variance`.
    SecondMoment,
    /// Share of the pixel that fibres cover.
    Fibers,
    /// The light that each of the six lobes scatters, for fibres that the camera sees. RGB for each lobe, in the order
    /// of [`vellus::Lobe`]. Their sum is the fibres' part of the beauty.
    Lobes,
    /// The share of light that the fibre or mesh scatters, RGB.
    Albedo,
    /// Shading normal, world space.
    Normal,
    /// Tangent of the fibre, toward the tip, world space.
    Tangent,
    /// Distance from the camera, in scene units.
    Depth,
    /// Texture coordinates at the root of the fibre.
    RootUv,
    /// Motion while the shutter is open, in pixels to the right and up.
    Motion,
    /// The light from each light group, RGB for each group. Their sum is the beauty.
    Lights,
    /// The number of the strand nearest to the camera, counted from 1 over all strands of the scene. 0 if there is
    /// none. This is not a mean, because averaged numbers would be those of other strands.
    Strand,
    /// Cryptomatte of objects: the ids of the things that cover the pixel, and how much they cover. See
    /// [`Thing::object`](crate::Thing::object).
    CryptoObject,
    /// Cryptomatte of looks and surfaces.
    CryptoLook,
    /// Cryptomatte of sets of strands.
    CryptoGroup,
    /// The error of the radiance cache: an estimate of what its noise and the size of its cells change in the
    /// brightness. OpenEXR files store its square. The mean over many pixels is about right, the value in one pixel
    /// says little. A film keeps it if the picture has a cache.
    CacheError,
}

impl Layer {
    /// All layers, in order.
    pub const ALL: [Layer; 17] = [
        Layer::Beauty,
        Layer::Alpha,
        Layer::SecondMoment,
        Layer::Fibers,
        Layer::Lobes,
        Layer::Albedo,
        Layer::Normal,
        Layer::Tangent,
        Layer::Depth,
        Layer::RootUv,
        Layer::Motion,
        Layer::Lights,
        Layer::Strand,
        Layer::CryptoObject,
        Layer::CryptoLook,
        Layer::CryptoGroup,
        Layer::CacheError,
    ];

    /// The layers of Cryptomatte. They share the counts of a film.
    pub const CRYPTOMATTE: [Layer; 3] = [Layer::CryptoObject, Layer::CryptoLook, Layer::CryptoGroup];

    /// Its number of channels in a film; 0 for [`Layer::Lights`], whose number depends on the scene, and for
    /// [`Layer::CRYPTOMATTE`], which a film keeps as counts.
    pub fn channels(self) -> usize {
        match self {
            Layer::Lights | Layer::CryptoObject | Layer::CryptoLook | Layer::CryptoGroup => 0,
            Layer::Lobes => 18,
            Layer::Alpha | Layer::SecondMoment | Layer::Fibers | Layer::Depth | Layer::Strand | Layer::CacheError => 1,
            Layer::RootUv | Layer::Motion => 2,
            _ => 3,
        }
    }

    /// Whether every film keeps the layer.
    pub(crate) fn always(self) -> bool {
        matches!(self, Layer::Beauty | Layer::Alpha | Layer::SecondMoment | Layer::Fibers)
    }

    /// The name of the layer in options, such as `uv`. [`Layer::from_str`] parses it.
    pub fn name(self) -> &'static str {
        match self {
            Layer::Beauty => "beauty",
            Layer::Alpha => "alpha",
            Layer::SecondMoment => "variance",
            Layer::Fibers => "fibers",
            Layer::Lobes => "lobes",
            Layer::Albedo => "albedo",
            Layer::Normal => "normal",
            Layer::Tangent => "tangent",
            Layer::Depth => "depth",
            Layer::RootUv => "uv",
            Layer::Motion => "motion",
            Layer::Lights => "lights",
            Layer::Strand => "id",
            Layer::CryptoObject => "crypto-object",
            Layer::CryptoLook => "crypto-look",
            Layer::CryptoGroup => "crypto-group",
            Layer::CacheError => "cache-error",
        }
    }

    /// The names of its channels in an OpenEXR file, as compositors know them: `R`, `albedo.R`, `lobe_TT.G`,
    /// `light_key.B`, `N.X`, `Z`. `groups` are the names of the light groups.
    pub(crate) fn channel_names(self, groups: &[String]) -> Vec<String> {
        let rgb = |prefix: &str| ["R", "G", "B"].map(|c| format!("{prefix}{c}")).to_vec();
        let xyz = |prefix: &str| ["X", "Y", "Z"].map(|c| format!("{prefix}.{c}")).to_vec();
        match self {
            Layer::Beauty => rgb(""),
            Layer::Alpha => vec!["A".to_owned()],
            Layer::SecondMoment => vec!["variance.V".to_owned()],
            Layer::Lobes => vellus::Lobe::ALL.iter().flat_map(|lobe| rgb(&format!("lobe_{}.", lobe.key()))).collect(),
            Layer::Albedo => rgb("albedo."),
            Layer::Normal => xyz("N"),
            Layer::Tangent => xyz("T"),
            Layer::Depth => vec!["Z".to_owned()],
            Layer::Fibers => vec!["fibers.A".to_owned()],
            Layer::RootUv => vec!["root.U".to_owned(), "root.V".to_owned()],
            Layer::Motion => vec!["motion.X".to_owned(), "motion.Y".to_owned()],
            Layer::Lights => groups.iter().flat_map(|group| rgb(&format!("light_{group}."))).collect(),
            Layer::Strand => vec!["strand.id".to_owned()],
            Layer::CacheError => vec!["cache_error.V".to_owned()],
            Layer::CryptoObject | Layer::CryptoLook | Layer::CryptoGroup => cryptomatte::channel_names(self),
        }
    }
}

impl Layer {
    /// Reads names of layers, separated by commas, or `all`: what every picture can have, without
    /// [`Layer::CacheError`].
    ///
    /// # Errors
    /// [`Error::Settings`] if there is no such layer.
    pub fn list(names: &str) -> Result<Vec<Layer>, Error> {
        if names == "all" {
            return Ok(Layer::ALL.into_iter().filter(|&layer| layer != Layer::CacheError).collect());
        }
        names.split(',').map(|name| name.trim().parse()).collect()
    }
}

impl FromStr for Layer {
    type Err = Error;

    /// Reads [`Layer::name`].
    fn from_str(name: &str) -> Result<Self, Error> {
        Layer::ALL.into_iter().find(|layer| layer.name() == name).ok_or_else(|| {
            let known = Layer::ALL.map(Layer::name).join(", ");
            Error::Settings(format!("unknown layer '{name}': known are {known}, all"))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_layer_has_its_name() {
        let list = |names: &str| Layer::list(names).map_err(|e| e.to_string());
        assert_eq!(list("depth,id"), Ok(vec![Layer::Depth, Layer::Strand]));
        assert_eq!(list("uv, lights"), Ok(vec![Layer::RootUv, Layer::Lights]));
        let all = Layer::ALL.map(Layer::name).join(",");
        assert_eq!(list(&all).map(|all| all.len()), Ok(17));
        assert_eq!(list(all.strip_suffix(",cache-error").unwrap()), list("all"));
        assert!(list("beauty,depht").unwrap_err().contains("'depht'"));
    }
}
