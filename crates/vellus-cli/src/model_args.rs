//! A reflectance model on the command line, by its name.

use anyhow::{Result, bail};
use vellus::{Bcsdf, Fiber};
use vellus_models::{AnyModel, Chiang2016, DEon2011, KajiyaKay1989, Marschner2003, ModelKind, Yan2015, ZinkeWeber2007};
use vellus_render::World;
use vellus_scene::Scene;

/// Which model.
#[derive(clap::Args, Clone)]
pub struct ModelArgs {
    /// The reflectance model: vellus (ours), yan2015, chiang2016, deon2011, zinke-weber2007, marschner2003, kajiya-kay1989.
    #[arg(long, default_value = "vellus", value_name = "NAME")]
    pub model: String,
    /// Refractive index of the medulla, of yan2015 only; default: that of the cortex.
    #[arg(long, value_name = "INDEX")]
    pub eta_m: Option<f32>,
}

impl ModelArgs {
    /// `fox`, or `fox-marschner2003`: for file names.
    pub fn file(&self, fiber: &str) -> Result<String> {
        let kind: ModelKind = self.model.parse()?;
        Ok(if kind == ModelKind::Vellus { fiber.to_owned() } else { format!("{fiber}-{kind}") })
    }

    /// The model it names.
    pub fn kind(&self) -> Result<ModelKind> {
        let kind: ModelKind = self.model.parse()?;
        if self.eta_m.is_some() && kind != ModelKind::Yan2015 {
            bail!("--eta-m: {kind} has one refractive index; only yan2015 takes two");
        }
        Ok(kind)
    }

    /// Refuses a model or an index that is not known, before long work.
    pub fn check(&self) -> Result<()> {
        // Of any fibre: its refractive index is in the same range.
        self.load(&Fiber::hair()).map(|_| ())
    }

    /// Its name and what was set of it: `yan2015, η_m 1.4`.
    pub fn name(&self) -> Result<String> {
        let kind = self.kind()?;
        Ok(self.eta_m.map_or_else(|| kind.to_string(), |eta_m| format!("{kind}, η_m {eta_m}")))
    }

    /// The model of a fibre, and its name.
    pub fn load(&self, fiber: &Fiber) -> Result<Named> {
        let kind = self.kind()?;
        let model = match self.eta_m {
            None => kind.model(fiber)?,
            Some(eta_m) => AnyModel::Yan2015(Yan2015::with_eta_m(fiber, eta_m)?),
        };
        Ok(Named { kind, name: self.name()?, model })
    }

    /// A scene ready for rays, its strands scattering by this model.
    pub fn world(&self, scene: Scene) -> Result<World> {
        let yan2015 = |fiber: &Fiber| Yan2015::with_eta_m(fiber, self.eta_m.unwrap_or(fiber.eta));
        Ok(match self.kind()? {
            ModelKind::Vellus => World::with_model(scene, Bcsdf::new),
            ModelKind::Yan2015 => World::with_model(scene, yan2015),
            ModelKind::Chiang2016 => World::with_model(scene, Chiang2016::new),
            ModelKind::DEon2011 => World::with_model(scene, DEon2011::new),
            ModelKind::ZinkeWeber2007 => World::with_model(scene, ZinkeWeber2007::new),
            ModelKind::Marschner2003 => World::with_model(scene, Marschner2003::new),
            ModelKind::KajiyaKay1989 => World::with_model(scene, KajiyaKay1989::new),
        }?)
    }
}

/// Has the strands of a world scatter as in 2015, sampled as it was then.
pub fn set_published(world: &mut World) -> Result<()> {
    Ok(world.set_model(|fiber| Ok(Yan2015::new(fiber)?.sampled_as_published()))?)
}

/// Has the strands of a world scatter by a model; `eta_m` is for yan2015.
pub fn set_model(world: &mut World, kind: ModelKind, eta_m: Option<f32>) -> Result<()> {
    match kind {
        ModelKind::Vellus => world.set_model(Bcsdf::new),
        ModelKind::Yan2015 => world.set_model(|fiber| Yan2015::with_eta_m(fiber, eta_m.unwrap_or(fiber.eta))),
        ModelKind::Chiang2016 => world.set_model(Chiang2016::new),
        ModelKind::DEon2011 => world.set_model(DEon2011::new),
        ModelKind::ZinkeWeber2007 => world.set_model(ZinkeWeber2007::new),
        ModelKind::Marschner2003 => world.set_model(Marschner2003::new),
        ModelKind::KajiyaKay1989 => world.set_model(KajiyaKay1989::new),
    }?;
    Ok(())
}

/// A model with its name, for titles.
pub struct Named {
    pub kind: ModelKind,
    name: String,
    pub model: AnyModel,
}

impl Named {
    /// `fox`, or `fox, marschner2003`: ours needs no name.
    pub fn title(&self, fiber: &str) -> String {
        if self.kind == ModelKind::Vellus { fiber.to_owned() } else { format!("{fiber}, {}", self.name) }
    }
}
