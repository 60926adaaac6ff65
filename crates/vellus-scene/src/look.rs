//! The look of a kind of fibre: its constant parameters, and parameters from textures at the roots of strands.

use crate::error::{Error, invalid};
use std::str::FromStr;
use vellus::{Fiber, Parameter};

/// A texture for a parameter. The value is the RGB of the texture at the root's uv, times `scale`, in the units of
/// files (angles in degrees). Scalars use red. Values out of range become the nearest value in range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Value {
    /// Index of the texture in [`Scene::textures`](crate::Scene::textures).
    pub texture: usize,
    /// A finite factor for each channel.
    pub scale: [f32; 3],
}

/// The meaning of a reflectance: see [`Fiber::reflectance`] and `reflectance` in
/// [`Strands::varying`](crate::Strands::varying) and in textures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ReflectanceOf {
    /// The colour that this groom shows in white light, with its depth and its skin. The renderer measures it.
    #[default]
    Groom,
    /// The colour of a dense coat of the same fibres: see [`vellus::CoatColors`].
    Dense,
}

impl FromStr for ReflectanceOf {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        match name {
            "groom" => Ok(ReflectanceOf::Groom),
            "dense" => Ok(ReflectanceOf::Dense),
            _ => Err(format!("'{name}' is not groom or dense")),
        }
    }
}

/// The look of a kind of fibre.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// The name in messages.
    pub name: String,
    /// The fibre. Textures, and [`Strands::varying`](crate::Strands::varying), replace some of its parameters.
    pub fiber: Fiber,
    /// Parameters from textures. They are set in this order.
    pub textured: Vec<(Parameter, Value)>,
}

impl Look {
    /// A look without textures.
    pub fn constant(name: impl Into<String>, fiber: Fiber) -> Self {
        Look { name: name.into(), fiber, textured: Vec::new() }
    }

    /// Checks that the fibre is in range, that the textures are among the `textures` of the scene, and that their
    /// factors are finite.
    ///
    /// # Errors
    /// [`Error::Fiber`] for the fibre, [`Error::Invalid`] for a texture.
    pub fn validate(&self, textures: usize) -> Result<(), Error> {
        self.fiber.validate().map_err(|what| Error::Fiber { place: self.name.clone(), what })?;
        for (parameter, value) in &self.textured {
            if !parameter.varies() {
                return Err(invalid(&self.name, format!("{parameter} is one for all strands: it has no texture")));
            }
            if value.texture >= textures {
                let what = format!("{parameter} has the texture {}, but the scene has {textures}", value.texture);
                return Err(invalid(&self.name, what));
            }
            if !value.scale.iter().all(|x| x.is_finite()) {
                let what = format!("{parameter} has a texture with the scale {:?}: it must be finite", value.scale);
                return Err(invalid(&self.name, what));
            }
        }
        Ok(())
    }
}
