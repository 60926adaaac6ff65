//! The forward model: the measurement that a fibre with given parameters predicts.

use crate::aperture::{Aperture, distance};
use crate::error::Error;
use crate::parameters::{Curve, Kind, Parameter, habits};
use crate::profile::Profile;
use crate::specimen::Specimen;
use rayon::prelude::*;
use std::collections::VecDeque;
use std::f64::consts::FRAC_PI_2;
use std::sync::{Mutex, PoisonError};
use vellus::{Bcsdf, Fiber, Model, Parameter as FiberParameter};
use vellus_models::{AnyModel, Chiang2016, Directions, Marschner2003, ModelKind, Yan2015, gauss_legendre};
use wide::f32x8;

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
        use FiberParameter::{G, Kappa, Layers, MedullaAir, SigmaMa, SigmaMs};
        match self.0 {
            ModelKind::Yan2015 => !matches!(kind, Kind::Fiber(MedullaAir, _)),
            ModelKind::Vellus => kind != Kind::EtaM,
            // Models of hair have no medulla, and their surface is an ordinary interface.
            _ => !matches!(kind, Kind::EtaM | Kind::Fiber(Kappa | SigmaMs | SigmaMa | G | Layers | MedullaAir, _)),
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
        // In units of the profile: `Space` multiplies it with the profile's median.
        let (name, kind, curve) = ("background".to_owned(), Kind::Background, Curve::Log { offset: 0.1 });
        all.push(Parameter { kind, name, unit: "", low: 0.0, high: 1e30, usual: [0.0, 0.3], curve, step: 4e-3 });
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

    /// The same without the approximations of far fields: by quadrature of the near field over the offset. It takes
    /// about a hundred times as long for [`ModelKind::Vellus`]. The other models are exact in both.
    ///
    /// # Errors
    /// As [`Forward::values`].
    pub fn exact_values(
        self,
        specimen: &Specimen,
        theta_o: f64,
        directions: &Directions,
        out: &mut [[f32; 3]],
    ) -> Result<(), Error> {
        match self.0 {
            ModelKind::Vellus => {
                quadrature(&Bcsdf::new(&specimen.fiber)?, theta_o, directions, out);
                Ok(())
            }
            _ => self.values(specimen, theta_o, directions, out),
        }
    }

    /// The values that a profile would have without scale and background in directions `angles` (θ, φ in degrees):
    /// averages over its cells, of its quantity.
    ///
    /// # Errors
    /// As [`Forward::values`].
    pub fn averages(
        self,
        specimen: &Specimen,
        theta_o: f64,
        profile: &Profile,
        angles: &[[f64; 2]],
    ) -> Result<Vec<[f64; 3]>, Error> {
        let cells = Aperture::new(profile.blur, profile.quantity, angles.iter().copied(), distance(&specimen.fiber));
        let mut values = vec![[0.0; 3]; cells.angles().len()];
        self.values(specimen, theta_o, &Directions::new(cells.angles()), &mut values)?;
        Ok(cells.averages(&values))
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

/// The bounds of the number of offsets of [`quadrature`] on each side of the edge of the medulla.
const OFFSETS: [f64; 2] = [64.0, 1536.0];

/// The far field as the average of the near field over the offset, by Gauss–Legendre quadrature, without the
/// approximations of windows.
///
/// With h = sin γ, exit azimuths Φ_p turn by at most 2(p + 1) per radian of γ (Yan17 Table 2), and points are at most
/// π²/4n apart. The widest lobes have p = 2. n = 16/β_n puts them one standard deviation apart, where the error of the
/// rule is far below single precision. Light that misses the medulla begins at h = κη′, with η′ by Bravais.
fn quadrature(bcsdf: &Bcsdf, theta_o: f64, directions: &Directions, out: &mut [[f32; 3]]) {
    let fiber = bcsdf.fiber();
    let (sin, cos) = theta_o.to_radians().sin_cos();
    let eta = f64::from(fiber.eta);
    let edge = (f64::from(fiber.kappa) * (eta * eta - sin * sin).sqrt() / cos).min(1.0);
    let count = (16.0 / f64::from(fiber.beta_n)).clamp(OFFSETS[0], OFFSETS[1]);
    let rule = gauss_legendre(4 * (count / 4.0).ceil() as usize);
    let panel = |radius: f64, first: f64| {
        let half = 0.5 * (FRAC_PI_2 - first);
        rule.iter().flat_map(move |[x, weight]| {
            let t = first + half * (1.0 + x);
            let (h, share) = (radius * t.sin(), 0.5 * weight * half * radius * t.cos());
            [[h, share], [-h, share]]
        })
    };
    let inner = (edge > 0.0).then(|| panel(edge, 0.0));
    let outer = (edge < 1.0).then(|| panel(1.0, edge.asin()));
    let offsets: Vec<[f64; 2]> = inner.into_iter().flatten().chain(outer.into_iter().flatten()).collect();
    let wo = vellus_models::direction(theta_o, 0.0).to_array().map(f32x8::splat);
    // The number of offsets is a multiple of 8.
    let eight = |chunk: &[[f64; 2]], k: usize| f32x8::new(std::array::from_fn(|i| chunk[i][k] as f32));
    let hits: Vec<_> = offsets.chunks_exact(8).map(|chunk| (bcsdf.at8(wo, eight(chunk, 0)), eight(chunk, 1))).collect();
    out.par_iter_mut().zip(directions.vectors()).for_each(|(out, wi)| {
        let wi = wi.to_array().map(f32x8::splat);
        let mut sum = [f32x8::ZERO; 3];
        for (hit, share) in &hits {
            let total = hit.eval_pdf8(wi).0.total();
            (0..3).for_each(|c| sum[c] += total[c] * *share);
        }
        *out = sum.map(f32x8::reduce_add);
    });
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
