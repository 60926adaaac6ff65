//! The forward model: the measurement that a fibre with given parameters predicts.

use crate::error::Error;
use crate::parameters::{Curve, Kind, Parameter, habits};
use crate::specimen::Specimen;
use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};
use vellus::{Bcsdf, Fiber, Model, Parameter as FiberParameter};
use vellus_models::{AnyModel, Chiang2016, Directions, Marschner2003, ModelKind, Yan2015};

/// A model whose far field can be fitted to profiles (Yan17 Sec. 5.1). The default is [`ModelKind::Vellus`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Forward(ModelKind);

impl Default for Forward {
    fn default() -> Self {
        Forward(ModelKind::Vellus)
    }
}

impl Forward {
    /// All models that can be fitted.
    pub const ALL: [Forward; 4] = [
        Forward(ModelKind::Vellus),
        Forward(ModelKind::Yan2015),
        Forward(ModelKind::Chiang2016),
        Forward(ModelKind::Marschner2003),
    ];

    /// The forward model of a kind of model.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a model that cannot be fitted.
    pub fn new(kind: ModelKind) -> Result<Self, Error> {
        Forward::ALL.into_iter().find(|f| f.0 == kind).ok_or_else(|| {
            let known: Vec<&str> = Forward::ALL.iter().map(|f| f.kind().name()).collect();
            Error::Parameter(format!("{kind} cannot be fitted: {} can", known.join(", ")))
        })
    }

    /// The kind of model.
    pub fn kind(self) -> ModelKind {
        self.0
    }

    /// Whether the model depends on a parameter.
    pub fn has(self, kind: Kind) -> bool {
        use FiberParameter::{G, Kappa, Layers, SigmaMa, SigmaMs};
        match self.0 {
            ModelKind::Yan2015 => true,
            ModelKind::Vellus => kind != Kind::EtaM,
            // Models of hair have no medulla, and their surface is an ordinary interface.
            _ => !matches!(kind, Kind::EtaM | Kind::Fiber(Kappa | SigmaMs | SigmaMa | G | Layers, _)),
        }
    }

    /// All parameters of the model for a profile with 1 or 3 channels, in the order of files.
    pub fn parameters(self, channels: usize) -> Vec<Parameter> {
        let mut all = Vec::new();
        for parameter in FiberParameter::ALL {
            let Some((usual, curve, step)) = habits(parameter) else { continue };
            let (range, unit) = (parameter.range(), parameter.unit().sign());
            for channel in 0..if parameter.channels() > 1 { channels } else { 1 } {
                let name = if channels > 1 { parameter.channel_name(channel) } else { parameter.name().to_owned() };
                let kind = Kind::Fiber(parameter, channel);
                let (low, high) = (range.low, range.high);
                all.push(Parameter { kind, name, unit, low, high, usual, curve, step });
            }
            if parameter == FiberParameter::Eta {
                let (name, low, high) = ("eta_m".to_owned(), range.low, range.high);
                all.push(Parameter { kind: Kind::EtaM, name, unit, low, high, usual, curve, step });
            }
        }
        let (name, kind, usual) = ("theta_o".to_owned(), Kind::ThetaO, [-80.0, 80.0]);
        all.push(Parameter { kind, name, unit: "°", low: -89.0, high: 89.0, usual, curve: Curve::Linear, step: 0.03 });
        let (name, kind, curve) = ("scale".to_owned(), Kind::Scale, Curve::Log { offset: 0.0 });
        all.push(Parameter { kind, name, unit: "", low: 1e-30, high: 1e30, usual: [0.1, 10.0], curve, step: 4e-3 });
        all.retain(|p| self.has(p.kind));
        all
    }

    /// Computes f·cos θᵢ, RGB, averaged over the width of the fibre. ω_o has the inclination `theta_o` (degrees) and
    /// the azimuth 0. `out` gets one value for each of the `directions`, and must have their number of elements.
    ///
    /// # Errors
    /// [`Error::Fiber`] for a parameter out of range.
    pub fn values(
        self,
        specimen: &Specimen,
        theta_o: f64,
        directions: &Directions,
        out: &mut [[f32; 3]],
    ) -> Result<(), Error> {
        self.values_with(&Recent::default(), specimen, theta_o, directions, out)
    }

    /// The same for many specimens. `recent` keeps data that they share.
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

/// The models of Yan et al. 2015 that were used last. A part of the model depends only on the refractive indices and
/// the layers. Preparing it takes as long as evaluating the far field. Nine of the dozen variables of a fit do not
/// change that part.
#[derive(Debug, Default)]
pub(crate) struct Recent(Mutex<VecDeque<([f32; 3], Yan2015)>>);

/// How many models are kept: as many as the difference quotients of two threads need.
const KEPT: usize = 8;

impl Recent {
    fn yan2015(&self, fiber: &Fiber, eta_m: f32) -> Result<Yan2015, vellus::Error> {
        let key = [fiber.eta, eta_m, fiber.layers];
        let known = |models: &VecDeque<([f32; 3], Yan2015)>| {
            models.iter().find(|(k, _)| *k == key).map(|(_, model)| model.clone())
        };
        // The list is complete even if a thread panicked.
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
