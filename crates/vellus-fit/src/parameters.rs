//! The parameters of a fit: their ranges, and the variables the fit moves in.

use crate::error::Error;
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

/// σ is known to be 0 where it is far below this: light passes two radii at most.
const LITTLE: f64 = 0.02;

/// All parameters of a profile with 1 or 3 channels, in the order of files.
pub fn parameters(channels: usize) -> Vec<Parameter> {
    let log = |offset| Curve::Log { offset };
    let mut all = Vec::new();
    let mut add = |kind, name: &str, unit, [low, high]: [f64; 2], usual, curve, step| {
        all.push(Parameter { kind, name: name.to_owned(), unit, low, high, usual, curve, step });
    };
    let colored = |name: &str, c: usize| match channels {
        1 => name.to_owned(),
        _ => format!("{name}.{}", ["r", "g", "b"][c]),
    };
    add(Kind::Kappa, "kappa", "", [0.0, 0.99], [0.2, 0.95], Curve::Linear, 2e-3);
    add(Kind::Eta, "eta", "", [1.0, 3.0], [1.15, 1.75], Curve::Linear, 2e-3);
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
pub(crate) fn assemble(parameters: &[Parameter], values: &[f64]) -> (Fiber, f64, f64) {
    let mut fiber = Fiber::hair();
    let (mut theta_o, mut scale) = (0.0, 1.0);
    for (p, &x) in parameters.iter().zip(values) {
        // A number just beyond its range for rounding is held to it.
        let v = x.clamp(p.low, p.high);
        match p.kind {
            Kind::Eta => fiber.eta = v as f32,
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
    (fiber, theta_o, scale)
}

/// The values that say that.
pub(crate) fn values_of(parameters: &[Parameter], fiber: &Fiber, theta_o: f64, scale: f64) -> Vec<f64> {
    let degrees = |x: f32| f64::from(x).to_degrees();
    let value = |kind| match kind {
        Kind::Eta => fiber.eta.into(),
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

/// Where the value of a parameter comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// Fitted: the number of its variable. Tied parameters share one.
    Free(usize),
    /// Given.
    Fixed(f64),
}

/// What is asked of the parameters, by name. A colour's name without channel means each of its channels.
#[derive(Clone, Debug, Default)]
pub struct Requests {
    /// Held at a value, or at one for each channel.
    pub fix: Vec<(String, Vec<f64>)>,
    /// The first has the value of the second.
    pub tie: Vec<(String, String)>,
    /// Fitted, though it usually is not.
    pub free: Vec<String>,
}

/// The parameters of one fit, and the variables it moves in.
#[derive(Clone, Debug)]
pub struct Space {
    /// All parameters.
    pub parameters: Vec<Parameter>,
    /// Where the value of each comes from.
    pub sources: Vec<Source>,
    /// The parameter each variable is named after.
    pub leads: Vec<usize>,
    /// Ends of each variable's range.
    pub bounds: Vec<[f64; 2]>,
}

impl Space {
    /// The space of a profile of `channels`, lit or seen from `theta_o`.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a name that is not known, a value out of range, or requests that contradict each other.
    pub fn new(channels: usize, theta_o: f64, requests: &Requests) -> Result<Self, Error> {
        let parameters = parameters(channels);
        let mut given: Vec<Option<f64>> = vec![None; parameters.len()];
        let find = |name: &str| -> Result<Vec<usize>, Error> {
            let found: Vec<usize> = (0..parameters.len())
                .filter(|&i| parameters[i].name == name || parameters[i].name.split('.').next() == Some(name))
                .collect();
            if found.is_empty() {
                let known: Vec<&str> = parameters.iter().map(|p| p.name.as_str()).collect();
                return Err(Error::Parameter(format!("unknown parameter '{name}': known are {}", known.join(", "))));
            }
            Ok(found)
        };
        for (i, p) in parameters.iter().enumerate() {
            if p.kind == Kind::ThetaO {
                given[i] = Some(theta_o);
            }
        }
        for name in &requests.free {
            find(name)?.into_iter().for_each(|i| given[i] = None);
        }
        for (name, values) in &requests.fix {
            let places = find(name)?;
            if values.len() != 1 && values.len() != places.len() {
                let count =
                    if places.len() == 1 { "one value".to_owned() } else { format!("one value or {}", places.len()) };
                return Err(Error::Parameter(format!("{name} takes {count}, not {}", values.len())));
            }
            for (k, &i) in places.iter().enumerate() {
                let (x, p) = (values[if values.len() == 1 { 0 } else { k }], &parameters[i]);
                if !(p.low..=p.high).contains(&x) {
                    let unit = if p.unit.is_empty() { "" } else { " degrees" };
                    return Err(Error::Parameter(format!(
                        "{} = {x} is out of range: it must be in [{}, {}]{unit}",
                        p.name, p.low, p.high
                    )));
                }
                given[i] = Some(x);
            }
        }
        // Ties as a forest: each parameter follows to the one it takes its value from.
        let mut follows: Vec<usize> = (0..parameters.len()).collect();
        let root = |follows: &[usize], mut i: usize| {
            while follows[i] != i {
                i = follows[i];
            }
            i
        };
        for (name, leader) in &requests.tie {
            let (names, leaders) = (find(name)?, find(leader)?);
            if leaders.len() != 1 && leaders.len() != names.len() {
                return Err(Error::Parameter(format!("{name} and {leader} have not the same number of channels")));
            }
            for (k, &i) in names.iter().enumerate() {
                let leader = leaders[if leaders.len() == 1 { 0 } else { k }];
                let (a, b) = (root(&follows, i), root(&follows, leader));
                if i == leader || a == b {
                    return Err(Error::Parameter(format!("{} cannot be tied to itself", parameters[i].name)));
                }
                if given[a].is_some() {
                    return Err(Error::Parameter(format!("{} cannot be both fixed and tied", parameters[a].name)));
                }
                follows[a] = b;
            }
        }
        let (mut leads, mut sources, mut bounds) = (Vec::new(), vec![Source::Fixed(0.0); parameters.len()], Vec::new());
        for (i, p) in parameters.iter().enumerate() {
            let lead = root(&follows, i);
            sources[i] = match given[lead] {
                Some(x) => Source::Fixed(x),
                None => {
                    let known = leads.iter().position(|&l| l == lead);
                    let column = known.unwrap_or_else(|| {
                        leads.push(lead);
                        let l = &parameters[lead];
                        bounds.push([l.curve.variable(l.low), l.curve.variable(l.high)]);
                        leads.len() - 1
                    });
                    let curve = parameters[lead].curve;
                    let [low, high]: [f64; 2] = bounds[column];
                    bounds[column] = [
                        low.max(curve.variable(p.low.max(parameters[lead].low))),
                        high.min(curve.variable(p.high.min(parameters[lead].high))),
                    ];
                    Source::Free(column)
                }
            };
        }
        if let Some(k) = bounds.iter().position(|[low, high]| low >= high) {
            return Err(Error::Parameter(format!(
                "{} is tied to a parameter that has no value in common with it",
                parameters[leads[k]].name
            )));
        }
        if leads.is_empty() {
            return Err(Error::Parameter("every parameter is fixed: there is nothing to fit".to_owned()));
        }
        Ok(Space { parameters, sources, leads, bounds })
    }

    /// The parameter a variable is named after.
    pub fn lead(&self, column: usize) -> &Parameter {
        &self.parameters[self.leads[column]]
    }

    /// Values of all parameters at variables `u`.
    pub fn values(&self, u: &[f64]) -> Vec<f64> {
        let value = |source: &Source| match *source {
            Source::Fixed(x) => x,
            Source::Free(column) => {
                let lead = self.lead(column);
                lead.curve.value(u[column]).clamp(lead.low, lead.high)
            }
        };
        self.sources.iter().map(value).collect()
    }

    /// Variables nearest to those values: a tied group takes its leader's.
    pub fn variables(&self, values: &[f64]) -> Vec<f64> {
        let variable = |(column, &lead): (usize, &usize)| {
            let [low, high] = self.bounds[column];
            self.parameters[lead].curve.variable(values[lead]).clamp(low, high)
        };
        self.leads.iter().enumerate().map(variable).collect()
    }

    /// The variable of a kind of parameter, if it is fitted.
    pub fn column_of(&self, kind: Kind) -> Option<usize> {
        let i = self.parameters.iter().position(|p| p.kind == kind)?;
        match self.sources[i] {
            Source::Free(column) => Some(column),
            Source::Fixed(_) => None,
        }
    }

    /// Keeps a parameter, if it is fitted, at or above a value.
    pub fn resolve(&mut self, kind: Kind, least: f64) {
        if let Some(column) = self.column_of(kind) {
            let lead = &self.parameters[self.leads[column]];
            let [low, high] = &mut self.bounds[column];
            *low = low.max(lead.curve.variable(least.max(lead.low))).min(*high - 1e-3);
        }
    }

    /// The usual range of a variable.
    pub fn usual(&self, column: usize) -> [f64; 2] {
        let lead = self.lead(column);
        let [low, high] = self.bounds[column];
        lead.usual.map(|x| lead.curve.variable(x).clamp(low, high))
    }
}
