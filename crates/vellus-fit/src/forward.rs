//! The forward model: what a fibre of given parameters would be measured as.

use crate::error::Error;
use crate::parameters::Kind;
use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};
use vellus::{Bcsdf, Fiber, Model};
use vellus_models::{AnyModel, Chiang2016, Directions, Marschner2003, ModelKind, Yan2015};

/// A fibre, and what only some models know of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Specimen {
    /// What all models take their parameters from.
    pub fiber: Fiber,
    /// Refractive index of the medulla, of [`ModelKind::Yan2015`] alone; that of the cortex unless given.
    pub eta_m: Option<f32>,
}

impl From<Fiber> for Specimen {
    fn from(fiber: Fiber) -> Self {
        Specimen { fiber, eta_m: None }
    }
}

/// A model that profiles are fitted with: its far field (Yan17 Sec. 5.1), ours by default.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Forward(ModelKind);

impl Default for Forward {
    fn default() -> Self {
        Forward(ModelKind::Vellus)
    }
}

impl Forward {
    /// Those there are.
    pub const ALL: [Forward; 4] = [
        Forward(ModelKind::Vellus),
        Forward(ModelKind::Yan2015),
        Forward(ModelKind::Chiang2016),
        Forward(ModelKind::Marschner2003),
    ];

    /// The far field of a model.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a model that cannot be fitted.
    pub fn new(kind: ModelKind) -> Result<Self, Error> {
        Forward::ALL.into_iter().find(|f| f.0 == kind).ok_or_else(|| {
            let known: Vec<&str> = Forward::ALL.iter().map(|f| f.kind().name()).collect();
            Error::Parameter(format!("{kind} cannot be fitted: {} can", known.join(", ")))
        })
    }

    /// Which model.
    pub fn kind(self) -> ModelKind {
        self.0
    }

    /// Does the model depend on that parameter?
    pub fn has(self, kind: Kind) -> bool {
        match self.0 {
            ModelKind::Yan2015 => true,
            ModelKind::Vellus => kind != Kind::EtaM,
            // Hair without medulla, its surface an ordinary interface.
            _ => !matches!(kind, Kind::EtaM | Kind::Kappa | Kind::SigmaMs | Kind::SigmaMa(_) | Kind::G | Kind::Layers),
        }
    }

    /// f·cos θᵢ averaged over the fibre's width, RGB, in all `directions` for ω_o at `theta_o` degrees and φ = 0.
    ///
    /// # Errors
    /// [`Error::Fiber`] where a parameter is out of range.
    pub fn values(
        self,
        specimen: &Specimen,
        theta_o: f64,
        directions: &Directions,
        out: &mut [[f32; 3]],
    ) -> Result<(), Error> {
        self.values_with(&Recent::default(), specimen, theta_o, directions, out)
    }

    /// The same, again and again.
    pub(crate) fn values_with(
        self,
        recent: &Recent,
        specimen: &Specimen,
        theta_o: f64,
        directions: &Directions,
        out: &mut [[f32; 3]],
    ) -> Result<(), Error> {
        let fiber = &specimen.fiber;
        let model = match self.0 {
            ModelKind::Yan2015 => AnyModel::Yan2015(recent.yan2015(fiber, specimen.eta_m.unwrap_or(fiber.eta))?),
            ModelKind::Chiang2016 => AnyModel::Chiang2016(Chiang2016::new(fiber)?),
            ModelKind::Marschner2003 => AnyModel::Marschner2003(Marschner2003::new(fiber)?),
            _ => AnyModel::Vellus(Bcsdf::new(fiber)?.with_fine_windows()),
        };
        model.far_field(theta_o, directions, out);
        Ok(())
    }
}

/// Models of Yan et al. 2015 that were asked for last. What of them depends on the indices and the layers alone takes as long to
/// prepare as their far field; of a dozen variables, nine leave it as it is.
#[derive(Debug, Default)]
pub(crate) struct Recent(Mutex<VecDeque<([f32; 3], Yan2015)>>);

/// As many as two threads' difference quotients need.
const KEPT: usize = 8;

impl Recent {
    fn yan2015(&self, fiber: &Fiber, eta_m: f32) -> Result<Yan2015, vellus::Error> {
        let key = [fiber.eta, eta_m, fiber.layers];
        let known = |models: &VecDeque<([f32; 3], Yan2015)>| {
            models.iter().find(|(k, _)| *k == key).map(|(_, model)| model.clone())
        };
        // A thread that panicked left the list whole.
        let lock = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(model) = known(&lock()) {
            return model.with_fiber(fiber);
        }
        let model = Yan2015::with_eta_m(fiber, eta_m)?;
        let mut models = lock();
        models.truncate(KEPT - 1);
        models.push_front((key, model.clone()));
        Ok(model)
    }
}
