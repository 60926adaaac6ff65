//! The parameters of a fit: their names, ranges and variables.

use crate::error::Error;
use crate::specimen::Specimen;
use std::fmt;
use std::str::FromStr;
use vellus::Parameter as FiberParameter;
use vellus::{Fiber, ScatterExit};

/// The variable u that a fit uses for a parameter x. Errors are nearly symmetric in u, and a step of u has about the
/// same effect everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Curve {
    /// u = x.
    Linear,
    /// u = ln(x + offset): logarithmic, but x = 0 can be reached.
    Log {
        /// u is nearly linear below the offset.
        offset: f64,
    },
    /// u = −ln(1 − x), for g. The width of the forward peak is about 1 − g.
    Peak,
}

impl Curve {
    /// The variable u of a value x.
    pub fn variable(self, x: f64) -> f64 {
        match self {
            Curve::Linear => x,
            Curve::Log { offset } => (x + offset).ln(),
            Curve::Peak => -(-x).ln_1p(),
        }
    }

    /// The value x of a variable u.
    pub fn value(self, u: f64) -> f64 {
        match self {
            Curve::Linear => u,
            Curve::Log { offset } => u.exp() - offset,
            Curve::Peak => -(-u).exp_m1(),
        }
    }

    /// The derivative dx/du at x.
    pub fn slope(self, x: f64) -> f64 {
        match self {
            Curve::Linear => 1.0,
            Curve::Log { offset } => x + offset,
            Curve::Peak => 1.0 - x,
        }
    }
}

/// The meaning of one number of a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A parameter of the fibre, and its channel. The channel is 0 for a scalar. In a grey profile, channel 0 stands
    /// for all channels of a colour.
    Fiber(FiberParameter, usize),
    /// η_m of Yan et al. 2015. η is then the refractive index of the cortex only.
    EtaM,
    /// Inclination of the fixed direction. It is fixed to the value of the profile unless it is freed.
    ThetaO,
    /// The factor on the values of the model, because the unit of a measurement is arbitrary.
    Scale,
    /// Light that does not come from the fibre, the same in all directions and channels, in the unit of the profile.
    /// It is fixed to 0 unless it is freed.
    Background,
}

impl Kind {
    /// Whether this describes a measurement, not the fibre. Each profile of a joint fit then has a value of its own.
    pub fn is_of_measurement(self) -> bool {
        matches!(self, Kind::ThetaO | Kind::Scale | Kind::Background)
    }
}

/// The name of a parameter in [`Requests`](crate::Requests), the same as in files: `eta`, `sigma_ca`, `sigma_ca.r`,
/// `eta_m`, `theta_o`, `scale`, `background` and so on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Name {
    /// A parameter of the fibre. `None` means all of its channels.
    Fiber(FiberParameter, Option<usize>),
    /// η_m of Yan et al. 2015.
    EtaM,
    /// Inclination of the fixed direction.
    ThetaO,
    /// The factor on the values of the model.
    Scale,
    /// Light that does not come from the fibre.
    Background,
}

impl Name {
    /// Whether the name means this parameter. `channels` is the number of channels of the profile, 1 or 3.
    pub(crate) fn means(self, kind: Kind, channels: usize) -> bool {
        match (self, kind) {
            (Name::Fiber(name, None), Kind::Fiber(parameter, _)) => name == parameter,
            (Name::Fiber(name, Some(channel)), Kind::Fiber(parameter, c)) => {
                name == parameter && channel == c && channels > 1
            }
            (Name::EtaM, Kind::EtaM) | (Name::ThetaO, Kind::ThetaO) => true,
            (Name::Scale, Kind::Scale) | (Name::Background, Kind::Background) => true,
            _ => false,
        }
    }
}

impl FromStr for Name {
    type Err = Error;

    /// # Errors
    /// [`Error::Parameter`] for an unknown name. The message lists all names.
    fn from_str(name: &str) -> Result<Self, Error> {
        match name {
            "eta_m" => Ok(Name::EtaM),
            "theta_o" => Ok(Name::ThetaO),
            "scale" => Ok(Name::Scale),
            "background" => Ok(Name::Background),
            _ => match FiberParameter::parse(name).filter(|(parameter, _)| is_fitted(*parameter)) {
                Some((parameter, channel)) => Ok(Name::Fiber(parameter, channel)),
                None => {
                    let known = FiberParameter::ALL.into_iter().filter(|p| is_fitted(*p)).map(FiberParameter::name);
                    let known: Vec<&str> = known.chain(["eta_m", "theta_o", "scale", "background"]).collect();
                    let what = format!("unknown parameter '{name}': those of fits are {}", known.join(", "));
                    Err(Error::Parameter(what))
                }
            },
        }
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Name::Fiber(parameter, None) => f.write_str(parameter.name()),
            Name::Fiber(parameter, Some(channel)) => f.write_str(&parameter.channel_name(*channel)),
            Name::EtaM => f.write_str("eta_m"),
            Name::ThetaO => f.write_str("theta_o"),
            Name::Scale => f.write_str("scale"),
            Name::Background => f.write_str("background"),
        }
    }
}

/// Other ways to give the absorption are not fitted, because the absorption is.
fn is_fitted(parameter: FiberParameter) -> bool {
    habits(parameter).is_some()
}

/// One number of a fit, with its name, unit and range in files. Angles are in degrees.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// What it is.
    pub kind: Kind,
    /// The name in files, with the channel of a colour in an RGB profile: `sigma_ca.r`.
    pub name: String,
    /// `°` for an angle, otherwise empty.
    pub unit: &'static str,
    /// The smallest value allowed.
    pub low: f64,
    /// The largest value allowed.
    pub high: f64,
    /// The usual range for fibres. Starts are drawn from it, and standard errors are compared with it.
    pub usual: [f64; 2],
    /// The variable that the fit uses.
    pub curve: Curve,
    /// Half of the distance between the two points of a difference quotient, in that variable. It is much larger than
    /// the rounding errors of the model (1e-6 relative, in single precision), and much smaller than the widths of
    /// lobes.
    pub step: f64,
}

/// The offset of [`Curve::Log`] for absorption and scattering, per fibre radius. Light passes through at most two
/// radii. The loss of light is linear in σ up to about this value, so errors are symmetric in σ itself.
const LITTLE: f64 = 0.3;

/// The usual range, the variable and the step of a parameter of the fibre. `None` if the parameter is not fitted.
pub(crate) fn habits(parameter: FiberParameter) -> Option<([f64; 2], Curve, f64)> {
    let log = |offset| Curve::Log { offset };
    Some(match parameter {
        FiberParameter::Kappa => ([0.2, 0.95], Curve::Linear, 2e-3),
        FiberParameter::Eta => ([1.15, 1.75], Curve::Linear, 2e-3),
        FiberParameter::Alpha => ([0.0, 6.0], Curve::Linear, 0.03),
        FiberParameter::BetaM => ([2.0, 15.0], log(0.0), 4e-3),
        FiberParameter::BetaN => ([1.0, 25.0], log(0.0), 4e-3),
        FiberParameter::SigmaCa => ([0.0, 2.0], log(LITTLE), 4e-3),
        FiberParameter::SigmaMs => ([0.3, 6.0], log(LITTLE), 4e-3),
        FiberParameter::SigmaMa => ([0.0, 1.0], log(LITTLE), 4e-3),
        FiberParameter::G => ([0.0, 0.85], Curve::Peak, 4e-3),
        FiberParameter::Layers => ([0.3, 3.0], log(0.05), 4e-3),
        FiberParameter::MedullaAir => ([0.0, 1.0], Curve::Linear, 4e-3),
        _ => return None,
    })
}

/// A fibre and its measurement: what [`Cost`](crate::cost::Cost) compares with one profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Setup {
    pub specimen: Specimen,
    /// Inclination of ω_o, degrees.
    pub theta_o: f64,
    pub scale: f64,
    pub background: f64,
}

/// Converts the values of the parameters of one measurement.
pub(crate) fn assemble<'p>(exit: ScatterExit, values: impl Iterator<Item = (&'p Parameter, f64)>) -> Setup {
    // Parameters that the model does not have keep the values of a hair without medulla.
    let mut fiber = Fiber::hair().with_exit(exit);
    let mut eta_m = None;
    let (mut theta_o, mut scale, mut background) = (0.0, 1.0, 0.0);
    for (p, x) in values {
        // Rounding may move a value just out of range.
        let v = x.clamp(p.low, p.high);
        match p.kind {
            Kind::Fiber(parameter, channel) => {
                let stored = if parameter.is_angle() { v.to_radians() } else { v } as f32;
                let mut value = parameter.get(&fiber).unwrap_or_default();
                value[channel..].fill(stored);
                // Degrees in range may round to radians just out of range. `set` accepts these, but `set_nearest` would
                // change them.
                if parameter.set(&mut fiber, value).is_err() {
                    parameter.set_nearest(&mut fiber, value);
                }
            }
            Kind::EtaM => eta_m = Some(v as f32),
            Kind::ThetaO => theta_o = v,
            Kind::Scale => scale = v,
            Kind::Background => background = v,
        }
    }
    Setup { specimen: Specimen { fiber, eta_m }, theta_o, scale, background }
}

/// The values of `parameters` for a fibre, the inclination of ω_o in degrees and a scale, without a background.
pub(crate) fn values_of(parameters: &[Parameter], fiber: &Fiber, theta_o: f64, scale: f64) -> Vec<f64> {
    let value = |kind| match kind {
        Kind::Fiber(parameter, channel) => {
            let stored = f64::from(parameter.get(fiber).unwrap_or_default()[channel]);
            if parameter.is_angle() { stored.to_degrees() } else { stored }
        }
        // Starts are presets, and their medulla has the refractive index of the cortex.
        Kind::EtaM => fiber.eta.into(),
        Kind::ThetaO => theta_o,
        Kind::Scale => scale,
        Kind::Background => 0.0,
    };
    parameters.iter().map(|p| value(p.kind).clamp(p.low, p.high)).collect()
}
