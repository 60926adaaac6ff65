//! Light linking: which objects a light lights, which objects cast shadows, and gains of its light (UsdLuxLightAPI).

use crate::error::{Error, invalid};

/// The largest number of lights times objects of a scene with links. The renderer needs up to 13 bytes for each.
pub const MAX_LINKED: usize = 1 << 26;

/// Some of the sets of strands and meshes of a scene, by their names. Prototypes count like other objects.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Objects {
    /// All but those with these names.
    Except(Vec<String>),
    /// Only those with these names.
    Only(Vec<String>),
}

impl Objects {
    /// All objects.
    pub const ALL: Objects = Objects::Except(Vec::new());

    /// No object.
    pub const NONE: Objects = Objects::Only(Vec::new());
}

/// What a light lights, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// The objects that it lights. Light that they scatter reaches all other objects.
    pub lit: Objects,
    /// The objects that cast shadows in its light.
    pub casters: Objects,
    /// A factor of the light that diffuse parts scatter: the base of a mesh, and the medulla of a fibre (TTˢ and
    /// TRTˢ). At least 0; 1 changes nothing.
    pub diffuse: f32,
    /// A factor of the light that specular parts scatter: the coat of a mesh or its metal, and all other lobes of a
    /// fibre. At least 0; 1 changes nothing.
    pub specular: f32,
}

impl Default for Link {
    /// Changes nothing.
    fn default() -> Self {
        Link { lit: Objects::ALL, casters: Objects::ALL, diffuse: 1.0, specular: 1.0 }
    }
}

impl Link {
    /// Checks that the gains are finite and not negative.
    ///
    /// # Errors
    /// [`Error::Invalid`] if they are not.
    pub fn validate(&self) -> Result<(), Error> {
        let is_gain = |x: f32| x.is_finite() && x >= 0.0;
        if is_gain(self.diffuse) && is_gain(self.specular) {
            Ok(())
        } else {
            let what = format!("its gains are {} and {}: they must not be negative", self.diffuse, self.specular);
            Err(invalid("link of a light", what))
        }
    }
}
