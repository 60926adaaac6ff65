//! Renders scenes with any of the reflectance models of [`vellus_models`].
//!
//! The path tracer of [`vellus_render`] is generic over the model, so that its inner loops are compiled for each one.
//! This crate contains these copies. No other crate names all models and the path tracer, so crates that depend on this
//! one do not compile them again.
#![warn(clippy::print_stdout)]

use vellus::{Bcsdf, Fiber};
use vellus_models::yan2015::Profiles;
use vellus_models::{
    AnyModel, Chiang2016, DEon2011, Error, KajiyaKay1989, Marschner2003, ModelKind, Yan2015, ZinkeWeber2007,
};
use vellus_render::World;
use vellus_scene::Scene;

/// A reflectance model and its options.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Method {
    /// The model.
    pub kind: ModelKind,
    /// Refractive index of the medulla, only for [`ModelKind::Yan2015`]. The default is that of the cortex.
    pub eta_m: Option<f32>,
    /// Only for [`ModelKind::Yan2015`]: evaluate it as it was published, with these tables. See
    /// [`Yan2015::as_published`].
    pub published: Option<&'static Profiles>,
}

impl From<ModelKind> for Method {
    fn from(kind: ModelKind) -> Self {
        Method { kind, eta_m: None, published: None }
    }
}

/// Evaluates an expression with `$make` as the constructor of the method's model.
macro_rules! with_constructor {
    ($method:expr, $make:ident => $body:expr) => {
        with_constructor!(@ $method, $make, $body,
            ModelKind::Vellus => Bcsdf::new,
            ModelKind::Yan2015 => |fiber: &Fiber| $method.yan2015(fiber),
            ModelKind::Chiang2016 => Chiang2016::new,
            ModelKind::DEon2011 => DEon2011::new,
            ModelKind::ZinkeWeber2007 => ZinkeWeber2007::new,
            ModelKind::Marschner2003 => Marschner2003::new,
            ModelKind::KajiyaKay1989 => KajiyaKay1989::new)
    };
    (@ $method:expr, $make:ident, $body:expr, $($kind:path => $constructor:expr),*) => {
        match $method.kind {
            $($kind => {
                let $make = $constructor;
                $body
            })*
        }
    };
}

impl Method {
    /// A model with this refractive index of the medulla, or with that of the cortex.
    ///
    /// # Errors
    /// [`Error::OneIndex`] if there is an index and the model is not [`ModelKind::Yan2015`].
    pub fn new(kind: ModelKind, eta_m: Option<f32>) -> Result<Self, Error> {
        if eta_m.is_some() && kind != ModelKind::Yan2015 {
            return Err(Error::OneIndex(kind));
        }
        Ok(Method { eta_m, ..kind.into() })
    }

    /// The model of one fibre.
    ///
    /// # Errors
    /// A parameter of the fibre, or [`Method::eta_m`], out of its range.
    pub fn model(&self, fiber: &Fiber) -> Result<AnyModel, Error> {
        match self.kind {
            ModelKind::Yan2015 => Ok(AnyModel::Yan2015(self.yan2015(fiber)?)),
            kind => kind.model(fiber),
        }
    }

    /// Prepares a scene for rays, with this model for its strands.
    ///
    /// # Errors
    /// As [`World::with_model`].
    pub fn world(&self, scene: Scene) -> Result<World, vellus_scene::Error> {
        with_constructor!(self, make => World::with_model(scene, make))
    }

    /// Sets this model for all strands of a world.
    ///
    /// # Errors
    /// As [`World::set_model`]. The world is then unchanged.
    pub fn apply(&self, world: &mut World) -> Result<(), vellus_scene::Error> {
        with_constructor!(self, make => world.set_model(make))
    }

    fn yan2015(&self, fiber: &Fiber) -> Result<Yan2015, vellus::Error> {
        let model = Yan2015::with_eta_m(fiber, self.eta_m.unwrap_or(fiber.eta))?;
        Ok(match self.published {
            Some(profiles) => model.as_published(profiles),
            None => model,
        })
    }
}
