//! The parameters of a fit: their names, ranges, and the variables they are fitted in.

use crate::forward::{Forward, Specimen};
use vellus::Fiber;

/// The variable u a parameter x is fitted in. Errors are nearly symmetric in it, and a step means as much anywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Curve {
    /// u = x.
    Linear,
    /// u = ln(x + offset): logarithmic, but 0 can be reached.
    Log {
        /// Below it the variable is nearly linear.
        offset: f64,
    },
    /// u = −ln(1 − x): the width of the forward peak is some 1 − g.
    Peak,
}

impl Curve {
    /// u of x.
    pub fn variable(self, x: f64) -> f64 {
        match self {
            Curve::Linear => x,
            Curve::Log { offset } => (x + offset).ln(),
            Curve::Peak => -(-x).ln_1p(),
        }
    }

    /// x of u.
    pub fn value(self, u: f64) -> f64 {
        match self {
            Curve::Linear => u,
            Curve::Log { offset } => u.exp() - offset,
            Curve::Peak => -(-u).exp_m1(),
        }
    }

    /// dx/du at x.
    pub fn slope(self, x: f64) -> f64 {
        match self {
            Curve::Linear => 1.0,
            Curve::Log { offset } => x + offset,
            Curve::Peak => 1.0 - x,
        }
    }
}

/// What is fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// η
    Eta,
    /// η_m of Yan et al. 2015; η is then the cortex'.
    EtaM,
    /// κ
    Kappa,
    /// α
    Alpha,
    /// β_m
    BetaM,
    /// β_n
    BetaN,
    /// σ_c,a of one channel, or of all of a grey profile.
    SigmaCa(usize),
    /// σ_m,s
    SigmaMs,
    /// σ_m,a of one channel, or of all of a grey profile.
    SigmaMa(usize),
    /// g
    G,
    /// l
    Layers,
    /// Inclination of the fixed direction: as the profile states it unless it is freed.
    ThetaO,
    /// What the model's values are multiplied with: a measurement's unit is arbitrary.
    Scale,
}

/// One parameter, with the name, unit and range it has in files; angles in degrees.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Which.
    pub kind: Kind,
    /// As in files, with the channel where there is one: `sigma_ca.r`.
    pub name: String,
    /// `°` or nothing.
    pub unit: &'static str,
    /// Smallest value allowed.
    pub low: f64,
    /// Largest value allowed.
    pub high: f64,
    /// Where fibres usually are: starts are drawn from it, and an error is large when it is much of it.
    pub usual: [f64; 2],
    /// The variable it is fitted in.
    pub curve: Curve,
    /// Half the distance of the two points of a difference quotient, in that variable: large against what single precision
    /// leaves of the model's values (1e-6 of them), small against the scale on which lobes move.
    pub step: f64,
}

/// Light passes two radii at most: what it loses is linear in σ up to about that, and errors then symmetric in σ itself.
const LITTLE: f64 = 0.3;

/// All parameters that a model of a profile with 1 or 3 channels has, in the order of files.
pub fn parameters(model: Forward, channels: usize) -> Vec<Parameter> {
    let log = |offset| Curve::Log { offset };
    let mut all = Vec::new();
    let mut add = |kind, name: &str, unit, [low, high]: [f64; 2], usual, curve, step| {
        if model.has(kind) {
            all.push(Parameter { kind, name: name.to_owned(), unit, low, high, usual, curve, step });
        }
    };
    let colored = |name: &str, c: usize| match channels {
        1 => name.to_owned(),
        _ => format!("{name}.{}", ["r", "g", "b"][c]),
    };
    add(Kind::Kappa, "kappa", "", [0.0, 0.99], [0.2, 0.95], Curve::Linear, 2e-3);
    add(Kind::Eta, "eta", "", [1.0, 3.0], [1.15, 1.75], Curve::Linear, 2e-3);
    add(Kind::EtaM, "eta_m", "", [1.0, 3.0], [1.15, 1.75], Curve::Linear, 2e-3);
    add(Kind::Alpha, "alpha", "°", [-45.0, 45.0], [0.0, 6.0], Curve::Linear, 0.03);
    add(Kind::BetaM, "beta_m", "°", [0.1, 90.0], [2.0, 15.0], log(0.0), 4e-3);
    add(Kind::BetaN, "beta_n", "°", [0.1, 90.0], [1.0, 25.0], log(0.0), 4e-3);
    for c in 0..channels {
        add(Kind::SigmaCa(c), &colored("sigma_ca", c), "", [0.0, 1000.0], [0.0, 2.0], log(LITTLE), 4e-3);
    }
    add(Kind::SigmaMs, "sigma_ms", "", [0.0, 1000.0], [0.3, 6.0], log(LITTLE), 4e-3);
    for c in 0..channels {
        add(Kind::SigmaMa(c), &colored("sigma_ma", c), "", [0.0, 1000.0], [0.0, 1.0], log(LITTLE), 4e-3);
    }
    add(Kind::G, "g", "", [0.0, 0.95], [0.0, 0.85], Curve::Peak, 4e-3);
    add(Kind::Layers, "layers", "", [0.0, 20.0], [0.3, 3.0], log(0.05), 4e-3);
    add(Kind::ThetaO, "theta_o", "°", [-89.0, 89.0], [-80.0, 80.0], Curve::Linear, 0.03);
    add(Kind::Scale, "scale", "", [1e-30, 1e30], [0.1, 10.0], log(0.0), 4e-3);
    all
}

/// What parameter values say: the fibre, the inclination of ω_o in degrees, the scale.
pub(crate) fn assemble(parameters: &[Parameter], values: &[f64]) -> (Specimen, f64, f64) {
    // What a model does not have is that of a hair without medulla.
    let mut fiber = Fiber::hair();
    let mut eta_m = None;
    let (mut theta_o, mut scale) = (0.0, 1.0);
    for (p, &x) in parameters.iter().zip(values) {
        // A number just beyond its range for rounding is held to it.
        let v = x.clamp(p.low, p.high);
        match p.kind {
            Kind::Eta => fiber.eta = v as f32,
            Kind::EtaM => eta_m = Some(v as f32),
            Kind::Kappa => fiber.kappa = v as f32,
            Kind::Alpha => fiber.alpha = v.to_radians() as f32,
            Kind::BetaM => fiber.beta_m = v.to_radians() as f32,
            Kind::BetaN => fiber.beta_n = v.to_radians() as f32,
            Kind::SigmaCa(c) => fiber.sigma_ca[c..].fill(v as f32),
            Kind::SigmaMs => fiber.sigma_ms = v as f32,
            Kind::SigmaMa(c) => fiber.sigma_ma[c..].fill(v as f32),
            Kind::G => fiber.g = v as f32,
            Kind::Layers => fiber.layers = v as f32,
            Kind::ThetaO => theta_o = v,
            Kind::Scale => scale = v,
        }
    }
    (Specimen { fiber, eta_m }, theta_o, scale)
}

/// The values that say that.
pub(crate) fn values_of(parameters: &[Parameter], fiber: &Fiber, theta_o: f64, scale: f64) -> Vec<f64> {
    let degrees = |x: f32| f64::from(x).to_degrees();
    let value = |kind| match kind {
        Kind::Eta => fiber.eta.into(),
        // Starts are presets, whose medulla has the cortex' index.
        Kind::EtaM => fiber.eta.into(),
        Kind::Kappa => fiber.kappa.into(),
        Kind::Alpha => degrees(fiber.alpha),
        Kind::BetaM => degrees(fiber.beta_m),
        Kind::BetaN => degrees(fiber.beta_n),
        Kind::SigmaCa(c) => fiber.sigma_ca[c].into(),
        Kind::SigmaMs => fiber.sigma_ms.into(),
        Kind::SigmaMa(c) => fiber.sigma_ma[c].into(),
        Kind::G => fiber.g.into(),
        Kind::Layers => fiber.layers.into(),
        Kind::ThetaO => theta_o,
        Kind::Scale => scale,
    };
    parameters.iter().map(|p| value(p.kind).clamp(p.low, p.high)).collect()
}
