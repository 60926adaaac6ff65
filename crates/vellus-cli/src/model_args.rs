//! A reflectance model on the command line.

use anyhow::{Context, Result};
use vellus::Fiber;
use vellus_models::ModelKind;
use vellus_plot::Named;
use vellus_render::World;
use vellus_render_models::Method;
use vellus_scene::Scene;

#[derive(clap::Args, Clone)]
pub struct ModelArgs {
    /// Reflectance model: vellus, yan2015, chiang2016, deon2011, zinke-weber2007, marschner2003 or kajiya-kay1989.
    #[arg(long, default_value = "vellus", value_name = "NAME")]
    pub model: ModelKind,
    /// Refractive index of the medulla, only for yan2015. Default: the index of the cortex.
    #[arg(long, value_name = "INDEX")]
    pub eta_m: Option<f32>,
}

impl ModelArgs {
    /// A part of file names: `fox` or `fox-marschner2003`.
    pub fn file(&self, fiber: &str) -> String {
        if self.model == ModelKind::Vellus { fiber.to_owned() } else { format!("{fiber}-{}", self.model) }
    }

    /// Checks the model and the index before long work.
    pub fn check(&self) -> Result<()> {
        // The allowed range of the index does not depend on the fibre.
        self.load("", &Fiber::hair()).map(|_| ())
    }

    /// The model of a fibre called `name`.
    pub fn load(&self, name: &str, fiber: &Fiber) -> Result<Named> {
        let named = Named::new(name, self.model, self.method()?.model(fiber)?);
        Ok(match self.eta_m {
            Some(eta_m) => named.with_detail(&format!("η_m {eta_m}")),
            None => named,
        })
    }

    /// A scene ready to render. Its strands scatter light by this model.
    pub fn world(&self, scene: Scene) -> Result<World> {
        Ok(self.method()?.world(scene)?)
    }

    fn method(&self) -> Result<Method> {
        Method::new(self.model, self.eta_m).context("--eta-m")
    }
}
