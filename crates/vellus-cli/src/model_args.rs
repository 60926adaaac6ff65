//! A reflectance model on the command line, by its name.

use anyhow::{Result, bail};
use glam::Vec3;
use vellus::{Bcsdf, Fiber, Field, Model, Window};
use vellus_models::{
    AnyHit, AnyModel, Chiang2016, DEon2011, KajiyaKay1989, Marschner2003, ModelKind, Yan2015, ZinkeWeber2007,
};
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
        let mut world = World::new(scene)?;
        set_model(&mut world, self.kind()?, self.eta_m)?;
        Ok(world)
    }
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

    /// The whole width at `wo`: hits and their weights, which sum to 1. Offsets are equidistant in γ, `n` of them; a far field is one hit.
    pub fn over_width(&self, wo: Vec3, n: usize) -> Vec<(AnyHit<'_>, f64)> {
        if self.model.field() == Field::Far {
            return vec![(self.model.at(wo, Window::far()), 1.0)];
        }
        let gamma = |k: usize| ((k as f64 + 0.5) / n as f64 - 0.5) * std::f64::consts::PI;
        let total: f64 = (0..n).map(|k| gamma(k).cos()).sum();
        (0..n).map(|k| (self.model.at(wo, Window::near(gamma(k).sin() as f32)), gamma(k).cos() / total)).collect()
    }
}

/// Offsets dense enough that the narrowest lobe does not show them one by one: exit azimuths move by up to 4° for a
/// degree of γ.
pub fn offsets(fiber: &Fiber) -> usize {
    ((2.5 * 180.0 / f64::from(fiber.beta_n.to_degrees())).ceil() as usize).clamp(64, 1024)
}
